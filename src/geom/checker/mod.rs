//! Whether configurations of a mechanism are free: of itself and of what stands around it.
//!
//! A [`Rig`] is what moves, a [`Checker`] is a rig among obstacles. A check goes from coarse to fine: bit rows say which obstacles are
//! near to a body (`sweep`), balls around the bodies which are not ([`super::cover`]), balls within them which are hit, and the
//! exact test (`collide::within`) decides what is left. The answer is always that of the exact test on every pair: covers only say what
//! it would say, with a micrometre to spare. Eight configurations are checked at a time ([`Checker::are_free`],
//! [`Checker::all_free`]) in vector instructions, as in Thomason, Kingston, Kavraki, ICRA 2024 (doi:10.1109/ICRA57147.2024.10611190),
//! who trust balls alone.
//! Does not know why two things may touch: the caller says so, pair by pair. Does not sweep: what lies between two configurations is not seen.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

mod covers;
mod lanes;
mod pass;
mod rig;
mod sweep;

use std::sync::Arc;

use super::Pose;
use super::collide::within;
use super::cover::Form;
use covers::SURE;
use lanes::{Fixed, Lanes};
use pass::{Scratch, Until};
use rig::PlacedJoint;
use sweep::Sweep;

pub use rig::{Body, Rig};

/// So many configurations are checked at a time.
pub const LANES: usize = 8;

/// A convex body that stands still.
#[derive(Debug, Clone)]
pub struct Obstacle {
    /// Pose of its shape in the world.
    pub X_WS: Pose,
    pub form: Arc<Form>,
}

/// A body of the rig, then those that it carries besides; or an obstacle, by its place in the caller's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Item {
    Body(usize),
    Obstacle(usize),
}

/// A rig among obstacles. Made anew when something else has moved.
#[derive(Debug)]
pub struct Checker {
    rig: Arc<Rig>,
    joints: Vec<PlacedJoint>,
    /// The tree's configuration; the checked dofs count for nothing.
    rest: Vec<f64>,
    moving: Vec<Moving>,
    standing: Vec<Standing>,
    sweep: Sweep,
    /// By moving body and word: the standing ones that it has to keep away from.
    masks: Vec<u64>,
    /// By moving and standing body [m].
    margins: Vec<f64>,
    inner: Vec<Inner>,
    alone: Scratch<1>,
    together: Scratch<LANES>,
    n_checks: u64,
}

/// A body that moves.
#[derive(Debug)]
struct Moving {
    item: Item,
    joint: usize,
    X_NS: Fixed,
    form: Arc<Form>,
    /// The centre of the ball around it, in its own frame [m].
    centre: [f64; 3],
    /// The most that it has to keep away from something standing [m].
    most_margin: f64,
}

/// A body that stands.
#[derive(Debug)]
struct Standing {
    item: Item,
    X_WS: Pose,
    place: Fixed,
    form: Arc<Form>,
}

/// Two moving bodies that have to keep apart.
#[derive(Debug, Clone, Copy)]
struct Inner {
    a: usize,
    b: usize,
    margin: f64,
    /// Farther apart than this, the balls around both say that they are free [m].
    most: f64,
    /// Whether the balls of the second are tested against the shape of the first, not the other way round.
    by_second: bool,
}

impl Checker {
    /// Puts the rig among obstacles. `X_WL` are the poses of all links of its tree, `q` the tree's whole configuration; `carried` are
    /// bodies that links carry besides (what a hand holds).
    ///
    /// `margin` says how far two items have to stay apart [m, not negative]: 0 for "may not touch", `None` for a pair that may touch. It is
    /// asked about each pair that can come nearer to each other once.
    pub fn new(
        rig: &Arc<Rig>,
        X_WL: &[Pose],
        q: &[f64],
        carried: &[Body],
        obstacles: &[Obstacle],
        margin: &dyn Fn(Item, Item) -> Option<f64>,
    ) -> Checker {
        let mut checker = Checker {
            joints: rig.joints.iter().map(|j| PlacedJoint::new(j, X_WL)).collect(),
            rig: Arc::clone(rig),
            rest: q.to_vec(),
            moving: Vec::new(),
            standing: Vec::new(),
            sweep: Sweep::default(),
            masks: Vec::new(),
            margins: Vec::new(),
            inner: Vec::new(),
            alone: Scratch::default(),
            together: Scratch::default(),
            n_checks: 0,
        };
        for (i, body) in rig.bodies.iter().chain(carried).enumerate() {
            match rig.links.get(body.link).copied().flatten() {
                Some((joint, X_NL)) => checker.add_moving(Item::Body(i), joint, &(X_NL * body.X_LS), &body.form),
                None => {
                    let X_WL = X_WL.get(body.link).copied().unwrap_or_default();
                    checker.add_standing(Item::Body(i), X_WL * body.X_LS, &body.form);
                }
            }
        }
        for (j, obstacle) in obstacles.iter().enumerate() {
            checker.add_standing(Item::Obstacle(j), obstacle.X_WS, &obstacle.form);
        }
        checker.pair_up(margin);
        checker
    }

    fn add_moving(&mut self, item: Item, joint: usize, X_NS: &Pose, form: &Arc<Form>) {
        self.moving.push(Moving {
            item,
            joint,
            X_NS: Fixed::new(X_NS),
            form: Arc::clone(form),
            centre: form.whole().centre.into(),
            most_margin: 0.0,
        });
    }

    fn add_standing(&mut self, item: Item, X_WS: Pose, form: &Arc<Form>) {
        self.standing.push(Standing {
            item,
            X_WS,
            place: Fixed::new(&X_WS),
            form: Arc::clone(form),
        });
    }

    fn pair_up(&mut self, margin: &dyn Fn(Item, Item) -> Option<f64>) {
        let boxes: Vec<_> = self.standing.iter().map(|s| s.form.bounds(&s.X_WS)).collect();
        self.sweep = Sweep::new(&boxes);
        let (n, words) = (self.standing.len(), self.sweep.words());
        self.masks = vec![0; self.moving.len() * words];
        self.margins = vec![0.0; self.moving.len() * n];
        for (i, a) in self.moving.iter_mut().enumerate() {
            for (j, b) in self.standing.iter().enumerate() {
                if let Some(m) = margin(a.item, b.item) {
                    self.masks[i * words + j / 64] |= 1 << (j % 64);
                    self.margins[i * n + j] = m;
                    a.most_margin = a.most_margin.max(m);
                }
            }
        }
        for (i, a) in self.moving.iter().enumerate() {
            for (j, b) in self.moving.iter().enumerate().skip(i + 1) {
                if let Some(margin) = margin(a.item, b.item) {
                    self.inner.push(Inner {
                        a: i,
                        b: j,
                        margin,
                        most: a.form.whole().radius + b.form.whole().radius + margin + SURE,
                        by_second: a.form.excess() > b.form.excess(),
                    });
                }
            }
        }
    }

    /// Returns the dofs of a checked configuration (indices into `Tree::dofs`), in its order.
    pub fn dofs(&self) -> &[usize] {
        self.rig.dofs()
    }

    /// Returns how many configurations have been checked.
    pub fn n_checks(&self) -> u64 {
        self.n_checks
    }

    /// Sets a dof that is not checked (a finger's); of use for those that the rig was made with.
    pub fn set_rest(&mut self, dof: usize, value: f64) {
        if let Some(v) = self.rest.get_mut(dof) {
            *v = value;
        }
    }

    /// Changes how far two items have to stay apart, as in [`Checker::new`]. A pair of moving bodies that may touch stays so.
    pub fn set_margin(&mut self, a: Item, b: Item, margin: Option<f64>) {
        let place = |list: &[Item], item: Item| list.iter().position(|i| *i == item);
        let moving: Vec<Item> = self.moving.iter().map(|m| m.item).collect();
        let standing: Vec<Item> = self.standing.iter().map(|s| s.item).collect();
        for (a, b) in [(a, b), (b, a)] {
            if let (Some(i), Some(j)) = (place(&moving, a), place(&standing, b)) {
                let bit = 1 << (j % 64);
                let word = &mut self.masks[i * self.sweep.words() + j / 64];
                *word = if margin.is_some() { *word | bit } else { *word & !bit };
                let row = i * self.standing.len()..(i + 1) * self.standing.len();
                self.margins[row.start + j] = margin.unwrap_or(0.0);
                self.moving[i].most_margin = self.margins[row].iter().copied().fold(0.0, f64::max);
                return;
            }
        }
        let Some((i, j)) = place(&moving, a).zip(place(&moving, b)) else {
            return;
        };
        let is_pair = |p: &Inner| (p.a, p.b) == (i.min(j), i.max(j));
        match margin {
            Some(margin) => {
                for pair in self.inner.iter_mut().filter(|p| is_pair(p)) {
                    pair.most += margin - pair.margin;
                    pair.margin = margin;
                }
            }
            None => self.inner.retain(|p| !is_pair(p)),
        }
    }

    /// Says whether a configuration is free; `q` in the order of [`Checker::dofs`], what it lacks is 0. One with a number that is not finite hits
    /// whatever it has to keep away from.
    pub fn is_free(&mut self, q: &[f64]) -> bool {
        let mut scratch = std::mem::take(&mut self.alone);
        scratch.q.clear();
        scratch.q.extend(q.iter().map(|v| Lanes([*v])));
        let hit = self.pass(&mut scratch, Until::Decided);
        self.alone = scratch;
        self.n_checks += 1;
        hit == 0
    }

    /// Says of each of eight configurations whether it is free; `q[i][k]` is the value of dof `i` in configuration `k`.
    pub fn are_free(&mut self, q: &[[f64; LANES]]) -> [bool; LANES] {
        self.n_checks += LANES as u64;
        let hit = self.eight(q, Until::Decided);
        std::array::from_fn(|k| hit >> k & 1 == 0)
    }

    /// Says whether all configurations are free, which stand one after the other in `qs`; ends early when one is not.
    pub fn all_free(&mut self, qs: &[f64]) -> bool {
        let n = self.dofs().len();
        if n == 0 {
            return self.is_free(&[]);
        }
        qs.chunks(n * LANES).all(|some| {
            let rows: Vec<&[f64]> = some.chunks_exact(n).collect();
            match rows.as_slice() {
                [] => true,
                [q] => self.is_free(q),
                // The last one fills the lanes that are left.
                [.., last] => {
                    let of = |k: usize| rows.get(k).unwrap_or(last);
                    let columns: Vec<[f64; LANES]> = (0..n).map(|i| std::array::from_fn(|k| of(k)[i])).collect();
                    self.n_checks += rows.len() as u64;
                    self.eight(&columns, Until::FirstHit) == 0
                }
            }
        })
    }

    fn eight(&mut self, q: &[[f64; LANES]], until: Until) -> u32 {
        let mut scratch = std::mem::take(&mut self.together);
        scratch.q.clear();
        scratch.q.extend(q.iter().map(|v| Lanes(*v)));
        let hit = self.pass(&mut scratch, until);
        self.together = scratch;
        hit
    }

    /// Returns who is too near to whom at `q`: a moving body and an obstacle in the order in which they were given, then two moving bodies.
    pub fn hits(&self, q: &[f64]) -> Vec<(Item, Item)> {
        let mut found = Vec::new();
        self.each_hit(q, &mut |a, b| {
            found.push((a, b));
            true
        });
        found
    }

    /// Returns the first of [`Checker::hits`].
    pub fn first_hit(&self, q: &[f64]) -> Option<(Item, Item)> {
        let mut found = None;
        self.each_hit(q, &mut |a, b| {
            found = Some((a, b));
            false
        });
        found
    }

    /// Returns the moving and standing bodies that have to keep apart and are within `margin` [m] of each other at `q`, whatever margin they have.
    pub fn near(&self, q: &[f64], margin: f64) -> Vec<(Item, Item)> {
        self.standing_near(q, margin)
    }

    /// Returns the first standing body that a form at a pose touches, of those of which `counts` says so.
    pub fn touched(&self, form: &Form, X_WS: &Pose, counts: &dyn Fn(Item) -> bool) -> Option<Item> {
        let (low, high) = form.bounds(X_WS);
        let centre: [f64; 3] = (0.5 * (low + high)).into();
        let rows = self.sweep.rows(&centre, 0.5 * (high - low).max() + SURE);
        for (j, other) in self.standing.iter().enumerate() {
            if rows.word(j / 64) >> (j % 64) & 1 == 1
                && counts(other.item)
                && within(form.solid(), X_WS, other.form.solid(), &other.X_WS, 0.0)
            {
                return Some(other.item);
            }
        }
        None
    }
}
