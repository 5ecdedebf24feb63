//! Paths of a base: from the stops of a search to ways that a drive can go, shorter ones, and the check of them all.

use super::{BasePose, Drive, Floor, Place, apart, direction, wrapped};

/// A place of a search, with the heading that it must have, or every one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    pub place: Place,
    pub heading: Option<f64>,
}

/// A straight way of the base: x, y and the heading change evenly. Headings go on beyond half a turn: what changes is what is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    pub from: BasePose,
    pub to: BasePose,
    /// Whether every heading is free all along.
    pub is_roomy: bool,
    /// The stop that it leaves, or turns at.
    pub stop: usize,
}

/// Shorter than this is no way [m], [rad].
const NOTHING: f64 = 1e-9;

/// Returns the pose at a share `t` of the way.
pub fn between(a: &BasePose, b: &BasePose, t: f64) -> BasePose {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// Returns the pose with another heading, turned to by the shorter turn.
pub fn turned(a: &BasePose, heading: f64) -> BasePose {
    [a[0], a[1], a[2] + wrapped(heading - a[2])]
}

/// Returns the ways from stop to stop: beginning with the heading `start`, ending with `end`.
///
/// A differential base turns towards each stop and goes there; a holonomic one turns while it goes, where there is room.
/// INVARIANT: two neighbouring stops with headings have the same one, or the same place.
pub fn ways(stops: &[Stop], start: f64, end: f64, drive: Drive) -> Vec<Way> {
    let mut ways = Vec::new();
    let Some(first) = stops.first() else { return ways };
    let mut at: BasePose = [first.place[0], first.place[1], start];
    let mut push = |at: &mut BasePose, to: BasePose, is_roomy: bool, stop: usize| {
        if (0..3).any(|i| (to[i] - at[i]).abs() > NOTHING) {
            ways.push(Way {
                from: *at,
                to,
                is_roomy,
                stop,
            });
            *at = to;
        }
    };
    for (i, pair) in stops.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        let is_roomy = a.heading.is_none() && b.heading.is_none();
        if apart(a.place, b.place) <= NOTHING {
            let to = turned(&at, b.heading.unwrap_or(at[2]));
            push(&mut at, to, is_roomy, i);
            continue;
        }
        let travel = match (a.heading, b.heading) {
            (_, Some(h)) | (Some(h), None) => h,
            (None, None) => direction(a.place, b.place),
        };
        if is_roomy && drive == Drive::Holonomic {
            // Where it has to look next: into a tight place, along the next line, or to the end.
            let next = match stops.get(i + 2) {
                Some(c) => c.heading.unwrap_or_else(|| direction(b.place, c.place)),
                None => end,
            };
            let to = turned(&at, next);
            push(&mut at, [b.place[0], b.place[1], to[2]], true, i);
            continue;
        }
        let to = turned(&at, travel);
        push(&mut at, to, a.heading.is_none(), i);
        let to = [b.place[0], b.place[1], at[2]];
        push(&mut at, to, is_roomy, i);
    }
    let last = stops.len() - 1;
    let to = turned(&at, end);
    push(&mut at, to, stops[last].heading.is_none(), last);
    ways
}

/// A way is looked at in so many places at most, whatever its length.
const MAX_CHECKS: f64 = 100_000.0;

/// Says whether a way is free after its beginning.
///
/// No point of the agent moves farther than twice the floor's margin from one pose looked at to the next, so between them nothing that is not
/// free at the margin gets as far as the shape itself. Halves first, so that a hit shows early.
pub fn is_free(floor: &mut dyn Floor, a: &BasePose, b: &BasePose) -> bool {
    let swept = apart([a[0], a[1]], [b[0], b[1]]) + (b[2] - a[2]).abs() * floor.radius();
    let n = (swept / (2.0 * floor.margin())).ceil().clamp(1.0, MAX_CHECKS);
    if !swept.is_finite() || !floor.is_free(b) {
        return false;
    }
    let n = n as usize;
    let mut stride = n.next_power_of_two() / 2;
    while stride > 0 {
        for i in (stride..n).step_by(2 * stride) {
            if !floor.is_free(&between(a, b, i as f64 / n as f64)) {
                return false;
            }
        }
        stride /= 2;
    }
    true
}

/// Spacing of the samples of a cost along a way [m].
const SAMPLES: f64 = 0.05;
/// What a turn costs, in metres for a radian.
const TURN: f64 = 0.06;

/// Returns the cost along a way by the floor's cost of a metre; turning costs a little, too.
pub fn cost(floor: &mut dyn Floor, a: &BasePose, b: &BasePose) -> f64 {
    let metres = apart([a[0], a[1]], [b[0], b[1]]);
    let n = (metres / SAMPLES).ceil().clamp(1.0, MAX_CHECKS) as usize;
    let mut sum = 0.0;
    for k in 0..n {
        let [x, y, _] = between(a, b, (k as f64 + 0.5) / n as f64);
        sum += floor.cost([x, y]);
    }
    sum / n as f64 * metres + TURN * floor.least_cost() * (b[2] - a[2]).abs()
}

/// A joint may be dearer than what it replaces by this share: costs are sampled.
const SAME: f64 = 2e-3;

/// Returns a path of fewer ways that is hardly dearer: stretches of it are replaced by direct ways where these are free, long
/// stretches first, then their halves.
///
/// `tries` is how many direct ways are tried at most.
pub fn shortened(floor: &mut dyn Floor, ways: &[Way], drive: Drive, mut tries: usize) -> Vec<Way> {
    let mut costs: Vec<f64> = ways.iter().map(|w| cost(floor, &w.from, &w.to)).collect();
    let mut ways: Vec<Way> = ways.to_vec();
    // Halves that meet in the middle are joined in the second round.
    for _ in 0..2 {
        let mut kept: Vec<Way> = Vec::new();
        let mut kept_costs: Vec<f64> = Vec::new();
        let whole = 0..ways.len();
        let mut stretches = vec![whole];
        while let Some(stretch) = stretches.pop() {
            let (Some(first), Some(last)) = (ways.get(stretch.start), ways.get(stretch.end.wrapping_sub(1))) else {
                continue;
            };
            if stretch.len() > 1 && tries > 0 {
                tries -= 1;
                let joint = joint(&first.from, &last.to, drive);
                let parts: Vec<f64> = joint.windows(2).map(|p| cost(floor, &p[0], &p[1])).collect();
                let before: f64 = costs[stretch.clone()].iter().sum();
                let is_better = parts.iter().sum::<f64>() <= before * (1.0 + SAME) && parts.len() < stretch.len();
                if is_better && joint.windows(2).all(|p| is_free(floor, &p[0], &p[1])) {
                    kept.extend(joint.windows(2).map(|p| Way {
                        from: p[0],
                        to: p[1],
                        ..*first
                    }));
                    kept_costs.extend(parts);
                    continue;
                }
            }
            if stretch.len() > 1 && tries > 0 {
                let middle = stretch.start + stretch.len() / 2;
                stretches.push(middle..stretch.end);
                stretches.push(stretch.start..middle);
            } else {
                kept.extend(ways[stretch.clone()].iter().copied());
                kept_costs.extend(costs[stretch].iter().copied());
            }
        }
        (ways, costs) = (kept, kept_costs);
    }
    // The heading goes on from where the way before ended.
    let mut at = ways.first().map_or([0.0; 3], |w| w.from);
    for way in &mut ways {
        let to = [way.to[0], way.to[1], at[2] + (way.to[2] - way.from[2])];
        (way.from, way.to) = (at, to);
        at = to;
    }
    ways
}

/// Returns the direct way from one pose to another as corners: a differential base turns, goes and turns again.
fn joint(a: &BasePose, b: &BasePose, drive: Drive) -> Vec<BasePose> {
    let (from, to) = ([a[0], a[1]], [b[0], b[1]]);
    if drive == Drive::Holonomic || apart(from, to) <= NOTHING {
        return vec![*a, turned(&[b[0], b[1], a[2]], b[2])];
    }
    let forward = direction(from, to);
    // Backward where that is less to turn.
    let back = wrapped(forward + std::f64::consts::PI);
    let turns = |travel: f64| wrapped(travel - a[2]).abs() + wrapped(b[2] - travel).abs();
    let travel = if turns(back) < turns(forward) { back } else { forward };
    let turned_first = turned(a, travel);
    let gone = [b[0], b[1], turned_first[2]];
    let mut corners = vec![*a, turned_first, gone, turned(&gone, b[2])];
    corners.dedup_by(|x, y| (0..3).all(|i| (x[i] - y[i]).abs() <= NOTHING));
    corners
}
