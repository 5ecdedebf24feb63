//! Shorter paths by cutting corners.
//!
//! Vertices that can be left out are left out; then two random points of the path are joined by a line, as long as there are rounds
//! (Geraerts & Overmars, IJRR 26(8), 2007, doi:10.1177/0278364907079280, "shortcut"). Does not move away from obstacles, and does not
//! round corners: see [`super::timing`].

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Path, Space, between_is_free, interpolate, length};

/// Effort and checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Random pairs of points that are tried.
    pub rounds: u32,
    /// Spacing of the checks along an edge [rad].
    pub resolution: f64,
}

/// Returns a path with the same ends that is not longer; its new edges are free at the resolution if the old path was.
pub fn shortcut(space: &mut dyn Space, path: Path, settings: &Settings, rng: &mut ChaCha8Rng) -> Path {
    let mut scratch = Vec::new();
    let mut path = drop_vertices(space, path, settings, &mut scratch);
    for _ in 0..settings.rounds {
        if path.len() < 3 {
            break;
        }
        let (u, v) = (rng.random::<f64>(), rng.random::<f64>());
        cut(space, &mut path, u.min(v), u.max(v), settings, &mut scratch);
    }
    drop_vertices(space, path, settings, &mut scratch)
}

/// From each vertex on, goes to the farthest vertex that can be seen by halving the number of those skipped.
fn drop_vertices(space: &mut dyn Space, path: Path, settings: &Settings, scratch: &mut Vec<f64>) -> Path {
    let mut kept: Path = Vec::with_capacity(path.len());
    let mut at = 0;
    while let Some(q) = path.get(at) {
        kept.push(q.clone());
        let mut ahead = path.len() - 1 - at;
        while ahead > 1 && !between_is_free(space, q, &path[at + ahead], settings.resolution, scratch) {
            ahead /= 2;
        }
        at += ahead.max(1);
    }
    kept
}

/// Joins the points at the fractions `u < v` of the length, when they lie on different edges and the line between them is free.
fn cut(space: &mut dyn Space, path: &mut Path, u: f64, v: f64, settings: &Settings, scratch: &mut Vec<f64>) {
    let total: f64 = path.windows(2).map(|w| length(&w[0], &w[1])).sum();
    let (Some((i, a)), Some((j, b))) = (point_at(path, u * total), point_at(path, v * total)) else {
        return;
    };
    if i == j {
        return;
    }
    let free = space.is_free(&a)
        && space.is_free(&b)
        && between_is_free(space, &a, &b, settings.resolution, scratch)
        // The rests of the two edges are checked again, since their points are new.
        && between_is_free(space, &path[i], &a, settings.resolution, scratch)
        && between_is_free(space, &b, &path[j + 1], settings.resolution, scratch);
    if free {
        path.splice(i + 1..=j, [a, b]);
    }
}

/// The edge and the point at `s` along the path.
fn point_at(path: &Path, mut s: f64) -> Option<(usize, Vec<f64>)> {
    for (i, edge) in path.windows(2).enumerate() {
        let distance = length(&edge[0], &edge[1]);
        if s <= distance && distance > 0.0 {
            let mut q = Vec::new();
            interpolate(&edge[0], &edge[1], s / distance, &mut q);
            return Some((i, q));
        }
        s -= distance;
    }
    None
}
