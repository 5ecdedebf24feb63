//! Two oriented boxes on their 15 separating axes.
//!
//! Gottschalk, Lin, Manocha, SIGGRAPH 1996, doi:10.1145/237170.237244. Differs from the paper: the gap is measured, not just its sign,
//! and a cross product of almost parallel edges is skipped (the face axes cover it).

use crate::geom::{Pose, Vec3};

/// Returns the largest gap between the projections of two boxes on those axes [m].
///
/// Positive: they are apart by at least as much. Negative: they overlap, and minus the value is the least translation that parts them.
/// Stops at the first axis whose gap is greater than `enough`.
pub fn gap(a: &Vec3, b: &Vec3, X_AB: &Pose, enough: f64) -> f64 {
    let r = X_AB.rotation.to_rotation_matrix();
    let r = r.matrix();
    let t = &X_AB.translation.vector;
    let abs = r.abs();
    let mut widest = f64::NEG_INFINITY;
    for i in 0..3 {
        let g = t[i].abs() - a[i] - (abs[(i, 0)] * b.x + abs[(i, 1)] * b.y + abs[(i, 2)] * b.z);
        widest = widest.max(g);
    }
    if widest > enough {
        return widest;
    }
    for j in 0..3 {
        let along = t.x * r[(0, j)] + t.y * r[(1, j)] + t.z * r[(2, j)];
        let g = along.abs() - b[j] - (abs[(0, j)] * a.x + abs[(1, j)] * a.y + abs[(2, j)] * a.z);
        widest = widest.max(g);
    }
    if widest > enough {
        return widest;
    }
    for i in 0..3 {
        let (i1, i2) = ((i + 1) % 3, (i + 2) % 3);
        for j in 0..3 {
            let (j1, j2) = ((j + 1) % 3, (j + 2) % 3);
            // The axis e_i x r_j, of which component i is zero; its length is the sine of the angle between the edges.
            let length2 = r[(i1, j)] * r[(i1, j)] + r[(i2, j)] * r[(i2, j)];
            if length2 < 1e-12 {
                continue;
            }
            let along = t[i2] * r[(i1, j)] - t[i1] * r[(i2, j)];
            let reach = a[i1] * abs[(i2, j)] + a[i2] * abs[(i1, j)] + b[j1] * abs[(i, j2)] + b[j2] * abs[(i, j1)];
            let g = (along.abs() - reach) / length2.sqrt();
            if g > enough {
                return g;
            }
            widest = widest.max(g);
        }
    }
    widest
}
