//! The geometric reasoner and planner.
