//! Paths and trajectories in a joint space.
