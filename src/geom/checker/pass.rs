//! One pass over all pairs, from coarse to fine, for several configurations at once.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use super::lanes::{Fixed, Lanes, Points, Poses, apart2};
use super::rig::place;
use super::{Checker, Item, MovedBall, Moving};
use crate::geom::collide::{Core, Solid, within};

/// A cover decides when it is sure by as much [m]: more than what the exact test and the poses are rounded by.
const SURE: f64 = 1e-6;

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
    X_WN: Vec<Poses<N>>,
    /// Centres of the balls around whole bodies.
    wholes: Vec<Points<N>>,
    /// What covers could not decide.
    unsure: Vec<Unsure>,
    near: Vec<[u64; N]>,
}

impl<const N: usize> Default for Scratch<N> {
    fn default() -> Self {
        Scratch {
            q: Vec::new(),
            X_WN: Vec::new(),
            wholes: Vec::new(),
            unsure: Vec::new(),
            near: Vec::new(),
        }
    }
}

/// A pair, and the lanes of those configurations in which only the exact test can say.
#[derive(Debug, Clone, Copy)]
struct Unsure {
    pair: Pair,
    lanes: u32,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Pair {
    /// A moving and a standing body.
    Outer(usize, usize),
    /// A place in `Checker::inner`.
    Inner(usize),
}

/// What a cover says, by lanes.
#[derive(Debug, Clone, Copy)]
struct Said {
    /// Not surely free.
    maybe: u32,
    /// Surely hit.
    hit: u32,
}

/// Where the shape of the other body is.
enum At<'a, const N: usize> {
    Standing(&'a Fixed),
    Moving(&'a Poses<N>, &'a Fixed),
}

impl<const N: usize> At<'_, N> {
    /// Maps points of the world into the shape's frame.
    #[inline(always)]
    fn into_shape(&self, p: &Points<N>) -> Points<N> {
        match self {
            At::Standing(X_WS) => X_WS.inverse_of(p),
            At::Moving(X_WN, X_NS) => X_NS.inverse_of(&X_WN.inverse_of(p)),
        }
    }
}

impl Checker {
    /// Returns the lanes that are hit. With [`Until::FirstHit`] at least one of them, if there is one.
    pub(super) fn pass<const N: usize>(&self, s: &mut Scratch<N>, until: Until) -> u32 {
        let all = (1u32 << N) - 1;
        self.put(s);
        let mut hit = 0;
        let done = |hit: u32| hit == all || (until == Until::FirstHit && hit != 0);
        for k in 0..self.inner.len() {
            let said = self.inner_said(s, k, all & !hit);
            hit |= said.hit;
            if done(hit) {
                return hit;
            }
            note(s, Pair::Inner(k), said);
        }
        for i in 0..self.moving.len() {
            let mut standing = std::mem::take(&mut s.near);
            self.near(s, i, &mut standing);
            for (w, rows) in standing.iter().enumerate() {
                let mut any = rows.iter().fold(0, |any, row| any | row);
                while any != 0 {
                    let bit = any.trailing_zeros();
                    any &= any - 1;
                    let lanes = (0..N).fold(0, |lanes, l| lanes | ((rows[l] >> bit & 1) as u32) << l);
                    let j = 64 * w + bit as usize;
                    let said = self.outer_said(s, i, j, lanes & !hit);
                    hit |= said.hit;
                    note(s, Pair::Outer(i, j), said);
                }
            }
            s.near = standing;
            if done(hit) {
                return hit;
            }
        }
        for unsure in std::mem::take(&mut s.unsure) {
            let mut lanes = unsure.lanes & !hit;
            while lanes != 0 {
                let lane = lanes.trailing_zeros();
                lanes &= lanes - 1;
                if self.exact(s, unsure.pair, lane as usize) {
                    hit |= 1 << lane;
                    if done(hit) {
                        return hit;
                    }
                }
            }
        }
        hit
    }

    /// Calls `found` with the pairs that are too near in one configuration, in order, until it says no.
    pub(super) fn each_hit(&mut self, q: &[f64], found: &mut dyn FnMut(Item, Item) -> bool) {
        let mut s = std::mem::take(&mut self.alone);
        s.q.clear();
        s.q.extend(q.iter().map(|v| Lanes([*v])));
        self.put(&mut s);
        let mut near = Vec::new();
        let mut rows = std::mem::take(&mut s.near);
        for i in 0..self.moving.len() {
            self.near(&s, i, &mut rows);
            for (w, row) in rows.iter().enumerate() {
                for j in (0..64).filter(|bit| row[0] >> bit & 1 == 1).map(|bit| 64 * w + bit) {
                    let said = self.outer_said(&s, i, j, 1);
                    if said.maybe | said.hit != 0 {
                        near.push((Pair::Outer(i, j), said));
                    }
                }
            }
        }
        s.near = rows;
        for k in 0..self.inner.len() {
            let said = self.inner_said(&s, k, 1);
            if said.maybe | said.hit != 0 {
                near.push((Pair::Inner(k), said));
            }
        }
        for (pair, said) in near {
            if said.hit != 0 || self.exact(&s, pair, 0) {
                let (a, b) = match pair {
                    Pair::Outer(i, j) => (self.moving[i].item, self.standing[j].item),
                    Pair::Inner(k) => (self.moving[self.inner[k].a].item, self.moving[self.inner[k].b].item),
                };
                if !found(a, b) {
                    break;
                }
            }
        }
        self.alone = s;
    }

    /// Puts all joints and the balls around whole bodies where the configurations have them.
    #[inline(always)]
    fn put<const N: usize>(&self, s: &mut Scratch<N>) {
        place(&self.joints, &s.q, &self.rest, &mut s.X_WN);
        s.wholes.clear();
        s.unsure.clear();
        for body in &self.moving {
            s.wholes.push(s.X_WN[body.joint].of(&body.whole.p));
        }
    }

    /// What covers say of the pair `k` of moving bodies.
    #[inline(always)]
    fn inner_said<const N: usize>(&self, s: &Scratch<N>, k: usize, lanes: u32) -> Said {
        let pair = &self.inner[k];
        let (a, b) = (&self.moving[pair.a], &self.moving[pair.b]);
        let most = a.whole.radius + b.whole.radius + pair.margin + SURE;
        let near = apart2(&s.wholes[pair.a], &s.wholes[pair.b]).not_above(most * most) & lanes;
        if near == 0 {
            return Said { maybe: 0, hit: 0 };
        }
        let (balls, shape, whole) = if pair.by_second {
            (b, a, &s.wholes[pair.b])
        } else {
            (a, b, &s.wholes[pair.a])
        };
        let at = At::Moving(&s.X_WN[shape.joint], &shape.X_NS);
        self.covers_say(s, balls, whole, shape.form.solid(), &at, pair.margin, near)
    }

    /// What covers say of a moving and a standing body.
    #[inline(always)]
    fn outer_said<const N: usize>(&self, s: &Scratch<N>, i: usize, j: usize, lanes: u32) -> Said {
        let (body, standing) = (&self.moving[i], &self.standing[j]);
        let at = At::Standing(&standing.place);
        let margin = self.margins[i * self.standing.len() + j];
        self.covers_say(s, body, &s.wholes[i], standing.form.solid(), &at, margin, lanes)
    }

    /// Finds the standing bodies whose boxes are near to the ball around the moving body `i`, by word and lane.
    #[inline(always)]
    fn near<const N: usize>(&self, s: &Scratch<N>, i: usize, rows: &mut Vec<[u64; N]>) {
        let words = self.sweep.words();
        rows.clear();
        rows.resize(words, [0; N]);
        let mask = &self.masks[i * words..(i + 1) * words];
        let r = self.moving[i].whole.radius + self.most_margin[i] + SURE;
        let p = &s.wholes[i];
        for l in 0..N {
            let p = [p[0].0[l], p[1].0[l], p[2].0[l]];
            if (p[0] + p[1] + p[2]).is_finite() {
                self.sweep.near(p, r, |w, bits| rows[w][l] = bits & mask[w]);
            } else {
                rows.iter_mut().zip(mask).for_each(|(row, mask)| row[l] = *mask);
            }
        }
    }

    /// The balls of `body` against a shape with `margin` around it.
    #[inline(always)]
    fn covers_say<const N: usize>(
        &self,
        s: &Scratch<N>,
        body: &Moving,
        whole: &Points<N>,
        shape: &Solid,
        at: &At<'_, N>,
        margin: f64,
        lanes: u32,
    ) -> Said {
        let grown = shape.round + margin;
        let first = ball_says(&body.whole, &at.into_shape(whole), shape, grown);
        let (mut maybe, mut hit) = (first.maybe & lanes, first.hit & lanes);
        maybe &= !hit;
        if maybe != 0 && body.last - body.first > 1 {
            let mut left = 0;
            for ball in &self.balls[body.first..body.last] {
                let p = s.X_WN[body.joint].of(&ball.p);
                let said = ball_says(ball, &at.into_shape(&p), shape, grown);
                left |= said.maybe;
                hit |= said.hit & maybe;
            }
            maybe &= left & !hit;
        }
        Said { maybe, hit }
    }

    /// The exact test of a pair in one lane.
    fn exact<const N: usize>(&self, s: &Scratch<N>, pair: Pair, lane: usize) -> bool {
        let pose = |body: &Moving| s.X_WN[body.joint].lane(lane) * body.X_NS_pose;
        match pair {
            Pair::Outer(i, j) => {
                let (a, b) = (&self.moving[i], &self.standing[j]);
                let margin = self.margins[i * self.standing.len() + j];
                within(a.form.solid(), &pose(a), b.form.solid(), &b.X_WS, margin)
            }
            Pair::Inner(k) => {
                let pair = &self.inner[k];
                let (a, b) = (&self.moving[pair.a], &self.moving[pair.b]);
                within(a.form.solid(), &pose(a), b.form.solid(), &pose(b), pair.margin)
            }
        }
    }
}

#[inline(always)]
fn note<const N: usize>(s: &mut Scratch<N>, pair: Pair, said: Said) {
    if said.maybe != 0 {
        s.unsure.push(Unsure {
            pair,
            lanes: said.maybe,
        });
    }
}

/// One ball, its centre measured in the shape's frame, against the shape grown by `grown` beyond its core.
#[inline(always)]
fn ball_says<const N: usize>(ball: &MovedBall, p: &Points<N>, shape: &Solid, grown: f64) -> Said {
    let far = ball.radius + grown + SURE;
    let near = ball.within + grown - SURE;
    let is_within = ball.within >= 0.0 && near > 0.0;
    let squares = |p: &Points<N>, half: [f64; 3]| {
        let x = (p[0].abs() + -half[0]).at_least(0.0);
        let y = (p[1].abs() + -half[1]).at_least(0.0);
        let z = (p[2].abs() + -half[2]).at_least(0.0);
        x * x + y * y + z * z
    };
    let apart2 = match shape.core {
        Core::Point | Core::Segment { .. } | Core::Box { .. } => squares(p, shape.half.into()),
        Core::Cylinder { radius, half_length } => {
            let across = ((p[0] * p[0] + p[1] * p[1]).sqrt() + -radius).at_least(0.0);
            let along = (p[2].abs() + -half_length).at_least(0.0);
            across * across + along * along
        }
        Core::Hull(ref hull) => {
            let maybe = squares(p, shape.half.into()).not_above(far * far);
            if maybe == 0 {
                return Said { maybe: 0, hit: 0 };
            }
            // Beyond a face by as much means apart by at least as much; behind all of them is inside.
            let mut beyond = Lanes::all(f64::NEG_INFINITY);
            for face in &hull.faces {
                let n = face.normal;
                beyond = beyond.max(p[0] * n.x + p[1] * n.y + p[2] * n.z + -face.offset);
            }
            let hit = if is_within { beyond.below(-SURE) } else { 0 };
            return Said {
                maybe: maybe & beyond.not_above(far),
                hit,
            };
        }
    };
    Said {
        maybe: apart2.not_above(far * far),
        hit: if is_within { apart2.below(near * near) } else { 0 },
    }
}
