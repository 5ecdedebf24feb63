//! Numeric inverse kinematics within joint limits.
