//! Checked AST to [`super::Domain`].
