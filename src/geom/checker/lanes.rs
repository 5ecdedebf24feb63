//! Numbers of several configurations side by side, and poses made of them.
//!
//! Plain arrays whose loops the compiler makes vector instructions of. Every lane is computed by the same operations in the same order
//! whatever their number is, so that one configuration has the same pose, to the bit, alone and among others.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::array::from_fn;
use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::{ComplexField, Matrix3, Rotation3, UnitQuaternion};

use crate::geom::{Pose, Vec3};

/// A number for each configuration.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<const N: usize>(pub [f64; N]);

impl<const N: usize> Lanes<N> {
    #[inline(always)]
    pub fn all(v: f64) -> Self {
        Lanes([v; N])
    }

    #[inline(always)]
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut to = self.0;
        for v in &mut to {
            *v = f(*v);
        }
        Lanes(to)
    }

    #[inline(always)]
    pub fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut to = self.0;
        for (v, w) in to.iter_mut().zip(&other.0) {
            *v = f(*v, *w);
        }
        Lanes(to)
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(f64::abs)
    }

    /// The greater of each and `v`. NaN stays NaN: nothing is ruled out for it.
    #[inline(always)]
    pub fn at_least(self, v: f64) -> Self {
        self.map(|x| if x < v { v } else { x })
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.with(other, |x, y| if x < y { y } else { x })
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// Says of which lanes the value is not greater than `v`, as bits; those of NaN are among them.
    #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is no number counts")]
    #[inline(always)]
    pub fn not_above(self, v: f64) -> u32 {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(!(self.0[i] > v)) << i;
        }
        bits
    }

    /// Says whether one is not greater than its limit, or is no number.
    #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is no number counts")]
    #[inline(always)]
    pub fn any_not_above(self, limit: Self) -> bool {
        let mut any = false;
        for i in 0..N {
            any |= !(self.0[i] > limit.0[i]);
        }
        any
    }

    /// Says whether one is below its limit.
    #[inline(always)]
    pub fn any_below(self, limit: Self) -> bool {
        let mut any = false;
        for i in 0..N {
            any |= self.0[i] < limit.0[i];
        }
        any
    }
}

impl<const N: usize> Add for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        self.with(o, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        self.with(o, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        self.with(o, |a, b| a * b)
    }
}

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, v: f64) -> Self {
        self.map(|a| a * v)
    }
}

impl<const N: usize> Add<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, v: f64) -> Self {
        self.map(|a| a + v)
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// A point for each configuration.
pub type Points<const N: usize> = [Lanes<N>; 3];

/// Returns the squared distances between points.
#[inline(always)]
pub fn apart2<const N: usize>(p: &Points<N>, q: &Points<N>) -> Lanes<N> {
    let (x, y, z) = (p[0] - q[0], p[1] - q[1], p[2] - q[2]);
    x * x + y * y + z * z
}

/// Returns the point of one configuration.
#[inline(always)]
pub fn lane_of<const N: usize>(p: &Points<N>, i: usize) -> [f64; 3] {
    [p[0].0[i], p[1].0[i], p[2].0[i]]
}

/// A pose for each configuration: rotation by rows, then translation.
#[derive(Debug, Clone, Copy)]
pub struct Poses<const N: usize> {
    pub r: [[Lanes<N>; 3]; 3],
    pub p: Points<N>,
}

/// One rotation by rows and a translation, that of a fixed transform.
#[derive(Debug, Clone, Copy)]
pub struct Fixed {
    pub r: [[f64; 3]; 3],
    pub p: [f64; 3],
}

impl Fixed {
    pub fn new(X: &Pose) -> Fixed {
        let R = X.rotation.to_rotation_matrix();
        let R = R.matrix();
        Fixed {
            r: from_fn(|i| from_fn(|j| R[(i, j)])),
            p: X.translation.vector.into(),
        }
    }

    /// Maps a point of the outer frame into the inner one.
    #[inline(always)]
    pub fn inverse_of(&self, q: &[f64; 3]) -> [f64; 3] {
        let d = [q[0] - self.p[0], q[1] - self.p[1], q[2] - self.p[2]];
        let along = |j: usize| d[0] * self.r[0][j] + d[1] * self.r[1][j] + d[2] * self.r[2][j];
        [along(0), along(1), along(2)]
    }

    /// Returns the pose of another inner frame in this one's.
    #[inline(always)]
    pub fn inverse_times(&self, other: &Fixed) -> Fixed {
        let at = |i: usize, j: usize| {
            self.r[0][i] * other.r[0][j] + self.r[1][i] * other.r[1][j] + self.r[2][i] * other.r[2][j]
        };
        let row = |i: usize| [at(i, 0), at(i, 1), at(i, 2)];
        Fixed {
            r: [row(0), row(1), row(2)],
            p: self.inverse_of(&other.p),
        }
    }

    /// Maps points of the inner frame.
    #[inline(always)]
    pub fn of<const N: usize>(&self, q: &Points<N>) -> Points<N> {
        let at = |i: usize| q[0] * self.r[i][0] + q[1] * self.r[i][1] + q[2] * self.r[i][2] + self.p[i];
        [at(0), at(1), at(2)]
    }

    /// Returns it as a pose.
    pub fn pose(&self) -> Pose {
        let R = Matrix3::from_fn(|row, column| self.r[row][column]);
        // Rows and columns are unit vectors up to rounding; what is not finite stays so.
        let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R));
        Pose::from_parts(Vec3::from(self.p).into(), q)
    }
}

impl<const N: usize> Poses<N> {
    /// The same pose in every lane.
    #[inline(always)]
    pub fn all(X: &Fixed) -> Self {
        let row = |v: &[f64; 3]| [Lanes::all(v[0]), Lanes::all(v[1]), Lanes::all(v[2])];
        Poses {
            r: [row(&X.r[0]), row(&X.r[1]), row(&X.r[2])],
            p: row(&X.p),
        }
    }

    /// Becomes the composition of a pose and a fixed transform.
    #[inline(always)]
    pub fn set(&mut self, of: &Self, X: &Fixed) {
        for i in 0..3 {
            let row = &of.r[i];
            for j in 0..3 {
                self.r[i][j] = row[0] * X.r[0][j] + row[1] * X.r[1][j] + row[2] * X.r[2][j];
            }
            self.p[i] = row[0] * X.p[0] + row[1] * X.p[1] + row[2] * X.p[2] + of.p[i];
        }
    }

    /// Maps a point of the inner frame.
    #[inline(always)]
    pub fn of(&self, q: &[f64; 3]) -> Points<N> {
        let at = |i: usize| self.r[i][0] * q[0] + self.r[i][1] * q[1] + self.r[i][2] * q[2] + self.p[i];
        [at(0), at(1), at(2)]
    }

    /// Turns about the inner z axis.
    #[inline(always)]
    pub fn turn(&mut self, sin: &Lanes<N>, cos: &Lanes<N>) {
        for row in &mut self.r {
            let [x, y] = [row[0], row[1]];
            row[0] = x * *cos + y * *sin;
            row[1] = y * *cos - x * *sin;
        }
    }

    /// Slides along the inner z axis.
    #[inline(always)]
    pub fn slide(&mut self, by: &Lanes<N>) {
        for (p, row) in self.p.iter_mut().zip(&self.r) {
            *p = *p + row[2] * *by;
        }
    }

    /// Returns the pose of one configuration.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Fixed {
        let row = |v: &Points<N>| [v[0].0[i], v[1].0[i], v[2].0[i]];
        Fixed {
            r: [row(&self.r[0]), row(&self.r[1]), row(&self.r[2])],
            p: row(&self.p),
        }
    }
}

/// Two thirds of a double's mantissa of pi/2, then the next third, then the rest: a small multiple of the first two has no rounding.
const HALF_PI: [f64; 3] = [
    f64::from_bits(0x3FF9_21FB_5440_0000),
    f64::from_bits(0x3DD0_B461_1A60_0000),
    f64::from_bits(0x3BA3_198A_2E03_7073),
];
/// Adding it rounds to an integer, which then stands in the lowest bits of the mantissa.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Angles beyond it [rad] are left to the library's function.
const LARGEST: f64 = 1e5;

/// Returns sines and cosines: the angle is brought into [-pi/4, pi/4], where the series are short.
#[inline(always)]
pub fn sin_cos<const N: usize>(angle: Lanes<N>) -> (Lanes<N>, Lanes<N>) {
    let shifted = angle * std::f64::consts::FRAC_2_PI + ROUND;
    let k = shifted + -ROUND;
    let r = angle - k * HALF_PI[0] - k * HALF_PI[1] - k * HALF_PI[2];
    let x = r * r;
    // Taylor's series: the first term left out is below 5e-17.
    let mut s = Lanes::all(-1.0 / 1_307_674_368_000.0);
    for c in [
        1.0 / 6_227_020_800.0,
        -1.0 / 39_916_800.0,
        1.0 / 362_880.0,
        -1.0 / 5_040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
    ] {
        s = s * x + c;
    }
    let s = r + r * x * s;
    let mut c = Lanes::all(1.0 / 20_922_789_888_000.0);
    for d in [
        -1.0 / 87_178_291_200.0,
        1.0 / 479_001_600.0,
        -1.0 / 3_628_800.0,
        1.0 / 40_320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -0.5,
    ] {
        c = c * x + d;
    }
    let c = c * x + 1.0;
    let (mut sin, mut cos) = (s, c);
    for i in 0..N {
        let quarter = shifted.0[i].to_bits();
        // All bits where sine and cosine change places.
        let swap = (quarter & 1).wrapping_neg();
        let (a, b) = (s.0[i].to_bits(), c.0[i].to_bits());
        let differ = (a ^ b) & swap;
        sin.0[i] = f64::from_bits(a ^ differ ^ (quarter & 2) << 62);
        cos.0[i] = f64::from_bits(b ^ differ ^ (quarter.wrapping_add(1) & 2) << 62);
    }
    if angle.abs().not_above(LARGEST) != (1 << N) - 1 {
        for i in 0..N {
            if angle.0[i].abs() > LARGEST {
                (sin.0[i], cos.0[i]) = ComplexField::sin_cos(angle.0[i]);
            }
        }
    }
    (sin, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sines_are_right_everywhere() {
        for k in -200_000..200_000 {
            let v = f64::from(k) * 0.000_731 + f64::from(k % 7) * 1e4;
            let (s, c) = sin_cos(Lanes([v, -v]));
            let (t, d) = ComplexField::sin_cos(v);
            assert!((s.0[0] - t).abs() < 4e-16 && (c.0[0] - d).abs() < 4e-16, "{v}");
            assert!((s.0[1] + t).abs() < 4e-16 && (c.0[1] - d).abs() < 4e-16, "{v}");
        }
        let (s, c) = sin_cos(Lanes([1e9, f64::NAN, f64::INFINITY]));
        assert_eq!((s.0[0], c.0[0]), ComplexField::sin_cos(1e9));
        assert!(s.0[1].is_nan() && c.0[1].is_nan() && s.0[2].is_nan() && c.0[2].is_nan());
    }
}
