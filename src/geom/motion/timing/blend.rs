//! A path whose corners are rounded by circular arcs, by length.
//!
//! Kunz & Stilman, RSS 2012, doi:10.15607/RSS.2012.VIII.027, section IV. An arc takes at most half of each edge, so that neighbours do not meet;
//! it lies in the triangle of its corner, hence within joint limits. Differs from the paper: a corner may have no arc, and is then a stop.

use super::super::{Path, length};
use nalgebra::{ComplexField, RealField};

/// Below this angle [rad] a corner is none; above the other one the way turns back, and an arc would be slower than a stop.
const STRAIGHT: f64 = 1e-6;
const BACK: f64 = 3.0;

/// A line, or an arc with a radius.
#[derive(Debug, Clone)]
pub struct Piece {
    from: Vec<f64>,
    /// Unit tangent at the start.
    along: Vec<f64>,
    /// Unit vector towards the arc's centre, and the radius; `None` for a line.
    bend: Option<(Vec<f64>, f64)>,
    length: f64,
    /// The vertex that an arc rounds.
    corner: usize,
}

impl Piece {
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Angle that an arc turns by [rad]; 0 for a line.
    pub fn angle(&self) -> f64 {
        self.bend.as_ref().map_or(0.0, |(_, radius)| self.length / radius)
    }

    /// Puts the position at the length `s` from the piece's start into `q`.
    pub fn position(&self, s: f64, q: &mut Vec<f64>) {
        q.clear();
        match &self.bend {
            None => q.extend(self.from.iter().zip(&self.along).map(|(f, a)| f + s * a)),
            Some((inward, radius)) => {
                let half_sine = ComplexField::sin(0.5 * s / radius);
                // 1 - cos, without cancellation.
                let (side, ahead) = (
                    2.0 * radius * half_sine * half_sine,
                    radius * ComplexField::sin(s / radius),
                );
                q.extend(
                    self.from
                        .iter()
                        .zip(&self.along)
                        .zip(inward)
                        .map(|((f, a), n)| f + ahead * a + side * n),
                );
            }
        }
    }

    /// First and second derivative by length, of entry `j`.
    pub fn derivatives(&self, s: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let (sine, cosine, curvature) = match &self.bend {
            None => (0.0, 1.0, 0.0),
            Some((_, radius)) => {
                let (sine, cosine) = ComplexField::sin_cos(s / radius);
                (sine, cosine, 1.0 / radius)
            }
        };
        self.along.iter().enumerate().map(move |(j, a)| {
            let n = self.bend.as_ref().map_or(0.0, |(inward, _)| inward[j]);
            (cosine * a + sine * n, curvature * (cosine * n - sine * a))
        })
    }
}

/// Returns the arc that rounds a vertex and passes within `deviation` of it; `None` at the ends, where the way is straight or turns
/// back, and when `deviation` is 0.
pub fn arc_at(vertices: &Path, corner: usize, deviation: f64) -> Option<Piece> {
    let (before, at, after) = (
        vertices.get(corner.checked_sub(1)?)?,
        vertices.get(corner)?,
        vertices.get(corner + 1)?,
    );
    let angle = turn(before, at, after);
    if !(STRAIGHT..=BACK).contains(&angle) || deviation.is_nan() || deviation <= 0.0 {
        return None;
    }
    let (l_in, l_out) = (length(before, at), length(at, after));
    let (sine, cosine) = ComplexField::sin_cos(0.5 * angle);
    // Length that the arc takes from each edge; (1 - cos) / sin = tan of the half.
    let quarter = ComplexField::tan(0.25 * angle);
    let taken = (deviation / quarter).min(0.5 * l_in).min(0.5 * l_out);
    let radius = taken * cosine / sine;
    let along: Vec<f64> = before.iter().zip(at).map(|(b, a)| (a - b) / l_in).collect();
    let full_sine = 2.0 * sine * cosine;
    let full_cosine = 1.0 - 2.0 * sine * sine;
    let outward = at.iter().zip(after).map(|(a, b)| (b - a) / l_out);
    let inward = outward
        .zip(&along)
        .map(|(o, a)| (o - full_cosine * a) / full_sine)
        .collect();
    let from = at.iter().zip(&along).map(|(q, a)| q - taken * a).collect();
    Some(Piece {
        from,
        along,
        bend: Some((inward, radius)),
        length: radius * angle,
        corner,
    })
}

/// Angle between the two edges at `at` [rad]; 0 is straight on.
fn turn(before: &[f64], at: &[f64], after: &[f64]) -> f64 {
    let (l_in, l_out) = (length(before, at), length(at, after));
    let (mut difference, mut sum) = (0.0, 0.0);
    for ((b, q), a) in before.iter().zip(at).zip(after) {
        let (u, v) = ((q - b) / l_in, (a - q) / l_out);
        difference += (v - u) * (v - u);
        sum += (v + u) * (v + u);
    }
    2.0 * RealField::atan2(difference.sqrt(), sum.sqrt())
}

/// Where the motion is at rest: corners without an arc, and the end.
#[derive(Debug, Clone)]
pub struct Stop {
    /// The piece that ends there.
    pub after_piece: usize,
    pub s: f64,
    pub q: Vec<f64>,
}

/// Pieces one after the other; tangents are continuous but at stops.
#[derive(Debug, Clone)]
pub struct Curve {
    pieces: Vec<Piece>,
    /// Where each piece starts, and where the last one ends.
    starts: Vec<f64>,
    stops: Vec<Stop>,
}

impl Curve {
    /// Returns the curve of at least two vertices, none like the one before; `deviations` for each vertex (those of the ends are not used).
    pub fn new(vertices: &Path, deviations: &[f64]) -> Curve {
        let mut curve = Curve {
            pieces: Vec::new(),
            starts: vec![0.0],
            stops: Vec::new(),
        };
        let mut taken_before = 0.0;
        for (i, edge) in vertices.windows(2).enumerate() {
            let (a, b) = (&edge[0], &edge[1]);
            let full = length(a, b);
            let along: Vec<f64> = a.iter().zip(b).map(|(a, b)| (b - a) / full).collect();
            let arc = arc_at(vertices, i + 1, deviations.get(i + 1).copied().unwrap_or(0.0));
            let taken = arc.as_ref().map_or(0.0, |arc| length(&arc.from, b));
            let rest = full - taken_before - taken;
            // Two arcs that share an edge leave nothing between them but rounding.
            if rest > 1e-9 * full {
                let from = a.iter().zip(&along).map(|(a, d)| a + taken_before * d).collect();
                curve.push(Piece {
                    from,
                    along,
                    bend: None,
                    length: rest,
                    corner: i,
                });
            }
            let at_end = i + 2 == vertices.len();
            let straight_on = !at_end && turn(a, b, &vertices[i + 2]) < STRAIGHT;
            match arc {
                Some(arc) => curve.push(arc),
                None if straight_on => {}
                None => {
                    let after_piece = curve.pieces.len().saturating_sub(1);
                    curve.stops.push(Stop {
                        after_piece,
                        s: curve.length(),
                        q: b.clone(),
                    });
                }
            }
            taken_before = taken;
        }
        curve
    }

    fn push(&mut self, piece: Piece) {
        self.starts.push(self.length() + piece.length);
        self.pieces.push(piece);
    }

    pub fn start(&self) -> &[f64] {
        self.pieces.first().map_or(&[], |p| &p.from)
    }

    /// In order; the last one is the end.
    pub fn stops(&self) -> &[Stop] {
        &self.stops
    }

    /// The pieces with their starts.
    pub fn pieces(&self) -> impl Iterator<Item = (f64, &Piece)> {
        self.starts.iter().copied().zip(&self.pieces)
    }

    pub fn length(&self) -> f64 {
        self.starts.last().copied().unwrap_or(0.0)
    }

    /// Puts the position at `s` into `q`.
    pub fn position(&self, s: f64, q: &mut Vec<f64>) {
        let after = self.starts.partition_point(|start| *start <= s);
        let i = after.saturating_sub(1).min(self.pieces.len().saturating_sub(1));
        if let (Some(piece), Some(start)) = (self.pieces.get(i), self.starts.get(i)) {
            piece.position((s - start).clamp(0.0, piece.length), q);
        }
    }

    /// The corners whose arcs have a part between `from` and `to`.
    pub fn corners_within(&self, from: f64, to: f64) -> impl Iterator<Item = usize> + '_ {
        let touches =
            move |(start, piece): &(f64, &Piece)| piece.bend.is_some() && *start < to && start + piece.length > from;
        self.pieces().filter(touches).map(|(_, piece)| piece.corner)
    }
}
