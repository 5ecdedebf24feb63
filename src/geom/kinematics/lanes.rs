//! Numbers that are added, subtracted and multiplied: one, or eight at a time. What is written for both takes the same steps in the
//! same order, so that each of the eight is the one, to the last bit.

use std::ops::{Add, Mul, Sub};

/// One number or several.
pub(super) trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Returns the same number in every lane.
    fn of(v: f64) -> Self;
}

impl Lanes for f64 {
    #[inline(always)]
    fn of(v: f64) -> f64 {
        v
    }
}

/// Eight numbers.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Eight(pub [f64; 8]);

impl Lanes for Eight {
    #[inline(always)]
    fn of(v: f64) -> Eight {
        Eight([v; 8])
    }
}
/// Written without array methods: these are not inlined everywhere, and then the compiler finds no vectors.
macro_rules! by_lane {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Eight {
            type Output = Eight;
            #[inline(always)]
            fn $method(self, other: Eight) -> Eight {
                let mut result = [0.0; 8];
                for l in 0..8 {
                    result[l] = self.0[l] $op other.0[l];
                }
                Eight(result)
            }
        }
    };
}

by_lane!(Add, add, +);
by_lane!(Sub, sub, -);
by_lane!(Mul, mul, *);
