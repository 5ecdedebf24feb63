//! RRT-Connect between two configurations.
//!
//! Grows a tree from each end and joins them (Kuffner & LaValle, ICRA 2000, doi:10.1109/ROBOT.2000.844730).
//! Differs from the paper: the straight line is tried first; the smaller tree grows, not each in turn.
//! Does not shorten the path: see [`super::shortcut`]. Knows nothing of tasks or agents.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Path, Space, interpolate, length, onward_is_free};

/// Step sizes and limits. No `Default`: the caller knows the robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Longest tree edge in the joint metric [rad].
    pub step: f64,
    /// Spacing of the checks along an edge, at most `step` [rad].
    pub resolution: f64,
    /// Samples drawn before giving up.
    pub max_samples: u32,
}

/// Why there is no path; the reasoner turns it into a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoPath {
    /// The start is not free.
    Start,
    /// The goal is not free.
    Goal,
    /// That many samples did not join the two ends, which proves nothing.
    OutOfSamples { drawn: u32 },
}

/// Returns a free path from `start` to `goal`, both included.
///
/// Samples are drawn inside the limits; where there are none, within pi of the start. The goal is taken as it is given: a joint that
/// turns without limits is not wound the shorter way.
///
/// # Errors
///
/// [`NoPath`]. A step or a resolution that is no positive number ends in `OutOfSamples`, as do ends of different lengths.
pub fn rrt_connect(
    space: &mut dyn Space,
    start: &[f64],
    goal: &[f64],
    settings: &Settings,
    rng: &mut ChaCha8Rng,
) -> Result<Path, NoPath> {
    if !space.is_free(start) {
        return Err(NoPath::Start);
    }
    if !space.is_free(goal) {
        return Err(NoPath::Goal);
    }
    let dim = start.len();
    let sound = settings.step > 0.0 && settings.resolution > 0.0 && goal.len() == dim && space.dofs().len() == dim;
    if !sound {
        return Err(NoPath::OutOfSamples { drawn: 0 });
    }
    let mut scratch = Vec::with_capacity(dim);
    if onward_is_free(space, start, goal, settings.resolution, &mut scratch) {
        return Ok(vec![start.to_vec(), goal.to_vec()]);
    }
    let range = |(dof, from): (&crate::geom::kinematics::Dof, &f64)| {
        let lower = if dof.lower.is_finite() { dof.lower } else { from - PI };
        let upper = if dof.upper.is_finite() { dof.upper } else { from + PI };
        (lower, upper)
    };
    let ranges: Vec<(f64, f64)> = space.dofs().iter().zip(start).map(range).collect();
    let mut growing = Tree::new(start);
    let mut other = Tree::new(goal);
    let mut starts_at_start = true;
    let mut sample = vec![0.0; dim];
    for _ in 0..settings.max_samples {
        for (v, (lower, upper)) in sample.iter_mut().zip(&ranges) {
            *v = lower + rng.random::<f64>() * (upper - lower);
        }
        let from = growing.nearest(&sample);
        if let Some(new) = growing.extend(from, &sample, space, settings, &mut scratch) {
            let target = growing.node(new).to_vec();
            if let Some(met) = other.connect(&target, space, settings, &mut scratch) {
                let (mut path, mut rest) = (growing.branch(new), other.branch(met));
                if !starts_at_start {
                    std::mem::swap(&mut path, &mut rest);
                }
                path.reverse();
                // Both branches end where they met.
                path.pop();
                path.append(&mut rest);
                return Ok(path);
            }
        }
        if growing.len() > other.len() {
            std::mem::swap(&mut growing, &mut other);
            starts_at_start = !starts_at_start;
        }
    }
    Err(NoPath::OutOfSamples {
        drawn: settings.max_samples,
    })
}

/// Configurations in one array; `parents[0]` is the root's own index.
struct Tree {
    dim: usize,
    nodes: Vec<f64>,
    parents: Vec<usize>,
}

impl Tree {
    fn new(root: &[f64]) -> Tree {
        Tree {
            dim: root.len(),
            nodes: root.to_vec(),
            parents: vec![0],
        }
    }

    fn len(&self) -> usize {
        self.parents.len()
    }

    fn node(&self, i: usize) -> &[f64] {
        &self.nodes[i * self.dim..(i + 1) * self.dim]
    }

    /// The nearest node; the older one of two that are as near.
    fn nearest(&self, q: &[f64]) -> usize {
        let (mut best, mut least) = (0, f64::INFINITY);
        for (i, node) in self.nodes.chunks_exact(self.dim.max(1)).enumerate() {
            let mut sum = 0.0;
            for (a, b) in node.iter().zip(q) {
                sum += (a - b) * (a - b);
            }
            if sum < least {
                (best, least) = (i, sum);
            }
        }
        best
    }

    /// Adds a node at most one step from `from` towards `q`; `None` when the way is not free or there is none to go.
    fn extend(
        &mut self,
        from: usize,
        q: &[f64],
        space: &mut dyn Space,
        settings: &Settings,
        scratch: &mut Vec<f64>,
    ) -> Option<usize> {
        let distance = length(self.node(from), q);
        if distance == 0.0 {
            return None;
        }
        let mut new = Vec::with_capacity(self.dim);
        if distance <= settings.step {
            new.extend_from_slice(q);
        } else {
            interpolate(self.node(from), q, settings.step / distance, &mut new);
        }
        if !onward_is_free(space, self.node(from), &new, settings.resolution, scratch) {
            return None;
        }
        self.nodes.append(&mut new);
        self.parents.push(from);
        Some(self.len() - 1)
    }

    /// Walks from the nearest node to `q` until it is there, and returns its node; `None` when something is in the way.
    fn connect(
        &mut self,
        q: &[f64],
        space: &mut dyn Space,
        settings: &Settings,
        scratch: &mut Vec<f64>,
    ) -> Option<usize> {
        let mut at = self.nearest(q);
        // Each step shortens the way by `step`; the count guards against one too small to change anything.
        let n_steps = (length(self.node(at), q) / settings.step).ceil().min(MAX_STEPS) as usize + 1;
        for _ in 0..n_steps {
            if self.node(at) == q {
                return Some(at);
            }
            at = self.extend(at, q, space, settings, scratch)?;
        }
        (self.node(at) == q).then_some(at)
    }

    /// The nodes from `i` to the root.
    fn branch(&self, mut i: usize) -> Path {
        let mut path = vec![self.node(i).to_vec()];
        while i != 0 {
            i = self.parents[i];
            path.push(self.node(i).to_vec());
        }
        path
    }
}

/// A walk between the trees has so many steps at most.
const MAX_STEPS: f64 = 10_000.0;
