//! Names and types: all problems of a domain, not the first.
