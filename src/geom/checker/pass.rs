//! One pass over all pairs, from coarse to fine, for several configurations at once.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::covers::{SURE, Said, say};
use super::lanes::{Fixed, Lanes, Points, Poses, apart2, lane_of};
use super::rig::place;
use super::{Checker, Item};
use crate::geom::Pose;
use crate::geom::collide::within;

/// When a pass may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// When each configuration is decided.
    Decided,
    /// When one is hit.
    FirstHit,
}

/// What a pass needs and leaves behind.
#[derive(Debug)]
pub(super) struct Scratch<const N: usize> {
    /// The configurations, by column.
    pub q: Vec<Lanes<N>>,
    /// By joint.
    X_WN: Vec<Poses<N>>,
    /// By moving body.
    X_WS: Vec<Poses<N>>,
    /// Centres of the balls around whole bodies.
    wholes: Vec<Points<N>>,
    /// Pairs that covers could not decide, and in which lane.
    unsure: Vec<(Pair, usize)>,
}

impl<const N: usize> Default for Scratch<N> {
    fn default() -> Self {
        Scratch {
            q: Vec::new(),
            X_WN: Vec::new(),
            X_WS: Vec::new(),
            wholes: Vec::new(),
            unsure: Vec::new(),
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Pair {
    /// A moving and a standing body.
    Outer(usize, usize),
    /// A place in `Checker::inner`.
    Inner(usize),
}

impl Checker {
    /// Returns the lanes that are hit. With [`Until::FirstHit`] at least one of them, if there is one.
    pub(super) fn pass<const N: usize>(&self, s: &mut Scratch<N>, until: Until) -> u32 {
        let all = (1u32 << N) - 1;
        self.put(s);
        let mut hit = 0;
        let done = |hit: u32| hit == all || (until == Until::FirstHit && hit != 0);
        for k in 0..self.inner.len() {
            for lane in bits(u64::from(self.inner_near(s, k) & !hit)) {
                match self.inner_said(s, k, lane) {
                    Said::Free => {}
                    Said::Unsure => s.unsure.push((Pair::Inner(k), lane)),
                    Said::Hit => {
                        hit |= 1 << lane;
                        if done(hit) {
                            return hit;
                        }
                    }
                }
            }
        }
        for i in 0..self.moving.len() {
            for lane in bits(u64::from(all & !hit)) {
                let is_hit = self.outer_near(s, i, lane, None, |s, j, said| match said {
                    Said::Hit => true,
                    Said::Unsure => {
                        s.unsure.push((Pair::Outer(i, j), lane));
                        false
                    }
                    Said::Free => false,
                });
                if is_hit {
                    hit |= 1 << lane;
                    if done(hit) {
                        return hit;
                    }
                }
            }
        }
        for (pair, lane) in &s.unsure {
            if hit >> lane & 1 == 0 && self.exact(s, *pair, *lane, None) {
                hit |= 1 << lane;
                if done(hit) {
                    return hit;
                }
            }
        }
        hit
    }

    /// Calls `found` with the pairs that are too near in one configuration, in order, until it says no.
    pub(super) fn each_hit(&self, q: &[f64], found: &mut dyn FnMut(Item, Item) -> bool) {
        let mut s = Scratch::<1>::default();
        s.q.extend(q.iter().map(|v| Lanes([*v])));
        self.put(&mut s);
        let mut near = Vec::new();
        for i in 0..self.moving.len() {
            self.outer_near(&mut s, i, 0, None, |_, j, said| {
                near.push((Pair::Outer(i, j), said));
                false
            });
        }
        for k in (0..self.inner.len()).filter(|k| self.inner_near(&s, *k) != 0) {
            near.push((Pair::Inner(k), self.inner_said(&s, k, 0)));
        }
        for (pair, said) in near {
            let is_hit = match said {
                Said::Free => false,
                Said::Hit => true,
                Said::Unsure => self.exact(&s, pair, 0, None),
            };
            if is_hit {
                let (a, b) = match pair {
                    Pair::Outer(i, j) => (self.moving[i].item, self.standing[j].item),
                    Pair::Inner(k) => (self.moving[self.inner[k].a].item, self.moving[self.inner[k].b].item),
                };
                if !found(a, b) {
                    break;
                }
            }
        }
    }

    /// Returns the pairs of a moving and a standing body that have to keep apart and are within `margin` at `q`, whatever their own margin.
    pub(super) fn standing_near(&self, q: &[f64], margin: f64) -> Vec<(Item, Item)> {
        let mut s = Scratch::<1>::default();
        s.q.extend(q.iter().map(|v| Lanes([*v])));
        self.put(&mut s);
        let mut found = Vec::new();
        for i in 0..self.moving.len() {
            self.outer_near(&mut s, i, 0, Some(margin), |s, j, said| {
                if said == Said::Hit || self.exact(s, Pair::Outer(i, j), 0, Some(margin)) {
                    found.push((self.moving[i].item, self.standing[j].item));
                }
                false
            });
        }
        found
    }

    /// Puts all bodies where the configurations have them.
    #[inline(always)]
    fn put<const N: usize>(&self, s: &mut Scratch<N>) {
        place(&self.joints, &s.q, &self.rest, &mut s.X_WN);
        s.unsure.clear();
        let n = self.moving.len();
        s.X_WS.resize(n, Poses::all(&Fixed::new(&Pose::identity())));
        s.wholes.resize(n, [Lanes::all(0.0); 3]);
        for (i, body) in self.moving.iter().enumerate() {
            let X_WS = &mut s.X_WS[i];
            X_WS.set(&s.X_WN[body.joint], &body.X_NS);
            s.wholes[i] = if body.centre == [0.0; 3] {
                X_WS.p
            } else {
                X_WS.of(&body.centre)
            };
        }
    }

    /// The lanes in which the balls around two moving bodies come near to each other.
    #[inline(always)]
    fn inner_near<const N: usize>(&self, s: &Scratch<N>, k: usize) -> u32 {
        let pair = &self.inner[k];
        apart2(&s.wholes[pair.a], &s.wholes[pair.b]).not_above(pair.most * pair.most)
    }

    /// What covers say of a pair of moving bodies.
    #[inline(always)]
    fn inner_said<const N: usize>(&self, s: &Scratch<N>, k: usize, lane: usize) -> Said {
        let pair = &self.inner[k];
        let (a, b) = if pair.by_second {
            (pair.b, pair.a)
        } else {
            (pair.a, pair.b)
        };
        let centre = lane_of(&s.wholes[a], lane);
        let X_WB = s.X_WS[b].lane(lane);
        say(
            &self.moving[a].form,
            &|| s.X_WS[a].lane(lane),
            &centre,
            &self.moving[b].form,
            &X_WB,
            pair.margin,
        )
    }

    /// Calls `found` with each standing body whose box is near to the ball around the moving body `i`, and with what covers say of them, until it
    /// says yes; returns whether it did.
    #[inline(always)]
    fn outer_near<const N: usize>(
        &self,
        s: &mut Scratch<N>,
        i: usize,
        lane: usize,
        margin: Option<f64>,
        mut found: impl FnMut(&mut Scratch<N>, usize, Said) -> bool,
    ) -> bool {
        let body = &self.moving[i];
        let words = self.sweep.words();
        let mask = &self.masks[i * words..(i + 1) * words];
        let centre = lane_of(&s.wholes[i], lane);
        let rows = self.sweep.rows(
            &centre,
            body.form.whole().radius + margin.unwrap_or(body.most_margin) + SURE,
        );
        for (w, mask) in mask.iter().enumerate() {
            let near = rows.word(w) & mask;
            if near == 0 {
                continue;
            }
            for j in bits(near).map(|bit| 64 * w + bit) {
                let other = &self.standing[j];
                let margin = margin.unwrap_or(self.margins[i * self.standing.len() + j]);
                let said = say(
                    &body.form,
                    &|| s.X_WS[i].lane(lane),
                    &centre,
                    &other.form,
                    &other.place,
                    margin,
                );
                if said != Said::Free && found(s, j, said) {
                    return true;
                }
            }
        }
        false
    }

    /// The exact test of a pair in one lane, with `margin` in place of the pair's own if there is one.
    fn exact<const N: usize>(&self, s: &Scratch<N>, pair: Pair, lane: usize, margin: Option<f64>) -> bool {
        let pose = |i: usize| s.X_WS[i].lane(lane).pose();
        match pair {
            Pair::Outer(i, j) => {
                let (a, b) = (&self.moving[i], &self.standing[j]);
                let margin = margin.unwrap_or(self.margins[i * self.standing.len() + j]);
                within(a.form.solid(), &pose(i), b.form.solid(), &b.X_WS, margin)
            }
            Pair::Inner(k) => {
                let pair = &self.inner[k];
                let (a, b) = (&self.moving[pair.a], &self.moving[pair.b]);
                within(
                    a.form.solid(),
                    &pose(pair.a),
                    b.form.solid(),
                    &pose(pair.b),
                    margin.unwrap_or(pair.margin),
                )
            }
        }
    }
}

/// The places of the bits that are set, ascending.
fn bits(mut row: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = row.trailing_zeros() as usize;
        (row != 0).then(|| {
            row &= row - 1;
            bit
        })
    })
}
