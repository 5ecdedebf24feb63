//! Balls that contain a solid, and balls that it contains: for fast answers that are right when they are sure.
//!
//! A [`Form`] is a solid with one ball around it and up to sixteen balls that contain it together; each also says how large a ball about the
//! same centre lies within the solid. If no ball comes near to another thing, the solid does not touch it; if the ball within
//! does touch it, so does the solid; else the exact test has to say. Covers by balls are those of Hubbard, ACM TOG 15(3), 1996
//! (doi:10.1145/231731.231732), without his search for the best centres: ours are on a line or a grid, the same on every machine.

use super::collide::{Core, Solid};
use super::hull::Hull;
use super::{Pose, Vec3};

/// Balls of a cover. HEURISTIC: more cost more than the exact tests that they spare.
const MOST_BALLS: usize = 16;
/// On a line there are fewer.
const MOST_ON_LINE: usize = 8;

/// A ball about a point of a solid's frame S.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Measured in S [m].
    pub centre: Vec3,
    /// [m]
    pub radius: f64,
    /// Radius of a ball about the same centre that lies within the solid [m]; negative when there is none.
    pub within: f64,
}

/// A solid with its cover.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    solid: Solid,
    whole: Ball,
    balls: Vec<Ball>,
    /// The same balls, side by side.
    groups: Vec<Group>,
    excess: f64,
}

/// Balls side by side: coordinates of the centres, radii, radii within.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Group {
    pub p: [[f64; GROUP]; 3],
    pub radius: [f64; GROUP],
    pub within: [f64; GROUP],
}

/// So many balls are tested at a time.
pub(super) const GROUP: usize = 8;

impl Form {
    /// Makes the cover of a solid.
    pub fn new(solid: Solid) -> Form {
        let round = solid.round;
        let (whole, mut balls) = match solid.core {
            Core::Point => (ball(Vec3::zeros(), 0.0, 0.0), Vec::new()),
            Core::Segment { half_length } => (ball(Vec3::zeros(), half_length, 0.0), on_ends(half_length, round)),
            Core::Box { half } => (ball(Vec3::zeros(), half.norm(), half.min()), of_box(&half)),
            Core::Cylinder { radius, half_length } => (
                ball(
                    Vec3::zeros(),
                    (radius * radius + half_length * half_length).sqrt(),
                    radius.min(half_length),
                ),
                of_cylinder(radius, half_length),
            ),
            Core::Hull(ref hull) => of_hull(hull),
        };
        if balls.is_empty() {
            balls.push(whole);
        }
        // HEURISTIC: the ball that is farthest too large stands for how coarse a cover is.
        let excess = balls.iter().map(|b| b.radius - b.within.max(0.0)).fold(0.0, f64::max);
        let balls: Vec<Ball> = balls.into_iter().map(|b| grown(b, round)).collect();
        Form {
            whole: grown(whole, round),
            groups: balls.chunks(GROUP).map(group).collect(),
            balls,
            excess,
            solid,
        }
    }

    /// Returns the solid itself, for the exact test.
    pub fn solid(&self) -> &Solid {
        &self.solid
    }

    /// Returns one ball that contains the solid.
    pub fn whole(&self) -> &Ball {
        &self.whole
    }

    /// Returns the balls that contain the solid together; at least one, at most sixteen.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }

    /// The balls of [`Form::balls`], eight by eight.
    pub(super) fn groups(&self) -> &[Group] {
        &self.groups
    }

    /// Returns by how much the balls may be too large, at most [m].
    pub fn excess(&self) -> f64 {
        self.excess
    }

    /// Returns lower and upper corner of a box along the axes of W that contains the solid at a pose [m].
    pub fn bounds(&self, placed: &Pose) -> (Vec3, Vec3) {
        let half = self.solid.half_extent(placed);
        (placed.translation.vector - half, placed.translation.vector + half)
    }
}

fn ball(centre: Vec3, radius: f64, within: f64) -> Ball {
    Ball { centre, radius, within }
}

/// Puts up to eight balls side by side; the last one stands for those that are missing.
fn group(balls: &[Ball]) -> Group {
    let each = |f: &dyn Fn(&Ball) -> f64| std::array::from_fn(|i| balls.get(i).or(balls.last()).map_or(0.0, f));
    Group {
        p: std::array::from_fn(|axis| each(&|b: &Ball| b.centre[axis])),
        radius: each(&|b: &Ball| b.radius),
        within: each(&|b: &Ball| b.within),
    }
}

/// The ball of a core, for the core with a ball of radius `round` added.
fn grown(b: Ball, round: f64) -> Ball {
    ball(b.centre, b.radius + round, b.within + round)
}

/// Balls about points of the z axis from end to end; the largest gap between the tube of radius `round` and what is within it of a centre
/// lies half way between two.
fn on_ends(half_length: f64, round: f64) -> Vec<Ball> {
    let n = pieces(half_length, 0.5 * round).min(MOST_ON_LINE - 1);
    let half_gap = half_length / n as f64;
    let more = (round * round + half_gap * half_gap).sqrt() - round;
    (0..=n)
        .map(|i| ball(Vec3::new(0.0, 0.0, (2.0 * i as f64 - n as f64) * half_gap), more, 0.0))
        .collect()
}

/// Into how many pieces of at most `size` a length is cut; one where it makes no sense.
fn pieces(length: f64, size: f64) -> usize {
    let n = (length / size).ceil();
    if n >= 1.0 && n < MOST_BALLS as f64 {
        n as usize
    } else if n >= 1.0 {
        MOST_BALLS
    } else {
        1
    }
}

/// Numbers of cells along the axes of a box: about cubes, as few as fit one layer of the thinnest side, within the limit.
fn cells(half: &Vec3) -> [usize; 3] {
    let mut size = half.min().max(half.max() / MOST_BALLS as f64);
    loop {
        let n = [0, 1, 2].map(|axis| pieces(half[axis], size));
        // Ends: with a size of the longest half side every axis has one piece.
        if n.iter().product::<usize>() <= MOST_BALLS || size >= half.max() {
            return n;
        }
        size *= 1.1;
    }
}

/// Centre and half sides of each cell of a box about `middle`.
fn grid(middle: Vec3, half: &Vec3) -> impl Iterator<Item = (Vec3, Vec3)> {
    let n = cells(half);
    let cell = Vec3::new(half.x / n[0] as f64, half.y / n[1] as f64, half.z / n[2] as f64);
    let at = move |i: usize, axis: usize| (2.0 * i as f64 + 1.0 - n[axis] as f64) * cell[axis];
    (0..n[0] * n[1] * n[2]).map(move |k| {
        let (i, j, l) = (k % n[0], k / n[0] % n[1], k / (n[0] * n[1]));
        (middle + Vec3::new(at(i, 0), at(j, 1), at(l, 2)), cell)
    })
}

fn of_box(half: &Vec3) -> Vec<Ball> {
    grid(Vec3::zeros(), half)
        .map(|(c, cell)| ball(c, cell.norm(), (half - c.abs()).min()))
        .collect()
}

fn of_cylinder(radius: f64, half_length: f64) -> Vec<Ball> {
    let within = |c: &Vec3| (radius - (c.x * c.x + c.y * c.y).sqrt()).min(half_length - c.z.abs());
    if half_length < 0.5 * radius {
        let half = Vec3::new(radius, radius, half_length);
        let meets = |c: &Vec3, cell: &Vec3| {
            let (x, y) = ((c.x.abs() - cell.x).max(0.0), (c.y.abs() - cell.y).max(0.0));
            x * x + y * y <= radius * radius
        };
        let cells = grid(Vec3::zeros(), &half).filter(|(c, cell)| meets(c, cell));
        return cells.map(|(c, cell)| ball(c, cell.norm(), within(&c))).collect();
    }
    let n = pieces(half_length, 0.5 * radius).min(MOST_ON_LINE);
    let half_gap = half_length / n as f64;
    (0..n)
        .map(|i| {
            let c = Vec3::new(0.0, 0.0, (2.0 * i as f64 + 1.0 - n as f64) * half_gap);
            ball(c, (radius * radius + half_gap * half_gap).sqrt(), within(&c))
        })
        .collect()
}

/// One ball, and a ball for each cell of a grid that the hull meets.
fn of_hull(hull: &Hull) -> (Ball, Vec<Ball>) {
    let within = |c: &Vec3| {
        let depths = hull.faces.iter().map(|f| f.offset - f.normal.dot(c));
        depths.fold(f64::INFINITY, f64::min)
    };
    let about = |corners: &[Vec3]| {
        let c = centre(corners);
        let radius = corners.iter().map(|p| (p - c).norm()).fold(0.0, f64::max);
        // Corners are rounded to a hundredth of a micrometre.
        ball(c, radius + 1e-7, within(&c) - 1e-7)
    };
    let whole = about(&hull.vertices);
    let (low, high) = hull.vertices.iter().fold(
        (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)),
        |(low, high), p| (low.inf(p), high.sup(p)),
    );
    let balls = grid(0.5 * (low + high), &(0.5 * (high - low)))
        .filter_map(|(c, cell)| {
            let corners = in_cell(hull, &c, &cell);
            (!corners.is_empty()).then(|| about(&corners))
        })
        .collect();
    (whole, balls)
}

/// The corners of what a hull and a cell have in common: those of its faces cut by the cell's sides, and the cell's own that lie inside.
fn in_cell(hull: &Hull, c: &Vec3, cell: &Vec3) -> Vec<Vec3> {
    // A little more than the cell, so that nothing is lost between two.
    let cell = cell.add_scalar(1e-9);
    let mut corners = Vec::new();
    for face in &hull.faces {
        let mut polygon: Vec<Vec3> = face
            .corners
            .iter()
            .filter_map(|i| hull.vertices.get(*i).copied())
            .collect();
        for axis in 0..3 {
            for side in [1.0, -1.0] {
                let beyond = |p: &Vec3| side * (p[axis] - c[axis]) - cell[axis];
                let old = std::mem::take(&mut polygon);
                for (i, p) in old.iter().enumerate() {
                    let q = &old[(i + 1) % old.len()];
                    let (s, t) = (beyond(p), beyond(q));
                    if s <= 0.0 {
                        polygon.push(*p);
                    }
                    if (s > 0.0 && t <= 0.0) || (s <= 0.0 && t > 0.0) {
                        polygon.push(p + (q - p) * (s / (s - t)));
                    }
                }
            }
        }
        corners.extend(polygon);
    }
    for k in 0..8 {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let corner = c + cell.component_mul(&Vec3::new(sign(0), sign(1), sign(2)));
        if hull.faces.iter().all(|f| f.normal.dot(&corner) <= f.offset + 1e-9) {
            corners.push(corner);
        }
    }
    corners
}

/// Nearly the centre of the smallest ball around the points: each step goes towards the farthest (Badoiu, Clarkson, SODA 2003,
/// doi:10.5555/644108.644240).
fn centre(points: &[Vec3]) -> Vec3 {
    let mut c = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    for step in 1..64 {
        let farthest = points
            .iter()
            .max_by(|a, b| (*a - c).norm_squared().total_cmp(&(*b - c).norm_squared()));
        if let Some(p) = farthest {
            c += (p - c) / (step + 1) as f64;
        }
    }
    c
}
