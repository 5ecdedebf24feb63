//! The HTN search; asks a reasoner, never sees a coordinate.
