//! The search alone, without geometry. `cargo bench --bench engine`.
//!
//! Each domain is made here, so that its size can be chosen. The first rows are made to be compared with one another: what a
//! step costs must not depend on the length of the plan.

use std::sync::atomic::AtomicBool;

use divan::Bencher;
use divan::counter::ItemsCount;
use sgap::check::{self, Given};
use sgap::engine::{self, Aim, Branching, Budget, Cuts, Granted, Outcome, Settings};
use sgap::ir::{Domain, Goal};
use sgap::source::Sources;
use sgap::syntax;

fn main() {
    divan::main();
}

const SETTINGS: Settings = Settings {
    aim: Aim::First,
    branching: Branching::Fixed(1),
    strategy: engine::Strategy::DepthFirst,
    interleave: false,
    cuts: Cuts::On,
    fall_back: None,
    budget: Budget {
        expansions: 1_000_000_000,
        depth: 10_000_000,
    },
};

/// A domain with the task to plan.
struct Problem {
    domain: Domain,
    goal: Goal,
}

impl Problem {
    fn new(text: &str, task: &str) -> Problem {
        let mut sources = Sources::default();
        let file = sources.add("bench.hatp", text);
        let (ast, problems) = syntax::parse(file, text);
        assert!(!problems.has_errors(), "{problems:?}");
        let (domain, problems) = check::compile(&[ast], &Given::default());
        let mut domain = domain.unwrap_or_else(|| panic!("{problems:?}"));
        let (goal, problems) = check::parse_goal(task, file, 0, &mut domain);
        let goal = goal.unwrap_or_else(|| panic!("{problems:?}"));
        Problem { domain, goal }
    }

    fn solve(&self, settings: &Settings) -> Outcome {
        let stop = AtomicBool::new(false);
        engine::solve(
            &self.domain,
            &self.goal,
            &mut Granted::default(),
            settings,
            &stop,
            &mut |_, _| {},
        )
    }

    /// Times a search that must find a plan; counts tasks taken up.
    fn bench(&self, bencher: Bencher<'_, '_>, settings: &Settings) {
        let outcome = self.solve(settings);
        assert!(outcome.found.is_some(), "{:?}", outcome.ending);
        bencher
            .counter(ItemsCount::new(outcome.statistics.expansions))
            .bench(|| self.solve(settings));
    }
}

/// A robot that goes round a ring of eight rooms, one SELECT for each step.
fn ring(steps: usize) -> Problem {
    let rooms: String = (0..8)
        .map(|i| format!("R{i} = new Room; R{i}.next = R{}; ", (i + 1) % 8))
        .collect();
    let text = format!(
        "factdatabase {{
           define entityType Room;
           define entityAttributes Agent {{ dynamic atom Room in; dynamic atom number steps; }}
           define entityAttributes Room {{ static atom Room next; }}
           A = new Agent; A.steps = 0; {rooms} A.in = R0;
         }}
         HTN {{
           action Go(Agent A, Room R) {{ preconditions {{ A.in.next == R; }}; effects {{ A.in = R; A.steps = A.steps + 1; }}; }}
           method Round(Agent A, number N) {{
             goal {{ A.steps >= N; }}
             {{ subtasks {{ R = SELECT(Room, {{A.in.next == R;}}); 1: Go(A, R); 2: Round(A, N) > 1; }}; }}
           }}
         }}"
    );
    Problem::new(&text, &format!("Round(A, {steps})"))
}

/// As `ring`, where the SELECT has to look at all rooms.
fn scan(steps: usize) -> Problem {
    let rooms: String = (0..8)
        .map(|i| format!("R{i} = new Room; R{i}.before = R{}; ", (i + 7) % 8))
        .collect();
    let text = format!(
        "factdatabase {{
           define entityType Room;
           define entityAttributes Agent {{ dynamic atom Room in; dynamic atom number steps; }}
           define entityAttributes Room {{ static atom Room before; }}
           A = new Agent; A.steps = 0; {rooms} A.in = R0;
         }}
         HTN {{
           action Go(Agent A, Room R) {{ preconditions {{ R.before == A.in; }}; effects {{ A.in = R; A.steps = A.steps + 1; }}; }}
           method Round(Agent A, number N) {{
             goal {{ A.steps >= N; }}
             {{ subtasks {{ R = SELECT(Room, {{R.before == A.in;}}); 1: Go(A, R); 2: Round(A, N) > 1; }}; }}
           }}
         }}"
    );
    Problem::new(&text, &format!("Round(A, {steps})"))
}

/// As `ring`, with two ways on from each room: every SELECT leaves a choice open.
fn fork(steps: usize) -> Problem {
    let rooms: String = (0..8).map(|i| format!("R{i} = new Room; ")).collect();
    let ways: String = (0..8)
        .map(|i| format!("R{i}.next <<= R{}; R{i}.next <<= R{}; ", (i + 1) % 8, (i + 2) % 8))
        .collect();
    let text = format!(
        "factdatabase {{
           define entityType Room;
           define entityAttributes Agent {{ dynamic atom Room in; dynamic atom number steps; }}
           define entityAttributes Room {{ static set Room next; }}
           A = new Agent; A.steps = 0; {rooms} {ways} A.in = R0;
         }}
         HTN {{
           action Go(Agent A, Room R) {{ preconditions {{ R >> A.in.next; }}; effects {{ A.in = R; A.steps = A.steps + 1; }}; }}
           method Round(Agent A, number N) {{
             goal {{ A.steps >= N; }}
             {{ subtasks {{ R = SELECT(Room, {{R >> A.in.next;}}); 1: Go(A, R); 2: Round(A, N) > 1; }}; }}
           }}
         }}"
    );
    Problem::new(&text, &format!("Round(A, {steps})"))
}

/// The tower of Hanoi.
fn hanoi(discs: usize) -> Problem {
    // Pegs hold their top disc; a disc knows what it lies on.
    let text = format!(
        "factdatabase {{
           define entityType Peg;
           define entityType Disc;
           define entityAttributes Peg {{ dynamic atom Disc top; }}
           define entityAttributes Disc {{ dynamic atom Disc on; static atom Disc smaller; }}
           A = new Agent; PA = new Peg; PB = new Peg; PC = new Peg; {} PA.top = D0;
         }}
         HTN {{
           action Move(Agent A, Disc D, Peg F, Peg T) {{
             preconditions {{ F.top == D; }};
             effects {{ F.top = D.on; D.on = T.top; T.top = D; }};
           }}
           method Tower(Agent A, Disc D, Peg F, Peg T, Peg V) {{
             {{ preconditions {{ D.smaller == NULL; }}; subtasks {{ 1: Move(A, D, F, T); }}; }}
             {{ preconditions {{ D.smaller != NULL; }}; subtasks {{
                  1: Tower(A, D.smaller, F, V, T); 2: Move(A, D, F, T) > 1; 3: Tower(A, D.smaller, V, T, F) > 2; }}; }}
           }}
         }}",
        (0..discs)
            .map(|i| {
                let on = if i + 1 < discs {
                    format!("D{i}.on = D{}; ", i + 1)
                } else {
                    String::new()
                };
                let smaller = if i > 0 {
                    format!("D{i}.smaller = D{}; ", i - 1)
                } else {
                    String::new()
                };
                format!("D{i} = new Disc; {on}{smaller}")
            })
            .rev()
            .collect::<String>()
    );
    Problem::new(&text, &format!("Tower(A, D{}, PA, PC, PB)", discs - 1))
}

/// Blocks in towers of ten that have to stand in other towers of ten: clear a block and what it goes on, put it there.
fn blocks(n: usize) -> Problem {
    let names: String = (0..n).map(|i| format!("B{i} = new Block; ")).collect();
    let start: String = (0..n)
        .filter(|i| i % 10 != 9)
        .map(|i| format!("B{i}.on = B{}; B{}.under = B{i}; ", i + 1, i + 1))
        .collect();
    // The goal: towers over every tenth block, in the other direction.
    let place = |i: usize| (i * 7 + 3) % n;
    let goal: String = (0..n)
        .filter(|i| i % 10 != 0)
        .map(|i| format!("B{}.goal = B{}; ", place(i), place(i - 1)))
        .collect();
    let text = format!(
        "factdatabase {{
           define entityType Block;
           define entityAttributes Block {{ dynamic atom Block on; dynamic atom Block under; static atom Block goal; dynamic atom bool done; }}
           A = new Agent; {names} {start} {goal}
         }}
         HTN {{
           action Put(Agent A, Block B, Block C) {{ preconditions {{ B.under == NULL; C.under == NULL; }};
             effects {{ B.on.under = NULL; B.on = C; C.under = B; }}; }}
           action Down(Agent A, Block B) {{ preconditions {{ B.under == NULL; B.on != NULL; }}; effects {{ B.on.under = NULL; B.on = NULL; }}; }}
           action Finish(Agent A, Block B) {{ effects {{ B.done = true; }}; }}
           method Clear(Agent A, Block B) {{ goal {{ B.under == NULL; }}
             {{ subtasks {{ let C = B.under; 1: Clear(A, C); 2: Down(A, C) > 1; }}; }} }}
           method Free(Agent A, Block B) {{ goal {{ B.on == NULL; }}
             {{ subtasks {{ 1: Clear(A, B); 2: Down(A, B) > 1; }}; }} }}
           method Place(Agent A, Block B) {{ goal {{ B.done == true; }}
             {{ preconditions {{ B.goal == NULL; }}; subtasks {{ 1: Free(A, B); 2: Finish(A, B) > 1; }}; }}
             {{ preconditions {{ B.goal != NULL; }}; subtasks {{ 1: Place(A, B.goal); 2: Clear(A, B) > 1; 3: Clear(A, B.goal) > 2; 4: Put(A, B, B.goal) > 3; 5: Finish(A, B) > 4; }}; }} }}
           method All(Agent A) {{ goal {{ FORALL(Block B, {{}}, {{B.done == true;}}); }}
             {{ subtasks {{ B = SELECTONCE(Block, {{B.done != true;}}); 1: Place(A, B); 2: All(A) > 1; }}; }} }}
         }}"
    );
    Problem::new(&text, "All(A)")
}

/// A row of tasks, each a choice among four things, and a last one that can't be done and has to be tried to know it.
fn row(n: usize) -> Problem {
    let slots: String = (0..n).map(|i| format!("dynamic atom Object a{i}; ")).collect();
    let tasks: String = (0..n)
        .map(|i| {
            format!(
                "action Take{i}(Agent A, Object O) {{ effects {{ A.a{i} = O; }}; }}
                 method Do{i}(Agent A) {{ {{ subtasks {{ O = SELECT(Object, {{}}); 1: Take{i}(A, O); }}; }} }} "
            )
        })
        .collect();
    let calls: String = (0..n)
        .map(|i| match i {
            0 => "0: Do0(A); ".to_owned(),
            i => format!("{i}: Do{i}(A) > {}; ", i - 1),
        })
        .collect();
    let text = format!(
        "factdatabase {{
           define entityType Object;
           define entityAttributes Agent {{ {slots} dynamic atom Object last; }}
           A = new Agent; C0 = new Object; C1 = new Object; C2 = new Object; C3 = new Object;
         }}
         HTN {{
           {tasks}
           action Last(Agent A, Object O) {{ effects {{ A.last = O; }}; }}
           method Never(Agent A) {{ {{ subtasks {{ O = SELECT(Object, {{O == A.last;}}); 1: Last(A, O); }}; }} }}
           method Go(Agent A) {{ {{ subtasks {{ {calls} {n}: Never(A) > {}; }}; }} }}
         }}",
        n - 1
    );
    Problem::new(&text, "Go(A)")
}

#[divan::bench(args = [1_000, 10_000, 100_000, 1_000_000])]
fn one_select_for_each_step(bencher: Bencher<'_, '_>, steps: usize) {
    ring(steps).bench(bencher, &SETTINGS);
}

#[divan::bench(args = [1_000, 100_000])]
fn one_select_that_scans(bencher: Bencher<'_, '_>, steps: usize) {
    scan(steps).bench(bencher, &SETTINGS);
}

/// As many open choice points as moves.
#[divan::bench(args = [1_000, 1_000_000])]
fn one_open_choice_for_each_step(bencher: Bencher<'_, '_>, steps: usize) {
    fork(steps).bench(bencher, &SETTINGS);
}

#[divan::bench(args = [10, 17, 20])]
fn hanoi_discs(bencher: Bencher<'_, '_>, discs: usize) {
    hanoi(discs).bench(bencher, &SETTINGS);
}

#[divan::bench(args = [100, 1_000])]
fn blocks_in_towers(bencher: Bencher<'_, '_>, n: usize) {
    blocks(n).bench(bencher, &SETTINGS);
}

/// No plan, after a row of choices that have no part in the failure.
#[divan::bench(args = [4, 8, 16, 32])]
fn choices_without_a_part_in_the_failure(bencher: Bencher<'_, '_>, n: usize) {
    let problem = row(n);
    let outcome = problem.solve(&SETTINGS);
    assert_eq!(outcome.ending, engine::Ending::Exhausted);
    bencher
        .counter(ItemsCount::new(outcome.statistics.expansions))
        .bench(|| problem.solve(&SETTINGS));
}

/// The plan document, with its links and its schedule.
#[divan::bench(args = [1_000, 100_000, 1_000_000])]
fn document(bencher: Bencher<'_, '_>, steps: usize) {
    let problem = ring(steps);
    let found = problem.solve(&SETTINGS).found.expect("there is a plan");
    bencher
        .counter(ItemsCount::new(steps))
        .bench(|| engine::document(&found, &problem.domain, &problem.goal, 0, &|_| None));
}
