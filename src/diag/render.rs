//! Problems to text: the only user of `miette`.
