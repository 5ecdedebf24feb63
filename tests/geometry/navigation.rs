//! Ways over the floor and what people mind about them.

use proptest::prelude::*;
use sgap::geom::navigation::comfort::{Human, Weights};
use sgap::geom::navigation::grid::Grid;
use sgap::geom::navigation::search::{Arrival, Goal, NoPath, Settings, search};
use sgap::geom::navigation::timing::{self, Limits};
use sgap::geom::navigation::{BasePose, Drive, Floor, Place, apart, direction, path, wrapped};

/// A box on the floor that goes among boxes; all of it is asked of points 2 cm apart.
struct Room {
    /// Half length, half width of what goes [m].
    half: [f64; 2],
    /// Middle and half sides of what stands [m].
    boxes: Vec<[f64; 4]>,
    humans: Vec<Human>,
    weights: Weights,
}

impl Room {
    fn new(boxes: &[[f64; 4]]) -> Room {
        Room {
            half: [0.3, 0.2],
            boxes: boxes.to_vec(),
            humans: Vec::new(),
            weights: Weights::default(),
        }
    }

    fn depth(&self, p: Place) -> f64 {
        let inside = |b: &[f64; 4]| (b[2] - (p[0] - b[0]).abs()).min(b[3] - (p[1] - b[1]).abs());
        self.boxes.iter().map(inside).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Says whether no point of the box, grown by `margin`, is in another one.
    fn is_clear(&self, pose: &BasePose, margin: f64) -> bool {
        let (sin, cos) = pose[2].sin_cos();
        let at = |i: i32, n: i32, half: f64| (half + margin) * f64::from(i) / f64::from(n);
        let (n, m) = (15, 10);
        (-n..=n).all(|i| {
            (-m..=m).all(|j| {
                let (a, b) = (at(i, n, self.half[0]), at(j, m, self.half[1]));
                self.depth([pose[0] + cos * a - sin * b, pose[1] + sin * a + cos * b]) <= 0.0
            })
        })
    }
}

impl Floor for Room {
    fn is_roomy(&mut self, place: Place, spare: f64) -> bool {
        let reach = self.radius() + spare + self.margin();
        self.boxes.iter().all(|b| {
            let out = [(place[0] - b[0]).abs() - b[2], (place[1] - b[1]).abs() - b[3]].map(|d| d.max(0.0));
            out[0].hypot(out[1]) > reach
        })
    }

    fn is_free(&mut self, pose: &BasePose) -> bool {
        self.is_clear(pose, self.margin())
    }

    fn margin(&self) -> f64 {
        0.01
    }

    fn cost(&mut self, place: Place) -> f64 {
        self.weights.at(&self.humans, place, &mut |_, _| false).total()
    }

    fn least_cost(&self) -> f64 {
        self.weights.length
    }

    fn radius(&self) -> f64 {
        self.half[0].hypot(self.half[1])
    }
}

/// A pose to end at.
struct To {
    place: Place,
    cell: [i32; 2],
    yaw: f64,
}

impl Goal for To {
    fn metres_left(&self, place: Place) -> f64 {
        apart(place, self.place)
    }

    fn accepts(&mut self, at: &Arrival) -> Option<f64> {
        let turn = at.heading.map_or(0.0, |h| wrapped(h - self.yaw).abs());
        (at.cell == self.cell && turn < 0.4).then_some(self.yaw)
    }

    fn is_over(&self) -> bool {
        false
    }
}

fn go(room: &mut Room, start: BasePose, end: BasePose, drive: Drive) -> Result<Vec<path::Way>, NoPath> {
    let grid = Grid::new(start, 0.05, &[[-1.0, -3.0], [5.0, 3.0], [-1.0, 3.0], [5.0, -3.0]]);
    let cell = grid.around([end[0], end[1]]);
    let mut goal = To {
        place: grid.place(cell),
        cell,
        yaw: end[2],
    };
    let settings = Settings {
        drive,
        max_nodes: 400_000,
        greed: 1.0,
    };
    search(&grid, room, &mut goal, settings).map(|found| path::shortened(room, &found.ways, drive, 200))
}

fn length(ways: &[path::Way]) -> f64 {
    ways.iter()
        .map(|w| apart([w.from[0], w.from[1]], [w.to[0], w.to[1]]))
        .sum()
}

/// Two walls across the room with a door of that width between them, at y = 1.
fn door(width: f64) -> Room {
    let end = |y: f64| if y > 0.0 { 3.5 } else { -3.5 };
    let wall = |from: f64, to: f64| [2.0, (from + to) / 2.0, 0.1, (to - from).abs() / 2.0];
    Room::new(&[wall(end(-1.0), 1.0 - width / 2.0), wall(1.0 + width / 2.0, end(1.0))])
}

#[test]
fn an_empty_floor_is_crossed_on_a_line() {
    for drive in [Drive::Holonomic, Drive::Differential] {
        let mut room = Room::new(&[]);
        let ways = go(&mut room, [0.0, 0.0, 0.4], [3.7, 1.3, -2.0], drive).expect("nothing is in the way");
        let last = ways.last().expect("it goes").to;
        let line = apart([0.0, 0.0], [last[0], last[1]]);
        assert!(
            length(&ways) <= line * 1.001,
            "{drive:?}: {} m for {line} m",
            length(&ways)
        );
        assert!(wrapped(last[2] + 2.0).abs() < 1e-9);
        let first = if drive == Drive::Holonomic { 1 } else { 3 };
        assert!(ways.len() <= first, "{drive:?}: {} ways", ways.len());
    }
}

#[test]
fn a_door_hardly_wider_than_the_box_is_passed_by_both_drives_and_a_narrower_one_by_none() {
    for drive in [Drive::Holonomic, Drive::Differential] {
        // Off the lattice's rows by up to 2.5 cm on each side, and the margin.
        let ways = go(&mut door(0.5), [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], drive).expect("0.5 m for a box of 0.4 m");
        let room = door(0.5);
        for way in &ways {
            for k in 0..=200 {
                let pose = path::between(&way.from, &way.to, f64::from(k) / 200.0);
                assert!(room.is_clear(&pose, 0.0), "{drive:?}: {pose:?} of {way:?}");
            }
            let [dx, dy] = [way.to[0] - way.from[0], way.to[1] - way.from[1]];
            if drive == Drive::Differential && dx.hypot(dy) > 1e-9 {
                assert!(
                    (way.to[2] - way.from[2]).abs() < 1e-9,
                    "it turns while it goes: {way:?}"
                );
                let sideways = way.to[2].cos() * dy - way.to[2].sin() * dx;
                assert!(sideways.abs() < 1e-9, "sideways: {way:?}");
            }
        }
        let through = ways.iter().any(|w| (w.from[0] - 2.0) * (w.to[0] - 2.0) <= 0.0);
        assert!(through);
        let no = go(&mut door(0.38), [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], drive).expect_err("0.38 m for a box of 0.4 m");
        assert!(matches!(no, NoPath::Exhausted { .. }), "{no:?}");
    }
}

#[test]
fn a_base_leaves_a_place_where_it_can_not_turn() {
    // A slot 0.5 m wide, open at its back: the box of 0.6 m can't turn in it.
    let boxes = [[0.1, 0.3, 0.5, 0.05], [0.1, -0.3, 0.5, 0.05], [0.6, 0.0, 0.05, 0.35]];
    for drive in [Drive::Holonomic, Drive::Differential] {
        let mut room = Room::new(&boxes);
        let ways = go(&mut room, [0.15, 0.0, 0.0], [3.0, 0.0, 1.0], drive).expect("backward, then around");
        assert!(ways[0].to[0] < ways[0].from[0], "{drive:?}: backward first");
    }
}

#[test]
fn times_keep_the_limits_whatever_the_direction() {
    let limits = Limits {
        speed: 0.7,
        turn_rate: 0.9,
        acceleration: 0.6,
        turn_acceleration: 1.1,
    };
    for drive in [Drive::Holonomic, Drive::Differential] {
        let mut room = Room::new(&[[1.5, 0.3, 0.3, 0.9]]);
        let ways = go(&mut room, [0.0, 0.0, 0.7], [3.5, 0.4, 3.0], drive).expect("around a box");
        let timed = timing::time(&mut room, &ways, drive, &limits);
        let (n, mut before, mut gap) = (timed.times.len(), [0.0; 3], 0.0);
        for k in 1..=n {
            let (v, dt): ([f64; 3], f64) = if k < n {
                let dt = timed.times[k] - timed.times[k - 1];
                assert!(dt > 0.0);
                let rows = (&timed.positions[k - 1], &timed.positions[k]);
                (std::array::from_fn(|i| (rows.1[i] - rows.0[i]) / dt), dt)
            } else {
                ([0.0; 3], 0.0)
            };
            let a: [f64; 3] = std::array::from_fn(|i| (v[i] - before[i]) / (0.5 * (gap + dt)));
            assert!(v[0].hypot(v[1]) <= limits.speed * (1.0 + 1e-6));
            assert!(v[2].abs() <= limits.turn_rate * (1.0 + 1e-6));
            assert!(
                a[0].hypot(a[1]) <= limits.acceleration * (1.0 + 1e-6),
                "{drive:?} at {k}"
            );
            assert!(
                a[2].abs() <= limits.turn_acceleration * (1.0 + 1e-6),
                "{drive:?} at {k}"
            );
            (before, gap) = (v, dt);
        }
        let end = timed.positions.last().expect("it goes");
        let last = ways.last().expect("it goes").to;
        assert!((0..3).all(|i| (end[i] - last[i]).abs() < 1e-9));
    }
}

// ---- What people mind ----

fn human(place: Place, gaze: f64) -> Human {
    Human {
        place,
        gaze,
        is_sitting: false,
    }
}

/// The cost of a polyline, its length sampled every 2 cm.
fn cost(weights: &Weights, humans: &[Human], line: &[Place]) -> f64 {
    samples(line)
        .iter()
        .map(|(p, metres)| weights.at(humans, *p, &mut |_, _| false).total() * metres)
        .sum()
}

fn samples(line: &[Place]) -> Vec<(Place, f64)> {
    let mut all = Vec::new();
    for pair in line.windows(2) {
        let metres = apart(pair[0], pair[1]);
        let n = (metres / 0.02).ceil().max(1.0) as usize;
        for k in 0..n {
            let t = (k as f64 + 0.5) / n as f64;
            let at = [0, 1].map(|i| pair[0][i] + t * (pair[1][i] - pair[0][i]));
            all.push((at, metres / n as f64));
        }
    }
    all
}

/// Thesis Fig. 3.3: the same way to a table, 3.7 m long; the human far away, beside the way and facing it, beside it and turned away.
#[test]
fn three_placements_cost_as_in_the_thesis() {
    let weights = Weights::default();
    let line = [[0.0, 0.0], [3.7, 0.0]];
    let toward = -std::f64::consts::FRAC_PI_2;
    let costs = [
        cost(&weights, &[human([1.85, 4.5], toward)], &line),
        cost(&weights, &[human([1.85, 1.2], toward)], &line),
        cost(&weights, &[human([1.85, 1.2], -toward)], &line),
    ];
    for (cost, thesis) in costs.iter().zip([3.7, 6.4, 8.9]) {
        assert!((cost / thesis - 1.0).abs() < 0.12, "{costs:.2?} against 3.7, 6.4, 8.9");
    }
    assert!(costs[0] < costs[1] && costs[1] < costs[2]);
}

proptest! {
    /// Nearer at every place, no further into his sight at any: never cheaper.
    #[test]
    fn a_human_who_comes_nearer_or_turns_away_never_makes_a_way_cheaper(
        line in proptest::collection::vec([-3.0..3.0_f64, -3.0..3.0], 2..5),
        at in [-3.0..3.0_f64, -3.0..3.0],
        gaze in -3.1..3.1_f64,
        towards in 0.0..0.9_f64,
        turn in 0.0..3.0_f64,
        is_sitting in any::<bool>(),
    ) {
        let weights = Weights::default();
        let before = Human { is_sitting, ..human(at, gaze) };
        let all = samples(&line);
        let off = |h: &Human, p: Place| wrapped(direction(h.place, p) - h.gaze).abs();
        // Turned where he stands, to either side, as far as no place comes nearer to where he looks.
        for turn in [turn, -turn] {
            let after = Human { gaze: wrapped(gaze + turn), ..before };
            if all.iter().all(|(p, _)| off(&after, *p) >= off(&before, *p)) {
                prop_assert!(cost(&weights, &[after], &line) >= cost(&weights, &[before], &line) - 1e-9);
            }
        }
        // Nearer to the middle of a way that lies in his sight all along: his sight of it does not get better.
        let middle = [0, 1].map(|i| all.iter().map(|(p, _)| p[i]).sum::<f64>() / all.len() as f64);
        let nearer = [0, 1].map(|i| at[i] + towards * (middle[i] - at[i]));
        let after = Human { place: nearer, ..before };
        let is_nearer = all.iter().all(|(p, _)| apart(after.place, *p) <= apart(before.place, *p));
        let blind = Weights { visibility: 0.0, ..weights };
        if is_nearer {
            prop_assert!(cost(&blind, &[after], &line) >= cost(&blind, &[before], &line) - 1e-9);
        }
        if is_nearer && all.iter().all(|(p, _)| off(&after, *p) >= off(&before, *p)) {
            prop_assert!(cost(&weights, &[after], &line) >= cost(&weights, &[before], &line) - 1e-9);
        }
        // One place alone: straight towards it, his sight of it stays as it is.
        let place = line[0];
        let closer = Human { place: [0, 1].map(|i| at[i] + towards * (place[i] - at[i])), ..before };
        let minds = |h: Human| weights.at(&[h], place, &mut |_, _| false).total();
        prop_assert!(minds(closer) >= minds(before) - 1e-9);
    }
}
