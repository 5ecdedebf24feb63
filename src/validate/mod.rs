//! A second opinion on a plan.
