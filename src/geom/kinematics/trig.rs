//! Sine and cosine of one angle or of eight, by additions and multiplications alone: the same bits on every machine, and a loop that
//! the compiler turns into vector instructions.
//!
//! Cody and Waite's reduction to [-pi/4, pi/4] by a multiple of pi/2 in three parts (Muller et al., Handbook of Floating-Point
//! Arithmetic, 2018, section 10.2, doi:10.1007/978-3-319-76526-6), then Chebyshev fits of degree 13 and 14, whose own error is below
//! 2e-17. Differs from a library's in the last bit. Angles beyond [`FAR`] go to the library, which does reduce them.

use nalgebra::ComplexField;

use super::lanes::{Eight, Lanes};

/// Up to here the multiple of the first part of pi/2, of 33 bits, is exact [rad].
const FAR: f64 = 1e6;
/// Adding and subtracting it rounds to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
const TWO_OVER_PI: f64 = std::f64::consts::FRAC_2_PI;
/// pi/2 as a sum: 33 bits, the next 33, and the rest.
const PI_2: [f64; 3] = [
    1.570_796_326_734_125_6,
    6.077_100_506_303_966e-11,
    2.022_266_248_795_950_6e-21,
];
const SIN: [f64; 6] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_330_948,
    -0.000_198_412_698_367_567_74,
    2.755_731_610_161_787_4e-6,
    -2.505_113_165_023_518e-8,
    1.591_811_526_326_597_4e-10,
];
const COS: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_739_8,
    2.480_158_729_876_456e-5,
    -2.755_731_727_114_514_4e-7,
    2.087_614_614_655_861e-9,
    -1.138_262_364_746_460_4e-11,
];

/// Returns sine and cosine of `angle` [rad].
#[inline]
pub(in super::super) fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() <= FAR { near(angle) } else { far(angle) }
}

/// Beyond [`FAR`], infinite or NaN.
#[cold]
fn far(angle: f64) -> (f64, f64) {
    ComplexField::sin_cos(angle)
}

/// Returns sines and cosines of eight angles [rad], each as [`sin_cos`] has them.
#[inline(always)]
pub(super) fn sin_cos_x8(angles: &[f64; 8]) -> (Eight, Eight) {
    if angles.iter().fold(true, |near, a| near & (a.abs() <= FAR)) {
        return near(Eight(*angles));
    }
    let (mut s, mut c) = ([0.0; 8], [0.0; 8]);
    for l in 0..8 {
        (s[l], c[l]) = sin_cos(angles[l]);
    }
    (Eight(s), Eight(c))
}

/// Without branches, for |angle| <= [`FAR`].
#[inline(always)]
fn near<T: Lanes>(angle: T) -> (T, T) {
    let of = T::of;
    let round = |v: T| (v + of(ROUND)) - of(ROUND);
    // angle = (2 h + j) pi/2 + r with j in -1, 0, 1.
    let k = round(angle * of(TWO_OVER_PI));
    let r = ((angle - k * of(PI_2[0])) - k * of(PI_2[1])) - k * of(PI_2[2]);
    let h = round(k * of(0.5));
    let j = k - (h + h);
    let h_odd = h - (round(h * of(0.5)) + round(h * of(0.5)));
    let z = r * r;
    let zz = z * z;
    let fit =
        |c: &[f64; 6]| (of(c[0]) + z * of(c[1])) + zz * ((of(c[2]) + z * of(c[3])) + zz * (of(c[4]) + z * of(c[5])));
    let sine = r + r * z * fit(&SIN);
    let cosine = (of(1.0) - of(0.5) * z) + zz * fit(&COS);
    // Half turns change both signs; a quarter turn swaps the two. Products by 0, 1 and -1: exact.
    let sign = of(1.0) - (h_odd * h_odd + h_odd * h_odd);
    let even = of(1.0) - j * j;
    (sign * (even * sine + j * cosine), sign * (even * cosine - j * sine))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_library() {
        for i in -200_000..=200_000 {
            let angle = f64::from(i) * 1.234_567e-4;
            let (s, c) = sin_cos(angle);
            let (s_lib, c_lib) = ComplexField::sin_cos(angle);
            assert!(
                (s - s_lib).abs() <= 1.2e-16 && (c - c_lib).abs() <= 1.2e-16,
                "{angle}: {s} {s_lib} {c} {c_lib}"
            );
        }
        for angle in [
            0.0,
            1e-300,
            std::f64::consts::FRAC_PI_4,
            999_999.9,
            1e6,
            1.1e6,
            1e18,
            -3e5,
        ] {
            let (s, c) = sin_cos(angle);
            let (s_lib, c_lib) = ComplexField::sin_cos(angle);
            assert!(
                (s - s_lib).abs() <= 2.3e-16 && (c - c_lib).abs() <= 2.3e-16,
                "{angle}: {s} {s_lib} {c} {c_lib}"
            );
        }
        for angle in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(sin_cos(angle).0.is_nan() && sin_cos(angle).1.is_nan());
        }
    }
}
