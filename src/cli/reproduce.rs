//! `sgap reproduce [TABLE]`: the thesis's experiments, run here, beside the figures that the thesis gives.
//!
//! Each row is a domain, a world and settings, all of them inside of the program; one run differs from the next by its seed alone. Times are
//! those of a run in this process, reading excepted; the thesis's machine was another (i7-3720QM, 2.6 GHz). What differs in shape
//! is explained in `docs/thesis.md`, not tuned away.

mod measure;
mod tables;

use clap::{Args, ValueEnum};

use super::output::{Failure, print};
use super::progress::Progress;
use measure::measure;
use tables::{Experiment, TABLES};

/// Which experiments, and how often.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// One of the tables; default: all
    #[arg(value_enum)]
    table: Option<Name>,
    /// Runs of each row; default: as many as the thesis made
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    runs: Option<u32>,
    /// Seed of the first run; the others follow
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Print an array of JSON objects
    #[arg(long)]
    json: bool,
}

/// The thesis's tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Name {
    /// Three objects within a human's reach, by branching factor (S1)
    #[value(name = "4.3")]
    T4_3,
    /// A cluttered table, without the request virtualPlace and with it (S3)
    #[value(name = "4.4")]
    T4_4,
    /// Place, PlaceR and PlaceRC where a later object hides an earlier one (S4)
    #[value(name = "4.4.2")]
    T4_4_2,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let tables = TABLES
        .iter()
        .filter(|t| options.table.is_none_or(|name| name == t.name));
    let mut rows = Vec::new();
    for table in tables {
        let runs = options.runs.unwrap_or(table.runs);
        let mut text = format!("{}\n{runs} runs each, seeds from {}\n\n", table.title, options.seed);
        let mut lines = vec![heads()];
        for experiment in table.experiments {
            let progress = Progress::new("reproducing; Ctrl-C ends it");
            let measured = measure(experiment, options.seed, runs).map_err(bug)?;
            drop(progress);
            lines.push(measured.cells(experiment.label));
            lines.extend(experiment.thesis.map(|thesis| thesis.cells()));
            rows.push(measured.json(table.name, experiment));
        }
        text += &columns(&lines);
        text += "\n";
        if !options.json {
            print(&text)?;
        }
    }
    match options.json {
        true => print(&format!("{:#}\n", serde_json::Value::Array(rows))),
        false => Ok(()),
    }
}

/// The files are the program's own: that one of them is refused is no fault of the user's.
fn bug(why: String) -> Failure {
    Failure::Output(format!("an experiment of sgap's own is refused: {why}"))
}

fn heads() -> Vec<String> {
    let heads = [
        "",
        "time [s]",
        "sd",
        "success [%]",
        "alternatives",
        "computed",
        "actions",
        "cost",
    ];
    heads.map(str::to_owned).to_vec()
}

/// Returns the lines with their cells one below the other: the first to the left, numbers to the right.
fn columns(lines: &[Vec<String>]) -> String {
    let width = |i: usize| {
        let cells = lines.iter().filter_map(|l| l.get(i));
        cells.map(|c| c.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..lines.first().map_or(0, Vec::len)).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let mut row = String::new();
        for (i, (cell, width)) in line.iter().zip(&widths).enumerate() {
            match i {
                0 => row += &format!("{cell:<width$}"),
                _ => row += &format!("  {cell:>width$}"),
            }
        }
        text += row.trim_end();
        text.push('\n');
    }
    text
}
