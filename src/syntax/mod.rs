//! HATP text to AST and back; knows no names, no types.
