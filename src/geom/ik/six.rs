//! Six revolute joints in closed form, as lines in space: `G` is the product of the turns about them.
//!
//! Two families (and both again from the tool's end, with the chain turned round):
//! - three last axes through one point (Pieper, Stanford 1968): the first three bring the point to its place, the last three turn.
//!   The first three may have any offsets: their place is where a conic meets a circle, an equation of degree four;
//!   where axes 1 and 2 meet or are parallel it falls into two of degree two;
//! - axes 2, 3, 4 parallel and 5, 6 meeting (arms of the UR kind).
//!
//! The parts are the subproblems of Paden and Kahan in the form of Elias & Wen (arXiv 2211.05737); the conic in place of their sixth
//! subproblem is ours. Where a joint does not matter (a singular wrist, a point on the first axis) it stays at the hint.
//! Does not know limits.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::f64::consts::TAU;

use nalgebra::{Complex, RealField, Rotation3, Unit};

use super::super::kinematics::trig::sin_cos;
use super::super::{Pose, Vec3};

/// A line about which a joint turns: a point on it [m] and its unit direction, in K.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub p: Vec3,
    pub h: Vec3,
}

/// Six angles [rad].
pub(super) type Angles = [f64; 6];

/// How six lines are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Family {
    /// Axes 4, 5, 6 meet in a point, and axes 1 and 2 meet or are parallel.
    Wrist,
    /// Axes 2, 3, 4 are parallel and 5 and 6 meet.
    Parallel,
    /// Axes 4, 5, 6 meet in a point.
    WristWithOffsets,
}

/// Lines this near meet, and lines whose directions differ by less are parallel [m], [rad]: descriptions write pi/2 as 1.5708. What that
/// leaves over, polishing takes away.
const SAME: f64 = 1e-5;
/// A cosine this much beyond 1 is a stretched arm and rounding.
const BEYOND: f64 = 1e-9;

/// Returns the family that the lines belong to.
pub(super) fn family(lines: &[Line; 6]) -> Option<Family> {
    let parallel = |a: &Line, b: &Line| a.h.cross(&b.h).norm() < SAME;
    if let Some(w) = meeting(&lines[4], &lines[5]) {
        let on_fourth = lines[3].h.cross(&(w - lines[3].p)).norm() < SAME;
        if on_fourth && !parallel(&lines[3], &lines[4]) {
            let easy = parallel(&lines[0], &lines[1]) || meeting(&lines[0], &lines[1]).is_some();
            return Some(if easy { Family::Wrist } else { Family::WristWithOffsets });
        }
        if parallel(&lines[1], &lines[2]) && parallel(&lines[2], &lines[3]) {
            return Some(Family::Parallel);
        }
    }
    None
}

/// Adds to `found` all angles whose turns about the lines, the first line outermost, make `G`. At a boundary of the
/// reach they may be true to a part in 10^5 only: who asks polishes.
pub(super) fn solve(family: Family, lines: &[Line; 6], G: &Pose, hint: &Angles, found: &mut Vec<Angles>) {
    let Some(w) = meeting(&lines[4], &lines[5]) else { return };
    match family {
        Family::Wrist | Family::WristWithOffsets => wrist(lines, &w, G, hint, found),
        Family::Parallel => parallel(lines, &w, G, hint, found),
    }
}

/// Returns the point where two lines meet.
fn meeting(a: &Line, b: &Line) -> Option<Vec3> {
    let (on_a, on_b) = nearest(a, b)?;
    ((on_a - on_b).norm() < SAME).then_some((on_a + on_b) * 0.5)
}

/// Returns the points of two lines that are nearest to each other; `None` for parallel lines.
fn nearest(a: &Line, b: &Line) -> Option<(Vec3, Vec3)> {
    let cosine = a.h.dot(&b.h);
    let square = a.h.cross(&b.h).norm_squared();
    if square < SAME * SAME {
        return None;
    }
    let between = b.p - a.p;
    let (u, v) = (a.h.dot(&between), b.h.dot(&between));
    let s = (u - cosine * v) / square;
    let t = (cosine * u - v) / square;
    Some((a.p + a.h * s, b.p + b.h * t))
}

/// Turns `v` about `h`.
fn turn(h: &Vec3, angle: f64, v: &Vec3) -> Vec3 {
    let (s, c) = sin_cos(angle);
    v * c + h.cross(v) * s + h * (h.dot(v) * (1.0 - c))
}

fn rotation(h: &Vec3, angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Unit::new_unchecked(*h), angle)
}

/// So near to an axis a point or a direction says nothing about the turn [m] or [rad]; what the turn then leaves over is polished.
const ON_AXIS: f64 = 1e-7;

/// Subproblem 1: the angle by which `from` turns about `h` towards `to`; `None` where one of them lies on the axis.
fn angle_about(h: &Vec3, from: &Vec3, to: &Vec3) -> Option<f64> {
    let flat = |v: &Vec3| v - h * h.dot(v);
    let (a, b) = (flat(from), flat(to));
    (a.norm().min(b.norm()) > ON_AXIS).then(|| RealField::atan2(h.dot(&a.cross(&b)), a.dot(&b)))
}

/// Subproblem 4: the angles with `a cos + b sin = d`: none, or two that may be the same.
fn circle_and_line(a: f64, b: f64, d: f64) -> Option<[f64; 2]> {
    let r = (a * a + b * b).sqrt();
    if r < 1e-12 {
        return None;
    }
    let cosine = d / r;
    if cosine.abs() > 1.0 + BEYOND {
        return None;
    }
    let cosine = cosine.clamp(-1.0, 1.0);
    let middle = RealField::atan2(b, a);
    let half = RealField::atan2(((1.0 - cosine) * (1.0 + cosine)).sqrt(), cosine);
    Some([middle - half, middle + half])
}

/// A function of an angle: `[constant, factor of cos, factor of sin]`.
type Wave = [f64; 3];

/// Spherical wrist.
fn wrist(lines: &[Line; 6], w: &Vec3, G: &Pose, hint: &Angles, found: &mut Vec<Angles>) {
    let p = (G * nalgebra::Point3::from(*w)).coords;
    let mut places = [[0.0; 3]; 8];
    let n = place(&[lines[0], lines[1], lines[2]], w, &p, hint, &mut places);
    let R = G.rotation.to_rotation_matrix();
    for [q1, q2, q3] in &places[..n] {
        let before = rotation(&lines[0].h, *q1) * rotation(&lines[1].h, *q2) * rotation(&lines[2].h, *q3);
        let A = before.inverse() * R;
        let (h4, h5, h6) = (&lines[3].h, &lines[4].h, &lines[5].h);
        // h4 . R5 h6 is left as it is by joints 4 and 6.
        let along = h5.dot(h4) * h5.dot(h6);
        let Some(bends) = circle_and_line(h4.dot(h6) - along, h4.dot(&h5.cross(h6)), h4.dot(&(A * h6)) - along) else {
            continue;
        };
        for q5 in distinct(bends) {
            let across = h6.cross(&least_along(h6)).normalize();
            let last = |q4: f64| {
                let R6 = (rotation(h4, q4) * rotation(h5, q5)).inverse() * A;
                angle_about(h6, &across, &(R6 * across)).unwrap_or(hint[5])
            };
            let bent = turn(h5, q5, h6);
            match angle_about(h4, &bent, &(A * h6)) {
                Some(q4) => found.push([*q1, *q2, *q3, q4, q5, last(q4)]),
                // Joints 4 and 6 turn about one line. Where the hint's share breaks a limit, half and half may not.
                None => {
                    let half = 0.5 * last(0.0);
                    found.push([*q1, *q2, *q3, hint[3], q5, last(hint[3])]);
                    found.push([*q1, *q2, *q3, half * bent.dot(h4).signum(), q5, half]);
                }
            }
        }
    }
}

/// Returns the coordinate axis that is farthest from `h`.
fn least_along(h: &Vec3) -> Vec3 {
    match h.iamin() {
        0 => Vec3::x(),
        1 => Vec3::y(),
        _ => Vec3::z(),
    }
}

fn distinct([a, b]: [f64; 2]) -> impl Iterator<Item = f64> {
    [Some(a), ((b - a).abs() > 1e-12).then_some(b)].into_iter().flatten()
}

/// All angles of three lines that bring the point `w` to `p`; returns how many.
fn place(lines: &[Line; 3], w: &Vec3, p: &Vec3, hint: &Angles, places: &mut [[f64; 3]; 8]) -> usize {
    let [one, two, three] = lines;
    // Everything from a point on axis 2, the nearest to axis 1; likewise the point on axis 1. Then the way between the two is
    // perpendicular to both axes.
    let (o1, o2) = nearest(one, two).unwrap_or_else(|| {
        let o2 = two.p + two.h * two.h.dot(&(one.p - two.p));
        (one.p, o2)
    });
    let o = o1 - o2;
    let flat_h1 = one.h - two.h * two.h.dot(&one.h);
    let (sine, offset) = (flat_h1.norm(), o.norm());
    // Where joint 3 can bring the point: f = middle + u cos + v sin.
    let foot = three.p + three.h * three.h.dot(&(w - three.p));
    let u = w - foot;
    let v = three.h.cross(&u);
    let middle = foot - o2;
    // Joints 1 and 2 leave these as they are: h2 . f, |f|^2; and p says what h1 . g and |g - o|^2 are, g being f turned by joint 2.
    let along: Wave = [two.h.dot(&middle), two.h.dot(&u), two.h.dot(&v)];
    let square: Wave = [
        middle.norm_squared() + u.norm_squared(),
        2.0 * middle.dot(&u),
        2.0 * middle.dot(&v),
    ];
    let height = one.h.dot(&(p - o1));
    let far = (p - o1).norm_squared();
    let cosine = one.h.dot(&two.h);
    // flat_h1 . g = C and o . g = F.
    let C: Wave = [
        height + one.h.dot(&o) - cosine * along[0],
        -cosine * along[1],
        -cosine * along[2],
    ];
    let F: Wave = [
        0.5 * (square[0] + o.norm_squared() - far),
        0.5 * square[1],
        0.5 * square[2],
    ];
    let (meets, is_parallel) = (offset < SAME, sine < SAME);
    let mut elbows = [0.0; 4];
    let n_elbows = if meets || is_parallel {
        // One of the two equations has lost joint 2.
        let e = if meets { &F } else { &C };
        let Some(pair) = circle_and_line(e[1], e[2], -e[0]) else {
            return 0;
        };
        let mut n = 0;
        for q3 in distinct(pair) {
            elbows[n] = q3;
            n += 1;
        }
        n
    } else {
        // The flat part of g has the length of the flat part of f: C^2/sine^2 + F^2/offset^2 + along^2 - square = 0.
        let mut conic = Conic::default();
        conic.add_square(&C, 1.0 / (sine * sine));
        conic.add_square(&F, 1.0 / (offset * offset));
        conic.add_square(&along, 1.0);
        conic.add(&square, -1.0);
        conic.roots(&mut elbows)
    };
    let mut n = 0;
    for q3 in &elbows[..n_elbows] {
        let (s, c) = sin_cos(*q3);
        let f = middle + u * c + v * s;
        let value = |e: &Wave| e[0] + e[1] * c + e[2] * s;
        let flat_f = f - two.h * two.h.dot(&f);
        let turned = two.h.cross(&flat_f);
        let shoulders = match (meets, is_parallel) {
            (true, _) => circle_and_line(flat_h1.dot(&flat_f), flat_h1.dot(&turned), value(&C)),
            (false, true) => circle_and_line(o.dot(&flat_f), o.dot(&turned), value(&F)),
            (false, false) => {
                let flat_g = flat_h1 * (value(&C) / (sine * sine)) + o * (value(&F) / (offset * offset));
                let q2 = angle_about(&two.h, &flat_f, &flat_g).unwrap_or(hint[1]);
                Some([q2, q2])
            }
        };
        let Some(shoulders) = shoulders else { continue };
        for q2 in distinct(shoulders) {
            let g = o2 + turn(&two.h, q2, &f);
            let q1 = angle_about(&one.h, &(g - o1), &(p - o1)).unwrap_or(hint[0]);
            if n < places.len() {
                places[n] = [q1, q2, *q3];
                n += 1;
            }
        }
    }
    n
}

/// A quadratic function of cosine and sine of one angle: factors of 1, c, s, c^2, c s, s^2.
#[derive(Debug, Clone, Copy, Default)]
struct Conic([f64; 6]);

impl Conic {
    fn add(&mut self, w: &Wave, factor: f64) {
        for (term, w) in self.0.iter_mut().zip(w.iter()) {
            *term += factor * w;
        }
    }

    fn add_square(&mut self, w: &Wave, factor: f64) {
        let terms = [
            w[0] * w[0],
            2.0 * w[0] * w[1],
            2.0 * w[0] * w[2],
            w[1] * w[1],
            2.0 * w[1] * w[2],
            w[2] * w[2],
        ];
        for (sum, term) in self.0.iter_mut().zip(terms) {
            *sum += factor * term;
        }
    }

    /// Puts the angles where it is zero into `angles` and returns how many they are.
    ///
    /// As a Fourier sum of the single and the double angle it is a polynomial of degree four in z = exp(i angle), and its real
    /// angles are the roots of modulus 1.
    fn roots(&self, angles: &mut [f64; 4]) -> usize {
        let [k, kc, ks, kcc, kcs, kss] = self.0;
        let (a0, a2, b2) = (k + 0.5 * (kcc + kss), 0.5 * (kcc - kss), 0.5 * kcs);
        let size = [a0, kc, ks, a2, b2].iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        if a2.abs().max(b2.abs()) <= 1e-13 * size {
            let Some(pair) = circle_and_line(kc, ks, -a0) else {
                return 0;
            };
            angles[..2].copy_from_slice(&pair);
            return 2;
        }
        let first = Complex::new(a2, -b2);
        let c3 = Complex::new(kc, -ks) / first;
        let c2 = Complex::from(2.0 * a0) / first;
        let c1 = Complex::new(kc, ks) / first;
        let c0 = Complex::new(a2, b2) / first;
        let at = |angle: f64| {
            let (s, c) = sin_cos(angle);
            let (s2, c2) = (2.0 * s * c, c * c - s * s);
            (
                a0 + kc * c + ks * s + a2 * c2 + b2 * s2,
                ks * c - kc * s + 2.0 * (b2 * c2 - a2 * s2),
            )
        };
        let mut n = 0;
        for z in quartic(&[c0, c1, c2, c3]) {
            // A double root comes as two that are off by the root of the rounding.
            if (z.norm_sqr() - 1.0).abs() > 1e-5 || n == angles.len() {
                continue;
            }
            let mut angle = RealField::atan2(z.im, z.re);
            for _ in 0..2 {
                let (value, slope) = at(angle);
                let step = value / slope;
                if step.abs() < 1e-3 {
                    angle -= step;
                }
            }
            angles[n] = angle;
            n += 1;
        }
        n
    }
}

/// Returns the roots of `z^4 + c[3] z^3 + c[2] z^2 + c[1] z + c[0]`, all at once (Aberth, Math. Comp. 27, 1973,
/// doi:10.1090/S0025-5718-1973-0329236-7).
fn quartic(c: &[Complex<f64>; 4]) -> [Complex<f64>; 4] {
    let mut roots = [0.4, 0.4 + TAU / 4.0, 0.4 + TAU / 2.0, 0.4 + 0.75 * TAU].map(|angle: f64| {
        let (s, c) = sin_cos(angle);
        Complex::new(c, s)
    });
    for _ in 0..MAX_ROUNDS {
        let mut largest = 0.0_f64;
        for i in 0..4 {
            let z = roots[i];
            let value = (((z + c[3]) * z + c[2]) * z + c[1]) * z + c[0];
            let slope = ((z * 4.0 + c[3] * 3.0) * z + c[2] * 2.0) * z + c[1];
            let others = (0..4)
                .filter(|j| *j != i)
                .map(|j| (z - roots[j]).inv())
                .fold(Complex::new(0.0, 0.0), |sum, v| sum + v);
            let step = value / (slope - value * others);
            if step.is_finite() {
                roots[i] = z - step;
                largest = largest.max(step.norm_sqr());
            }
        }
        if largest < 1e-26 {
            break;
        }
    }
    roots
}

/// Simple roots take about eight rounds; double roots come nearer by half each time, and are exact to 1e-8 at best.
const MAX_ROUNDS: u32 = 30;

/// Three parallel axes: 2, 3, 4; axes 5 and 6 meet in `w`.
fn parallel(lines: &[Line; 6], w: &Vec3, G: &Pose, hint: &Angles, found: &mut Vec<Angles>) {
    let h = &lines[1].h;
    let sign = |l: usize| lines[l].h.dot(h).signum();
    let (h1, h5, h6) = (&lines[0].h, &lines[4].h, &lines[5].h);
    let p = (G * nalgebra::Point3::from(*w)).coords;
    let R = G.rotation.to_rotation_matrix();
    // Joints 2, 3, 4 leave the height along h as it is: h . R1^-1 (p - o1) = h . (w - o1).
    let d = p - lines[0].p;
    let along = h.dot(h1) * h1.dot(&d);
    let Some(turns) = circle_and_line(
        h.dot(&d) - along,
        -h.dot(&h1.cross(&d)),
        h.dot(&(w - lines[0].p)) - along,
    ) else {
        return;
    };
    for q1 in distinct(turns) {
        let back = rotation(h1, q1).inverse();
        let A = back * R;
        let p1 = lines[0].p + back * d;
        let along = h5.dot(h) * h5.dot(h6);
        let Some(bends) = circle_and_line(h.dot(h6) - along, h.dot(&h5.cross(h6)), h.dot(&(A * h6)) - along) else {
            continue;
        };
        for q5 in distinct(bends) {
            let R5 = rotation(h5, q5);
            let q6 = angle_about(h6, &(A.inverse() * h), &(R5.inverse() * h)).unwrap_or(hint[5]);
            let B = A * (R5 * rotation(h6, q6)).inverse();
            let across = h.cross(&least_along(h)).normalize();
            let Some(whole) = angle_about(h, &across, &(B * across)) else {
                continue;
            };
            // Where joints 2 and 3 have to bring a point of axis 4.
            let m = p1 - B * (w - lines[3].p);
            let flat = |v: Vec3| v - h * h.dot(&v);
            let (upper, lower) = (flat(lines[2].p - lines[1].p), flat(lines[3].p - lines[2].p));
            let reach = flat(m - lines[1].p);
            let h3 = &lines[2].h;
            let Some(elbows) = circle_and_line(
                upper.dot(&lower),
                upper.dot(&h3.cross(&lower)),
                0.5 * (reach.norm_squared() - upper.norm_squared() - lower.norm_squared()),
            ) else {
                continue;
            };
            for q3 in distinct(elbows) {
                let q2 = angle_about(h, &(upper + turn(h3, q3, &lower)), &reach).unwrap_or(hint[1]);
                let q4 = sign(3) * (whole - q2 - sign(2) * q3);
                found.push([q1, q2, q3, q4, q5, q6]);
            }
        }
    }
}

/// Returns the lines as the tool's end sees them: the other way round, turning the other way. The angles keep their signs.
pub(super) fn turned_round(lines: &[Line; 6]) -> [Line; 6] {
    std::array::from_fn(|i| Line {
        p: lines[5 - i].p,
        h: -lines[5 - i].h,
    })
}
