//! The nearest right name, for "did you mean".
