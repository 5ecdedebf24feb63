//! The door of the crate, and the trace of a search: what a program that links sgap sees.
#![expect(clippy::unwrap_used, reason = "a test says by a panic what is wrong")]

use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sgap::engine::Ending;
use sgap::report::trace as report;
use sgap::trace::{FORMAT, Header, Summary, VERSION, Writer, read};
use sgap::{Answer, Options, Paths, Texts, plan};

const DOMAIN: &str = "
factdatabase {
  define entityType Lamp;
  define entityAttributes Lamp { dynamic atom bool on; static atom number price; }
  define entityAttributes Agent { dynamic atom number coins; }
  ANN = new Agent; ANN.coins = 4;
  DESK = new Lamp; HALL = new Lamp; DESK.price = 3; HALL.price = 2;
}
HTN {
  action Switch(Agent A, Lamp L) {
    preconditions { L.on != true; L.price <= A.coins; };
    effects { L.on = true; A.coins = A.coins - L.price; }
    cost { L.price }
  }
  action Wait(Agent A, number N) { effects { A.coins = A.coins - N; } }
  method One(Agent A) { { subtasks { L = SELECT(Lamp, {L.on != true;}); 1: Switch(A, L); }; } }
  method Two(Agent A) { { subtasks { 1: One(A); 2: One(A) > 1; }; } }
  method Count(Agent A, number N) { { subtasks { 1: Wait(A, N); 2: Count(A, N + 1) > 1; }; } }
}";

fn lamps(task: &str, options: Options<'_>) -> Answer {
    let files = Texts::new([("lamps.hatp", DOMAIN)]);
    let paths = Paths {
        domain: "lamps.hatp",
        task: Some(task),
        ..Paths::default()
    };
    plan(&paths, &files, options).unwrap_or_else(|rejected| panic!("{rejected}"))
}

#[test]
fn plans_come_as_documents() {
    let answer = lamps("One(ANN)", Options::default());
    assert_eq!(answer.plan().unwrap().actions[0].arguments, ["ANN", "DESK"]);
    let mut costs = Vec::new();
    let mut hear = |news: &sgap::News<'_>| costs.push((news.found.cost, news.actions()));
    let answer = lamps("One(ANN)", Options::default().best().on_plan(&mut hear));
    assert_eq!((answer.ending, answer.plan().unwrap().cost), (Ending::Exhausted, 2.0));
    let wanted = [(3.0, "Switch(ANN, DESK)"), (2.0, "Switch(ANN, HALL)")];
    assert_eq!(costs, wanted.map(|(cost, action)| (cost, vec![action.to_owned()])));
    assert_eq!(lamps("One(ANN)", Options::default().all(5)).plans.len(), 2);
}

#[test]
fn what_is_wrong_with_the_texts_comes_at_once() {
    let files = Texts::new([("a.hatp", DOMAIN.replace("on != true", "off != true"))]);
    let paths = Paths {
        domain: "a.hatp",
        task: Some("One(ANN)"),
        ..Paths::default()
    };
    let rejected = plan(&paths, &files, Options::default()).unwrap_err();
    assert_eq!(rejected.problems.0.len(), 2, "{rejected}");
    assert!(rejected.to_string().contains("hatp::unknown-attribute"), "{rejected}");
    let files = Texts::new([("a.hatp", DOMAIN)]);
    let paths = Paths {
        domain: "a.hatp",
        ..Paths::default()
    };
    let rejected = plan(&paths, &files, Options::default()).unwrap_err();
    assert_eq!(rejected.problems.0.last().unwrap().code, "world::no-task");
}

/// A listener can end the search with what it has.
#[test]
fn the_stop_flag_ends_the_search() {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let mut hear = |_: &sgap::News<'_>| flag.store(true, Ordering::Relaxed);
    let answer = lamps("One(ANN)", Options::default().best().stop(stop).on_plan(&mut hear));
    assert_eq!((answer.ending, answer.plan().unwrap().cost), (Ending::Interrupted, 3.0));
}

/// Plans with a trace; returns its bytes.
fn traced(task: &str, set: impl for<'a> FnOnce(Options<'a>) -> Options<'a>) -> (Answer, Vec<u8>) {
    let header = Header {
        format: FORMAT.into(),
        version: VERSION,
        domain: "lamps.hatp".into(),
        world: None,
        task: task.into(),
        seed: 0,
    };
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, &header, None);
    let answer = lamps(task, set(Options::default()).observer(&mut writer));
    writer.finish().unwrap();
    (answer, bytes)
}

fn summary(bytes: &[u8]) -> Summary {
    read(bytes, None).unwrap_or_else(|fault| panic!("{fault}"))
}

/// What is counted from the file is what the search has counted itself.
#[test]
fn a_trace_has_all_that_the_search_did() {
    let tasks = ["One(ANN)", "Two(ANN)", "Count(ANN, 1)"];
    for (task, is_best) in tasks.iter().flat_map(|t| [(t, false), (t, true)]) {
        let (answer, bytes) = traced(task, |o| {
            if is_best {
                o.max_depth(50).best()
            } else {
                o.max_depth(50)
            }
        });
        let (counts, summary) = (answer.statistics, summary(&bytes));
        let sum = |of: fn(&sgap::trace::TaskCounts) -> u64| summary.groups.iter().map(|g| of(&g.counts)).sum::<u64>();
        assert_eq!(sum(|c| c.tried), counts.expansions, "{task}");
        assert_eq!(sum(|c| c.backtracks), counts.backtracks, "{task}");
        assert_eq!(summary.end.as_ref().unwrap().plans, counts.plans, "{task}");
        let ended: u64 = summary.failures.iter().map(|f| f.count).sum();
        let reasons: u64 = answer.why_not.reasons().iter().map(|(_, r)| r.n_branches).sum();
        assert_eq!(ended, reasons, "{task}");
        if answer.plan().is_none() {
            assert_eq!(summary.deepest, answer.why_not.deepest, "{task}");
        }
    }
}

#[test]
fn a_trace_is_the_same_bytes_every_time_and_changes_nothing() {
    let (answer, bytes) = traced("Two(ANN)", |o| o);
    assert_eq!(bytes, traced("Two(ANN)", |o| o).1);
    let without = lamps("Two(ANN)", Options::default());
    assert_eq!(
        (answer.statistics, answer.why_not),
        (without.statistics, without.why_not)
    );
}

#[test]
fn a_recursion_is_one_line_and_every_line_fits() {
    let (_, bytes) = traced("Count(ANN, 1)", |o| o.max_depth(3000));
    let summary = summary(&bytes);
    assert_eq!(summary.groups.len(), 2);
    let text = report::summary(&summary, 12);
    assert!(text.contains("Count(ANN, *) (again below itself)"), "{text}");
    assert!(text.lines().all(|l| l.chars().count() <= 100), "{text}");
}

#[test]
fn only_the_wanted_tasks_are_counted() {
    let (_, bytes) = traced("Two(ANN)", |o| o);
    let of = |task| read(bytes.as_slice(), Some(task)).unwrap();
    assert_eq!(of("One").groups[0].counts.tried, 3);
    assert_eq!(of("Switch(ANN,HALL)").groups[0].counts.tried, 2);
    assert_eq!(of("One(BOB)").groups.len(), 0);
}

#[test]
fn a_trace_that_was_cut_short_is_read_up_to_there() {
    let (_, bytes) = traced("Two(ANN)", |o| o);
    let whole = summary(&bytes);
    assert!(!whole.is_cut && whole.end.is_some());
    let cut = summary(&bytes[..bytes.len() - 5]);
    assert!(cut.is_cut && cut.end.is_none());
    assert_eq!(cut.lines, whole.lines - 1);
    let text = report::summary(&cut, 12);
    assert!(text.contains("the file ends before the search did"), "{text}");
    assert!(text.contains("its last line is cut short"), "{text}");
    // Wherever it is cut: behind the first line it is a trace.
    let first = bytes.iter().position(|b| *b == b'\n').unwrap();
    for end in first..bytes.len() {
        summary(&bytes[..end]);
    }
}

#[test]
fn what_is_no_trace_is_said_with_its_line() {
    let (_, bytes) = traced("Two(ANN)", |o| o);
    let text = String::from_utf8(bytes).unwrap();
    let fault = |text: &str| read(text.as_bytes(), None).unwrap_err().to_string();
    assert_eq!(fault(""), "it is empty");
    assert!(fault("action Go() {}\n").starts_with("line 1: is not the first line of a trace"));
    assert!(fault("{\"format\":\"sgap-plan\"}\n").contains("its `format` is `sgap-plan`"));
    let newer = text.replacen("\"version\":1", "\"version\":7", 1);
    assert!(fault(&newer).contains("was written by a newer program: its version is 7"));
    let broken = text.replacen("{\"e\":\"try\"", "{\"e\":\"fly\"", 1);
    assert!(
        fault(&broken).starts_with("line 3: is no event of a trace: unknown variant `fly`"),
        "{}",
        fault(&broken)
    );
    let lost: Vec<&str> = text.lines().filter(|l| !l.contains("\"id\":1,\"in\"")).collect();
    assert_eq!(
        fault(&lost.join("\n")),
        "line 4: speaks of the task 1, which is not there"
    );
    let lost: Vec<&str> = text.lines().filter(|l| !l.contains("\"reason\"")).collect();
    assert!(fault(&lost.join("\n")).contains("speaks of the reason 0, which was not told"));
}

/// A disk that is full after some bytes.
struct Full(usize);

impl Write for Full {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(bytes.len()).ok_or(io::ErrorKind::StorageFull)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_full_disk_is_an_error_of_the_trace_and_not_of_the_search() {
    let (_, bytes) = traced("Two(ANN)", |o| o);
    for room in [0, 10, 200, bytes.len() - 1] {
        let header = summary(&bytes).header;
        let mut writer = Writer::new(Full(room), &header, None);
        let answer = lamps("Two(ANN)", Options::default().observer(&mut writer));
        assert_eq!(answer.ending, Ending::Exhausted);
        assert_eq!(
            writer.finish().unwrap_err().kind(),
            io::ErrorKind::StorageFull,
            "{room}"
        );
    }
}
