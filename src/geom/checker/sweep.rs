//! A broad phase: which of many boxes that stand still a box meets, as bits.
//!
//! Each axis is cut into slots. For each slot and each axis a row of bits says which things begin at or before it, another which end at
//! or after it; a query joins six rows. As coarse as the slots, never too little: a thing that is left out does not meet the box. This is the
//! test of intervals of sweep and prune (Cohen, Lin, Manocha, Ponamgi, I3D 1995, doi:10.1145/199404.199437), by bit rows instead of
//! sorted lists, so that it is made in a microsecond and needs no memory of the query before.

use crate::geom::Vec3;

/// Along each axis.
const SLOTS: usize = 64;

/// Boxes along the axes of W.
#[derive(Debug, Clone, Default)]
pub struct Sweep {
    /// Numbers of 64 bits for a row.
    words: usize,
    lower: [f64; 3],
    /// Slots per metre.
    scale: [f64; 3],
    /// By axis, slot, word: who begins at or before the slot.
    begun: Vec<u64>,
    /// Who ends at or after it.
    open: Vec<u64>,
}

impl Sweep {
    /// Makes the rows of boxes, given by their lower and upper corners [m].
    pub fn new(boxes: &[(Vec3, Vec3)]) -> Sweep {
        let words = boxes.len().div_ceil(64);
        let mut lower = [f64::INFINITY; 3];
        let mut upper = [f64::NEG_INFINITY; 3];
        for (low, high) in boxes {
            for axis in 0..3 {
                lower[axis] = lower[axis].min(low[axis]);
                upper[axis] = upper[axis].max(high[axis]);
            }
        }
        let scale = std::array::from_fn(|axis| {
            let width = upper[axis] - lower[axis];
            // What is not finite has all in one slot.
            if width > 0.0 && width.is_finite() {
                SLOTS as f64 / width
            } else {
                0.0
            }
        });
        let mut sweep = Sweep {
            words,
            lower,
            scale,
            begun: vec![0; 3 * SLOTS * words],
            open: vec![0; 3 * SLOTS * words],
        };
        for (i, (low, high)) in boxes.iter().enumerate() {
            for axis in 0..3 {
                let (first, last) = (sweep.slot(axis, low[axis]), sweep.slot(axis, high[axis]));
                sweep.begun[(axis * SLOTS + first) * words + i / 64] |= 1 << (i % 64);
                sweep.open[(axis * SLOTS + last) * words + i / 64] |= 1 << (i % 64);
            }
        }
        for axis in 0..3 {
            let row = |slot: usize| (axis * SLOTS + slot) * words;
            for slot in 1..SLOTS {
                for w in 0..words {
                    sweep.begun[row(slot) + w] |= sweep.begun[row(slot - 1) + w];
                    let down = SLOTS - 1 - slot;
                    sweep.open[row(down) + w] |= sweep.open[row(down + 1) + w];
                }
            }
        }
        sweep
    }

    /// Returns how many words a row has.
    pub fn words(&self) -> usize {
        self.words
    }

    /// The slot of a coordinate; the first or the last for what lies outside, the first for NaN.
    #[inline(always)]
    fn slot(&self, axis: usize, v: f64) -> usize {
        let at = ((v - self.lower[axis]) * self.scale[axis])
            .min(SLOTS as f64 - 1.0)
            .max(0.0);
        // Rounded to an integer, which then stands in the lowest bits: never decreasing, which is all that matters.
        (at + ROUND).to_bits() as usize % SLOTS
    }

    /// Finds the things that may meet the box about `p` with half sides `r` [m]; all of them where `p` is not finite.
    #[inline(always)]
    pub fn rows(&self, p: &[f64; 3], r: f64) -> Rows<'_> {
        let mut at = [(0, 0); 3];
        for axis in 0..3 {
            let (first, last) = (self.slot(axis, p[axis] - r), self.slot(axis, p[axis] + r));
            at[axis] = ((axis * SLOTS + last) * self.words, (axis * SLOTS + first) * self.words);
        }
        Rows {
            sweep: self,
            at,
            is_finite: (p[0] + p[1] + p[2]).is_finite(),
        }
    }
}

/// Adding it rounds to an integer.
const ROUND: f64 = 4_503_599_627_370_496.0;

/// The six rows of a box.
#[derive(Debug)]
pub struct Rows<'a> {
    sweep: &'a Sweep,
    at: [(usize, usize); 3],
    is_finite: bool,
}

impl Rows<'_> {
    /// Returns the bits of the things 64 `w` to 64 `w` + 63.
    #[inline(always)]
    pub fn word(&self, w: usize) -> u64 {
        if !self.is_finite {
            return !0;
        }
        let both = |(begun, open): (usize, usize)| self.sweep.begun[begun + w] & self.sweep.open[open + w];
        both(self.at[0]) & both(self.at[1]) & both(self.at[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nobody_who_meets_is_left_out() {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        for n in [0, 1, 63, 64, 65, 200] {
            let boxes: Vec<(Vec3, Vec3)> = (0..n)
                .map(|_| {
                    let low = Vec3::from_fn(|_, _| random() * 4.0 - 2.0);
                    (low, low + Vec3::from_fn(|_, _| random() * random()))
                })
                .collect();
            let sweep = Sweep::new(&boxes);
            let mut few = 0;
            for _ in 0..500 {
                let (p, r) = (Vec3::from_fn(|_, _| random() * 6.0 - 3.0), random() * 0.2);
                let rows = sweep.rows(&p.into(), r);
                let found: Vec<u64> = (0..sweep.words()).map(|w| rows.word(w)).collect();
                for (i, (low, high)) in boxes.iter().enumerate() {
                    let meets = (0..3).all(|a| p[a] - r <= high[a] && p[a] + r >= low[a]);
                    let said = found[i / 64] >> (i % 64) & 1 == 1;
                    assert!(said || !meets);
                    few += usize::from(said && !meets);
                }
            }
            // What lies beyond all boxes counts as at their border, which is the whole of a lone box.
            assert!(n < 63 || few <= 500 * n / 20, "{few} of {n} are told without need");
        }
    }
}
