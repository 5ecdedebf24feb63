//! Writes what a search does, as it does it.
//!
//! Memory: a number for each task that stands, and a bounded table of the reasons written so far; when it is full it is forgotten, and
//! reasons are written again under new numbers.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};

use rustc_hash::FxHashMap;

use super::record::{Candidates, Header, Record};
use crate::engine::{Ending, Event, Observer};
use crate::ir::{Domain, Value};
use crate::plan::Refusal;

/// Reasons remembered [entries of about 50 bytes, and a text for those of geometry].
const MOST_REASONS: usize = 1 << 16;

/// Writes a trace to `out`, which should have a buffer.
pub struct Writer<W: Write> {
    out: W,
    /// The number of each task that stands, by its place in the tree.
    ids: Vec<u64>,
    next_id: u64,
    /// Reasons by fingerprint; those of geometry, which have none, by text.
    reasons: FxHashMap<u128, u64>,
    calls: FxHashMap<String, u64>,
    next_reason: u64,
    clock: Option<Box<dyn FnMut() -> u64>>,
    last_time: Option<u64>,
    error: Option<io::Error>,
}

impl<W: Write> Writer<W> {
    /// Writes the first line. With a `clock` [us], times are written between the other lines.
    pub fn new(out: W, header: &Header, clock: Option<Box<dyn FnMut() -> u64>>) -> Self {
        let mut writer = Writer {
            out,
            ids: Vec::new(),
            next_id: 0,
            reasons: FxHashMap::default(),
            calls: FxHashMap::default(),
            next_reason: 0,
            clock,
            last_time: None,
            error: None,
        };
        writer.line(header);
        writer
    }

    /// Ends the file.
    ///
    /// # Errors
    ///
    /// The first thing that went wrong. After that nothing more was written.
    pub fn finish(mut self) -> io::Result<()> {
        match self.error.take() {
            Some(error) => Err(error),
            None => self.out.flush(),
        }
    }

    fn line(&mut self, line: &impl serde::Serialize) {
        if self.error.is_some() {
            return;
        }
        let written = serde_json::to_writer(&mut self.out, line).map_err(io::Error::from);
        self.error = written.and_then(|()| self.out.write_all(b"\n")).err();
    }

    fn id(&self, node: u32) -> u64 {
        self.ids.get(node as usize).copied().unwrap_or(0)
    }

    /// Returns the number of a reason, which is written if it is new.
    fn reason(&mut self, print: u128, words: Option<&Refusal>) -> u64 {
        if let Some(n) = self.reasons.get(&print) {
            return *n;
        }
        let text = words.map(Refusal::to_string).unwrap_or_default();
        let of_call = matches!(words, Some(Refusal::Geometry(_)));
        if let Some(n) = self.calls.get(&text).filter(|_| of_call) {
            return *n;
        }
        if self.reasons.len() + self.calls.len() >= MOST_REASONS {
            self.reasons.clear();
            self.calls.clear();
        }
        let n = self.next_reason;
        self.next_reason += 1;
        self.line(&Record::Reason {
            n,
            kind: words.map_or("", Refusal::kind).into(),
            rule: words.map(Refusal::rule).unwrap_or_default().into(),
            text: text.as_str().into(),
        });
        if of_call {
            self.calls.insert(text, n);
        } else {
            self.reasons.insert(print, n);
        }
        n
    }
}

impl<W: Write> fmt::Debug for Writer<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Writer")
            .field("next_id", &self.next_id)
            .field("error", &self.error)
            .finish_non_exhaustive()
    }
}

impl<W: Write> Observer for Writer<W> {
    fn hear(&mut self, domain: &Domain, event: &Event<'_>) {
        if self.error.is_some() {
            return;
        }
        if let Some(clock) = &mut self.clock {
            let now = clock();
            if self.last_time != Some(now) {
                self.last_time = Some(now);
                self.line(&Record::Time { us: now });
            }
        }
        let record = match event {
            Event::TakenUp {
                node,
                parent,
                task,
                args,
                depth,
            } => {
                let id = self.next_id;
                self.next_id += 1;
                self.ids.truncate(*node as usize);
                self.ids.push(id);
                Record::Task {
                    id,
                    parent: parent.map(|p| self.id(p)),
                    depth: *depth,
                    task: call(domain, domain.task_name(*task), args).into(),
                }
            }
            Event::GoalHeld { node } => Record::Goal { id: self.id(*node) },
            Event::Decomposed { node, decomposition } => Record::Try {
                id: self.id(*node),
                decomposition: *decomposition,
            },
            Event::Bound { node, variable, value } => Record::Bind {
                id: self.id(*node),
                var: (*variable).into(),
                value: domain.show(value).into(),
            },
            Event::Projecting { node, call: asked } => Record::Ask {
                id: self.id(*node),
                call: Some(call(domain, asked.name, asked.args).into()),
                after: None,
            },
            Event::Alternative { node, tried } => Record::Ask {
                id: self.id(*node),
                call: None,
                after: Some(*tried),
            },
            Event::Applied {
                node,
                cost,
                gas,
                n_actions,
            } => Record::Act {
                id: self.id(*node),
                cost: *cost,
                gas: gas.map(|g| g.gas.0),
                alternative: gas.map(|g| g.alternative),
                actions: *n_actions,
            },
            Event::Refused { node, refusal, words } => Record::Refuse {
                id: self.id(*node),
                why: self.reason(*refusal, *words),
                geometry: candidates(*words),
            },
            Event::Repeated { node } => Record::Repeat { id: self.id(*node) },
            Event::WentBack {
                node,
                choice,
                kept,
                n_actions,
            } => {
                // Places are given in the order of numbers, so what is undone are the last ones.
                let from = self.ids.get(*kept as usize).copied().unwrap_or(self.next_id);
                self.ids.truncate(*kept as usize);
                Record::Back {
                    id: self.id(*node),
                    choice: (*choice).into(),
                    from,
                    actions: *n_actions,
                }
            }
            Event::Found {
                number,
                cost,
                n_actions,
            } => Record::Plan {
                n: *number,
                cost: *cost,
                actions: *n_actions,
            },
            Event::Ended { ending, statistics } => Record::End {
                ending: ending_word(*ending).into(),
                expansions: statistics.expansions,
                backtracks: statistics.backtracks,
                repeated: statistics.repeated,
                projections: statistics.projections,
                alternatives: statistics.alternatives,
                plans: statistics.plans,
            },
        };
        self.line(&record);
    }

    fn remembers(&self, refusal: u128) -> bool {
        self.reasons.contains_key(&refusal)
    }
}

fn call(domain: &Domain, name: &str, args: &[Value]) -> String {
    let args: Vec<String> = args.iter().map(|v| domain.show(v)).collect();
    format!("{name}({})", args.join(", "))
}

fn candidates(words: Option<&Refusal>) -> Option<Candidates<'static>> {
    match words {
        Some(Refusal::Geometry(refusal)) => Some(Candidates {
            tried: refusal.tried,
            exhausted: refusal.exhausted,
            causes: refusal
                .causes
                .iter()
                .map(|c| (Cow::Owned(c.to_string()), c.count))
                .collect(),
        }),
        _ => None,
    }
}

fn ending_word(ending: Ending) -> &'static str {
    match ending {
        Ending::FirstPlan => "found",
        Ending::Exhausted => "exhausted",
        Ending::ExhaustedTruncated(_) => "truncated",
        Ending::BudgetSpent => "budget",
        Ending::Interrupted => "interrupted",
    }
}
