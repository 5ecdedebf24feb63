//! `sgap trace FILE`, and the file that `sgap plan --trace FILE` writes.

use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::output::{Failure, check_place, print};
use super::{Inputs, fail};
use sgap::diag::Problem;
use sgap::report::trace as report;
use sgap::trace::{FORMAT, Header, VERSION, Writer, read};

/// Which trace, and what of it.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Trace as written by `sgap plan --trace FILE`
    file: PathBuf,
    /// Count only what is in tasks of this name, or in one task with its arguments: 'Pick(PR2, CUP)'
    #[arg(long, value_name = "TASK")]
    task: Option<String>,
    /// Show tasks down to this depth
    #[arg(long, value_name = "N", default_value_t = 12)]
    depth: usize,
    /// Show what ended branches alone, and all of it
    #[arg(long)]
    failures: bool,
    /// Print all counts as JSON
    #[arg(long, conflicts_with_all = ["depth", "failures"])]
    json: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let shown = options.file.display();
    let unreadable = |what: String| {
        let message = format!("can't read the trace `{shown}`: {what}");
        let help = "a trace is written by `sgap plan DOMAIN [WORLD] --trace FILE`";
        fail(Problem::unplaced("trace::unreadable", message).help(help))
    };
    if options.file.is_dir() {
        return Err(unreadable("it is a directory".into()));
    }
    let file = File::open(&options.file).map_err(|e| {
        unreadable(match e.kind() {
            std::io::ErrorKind::NotFound => "there is no such file".into(),
            std::io::ErrorKind::PermissionDenied => "no permission to read it".into(),
            _ => e.to_string(),
        })
    })?;
    let summary = read(BufReader::new(file), options.task.as_deref()).map_err(|e| unreadable(e.to_string()))?;
    print(&match (options.json, options.failures) {
        (true, _) => {
            report::json(&summary).map_err(|e| Failure::Output(format!("can't write the trace as JSON: {e}")))?
        }
        (false, true) => report::failures(&summary),
        (false, false) => report::summary(&summary, options.depth),
    })
}

/// A trace that is being written.
pub(super) struct Sink {
    path: PathBuf,
    pub writer: Writer<BufWriter<File>>,
}

/// Makes the file and writes its first line.
pub(super) fn open(path: &Path, inputs: &Inputs, task: String, seed: u64, with_times: bool) -> Result<Sink, Failure> {
    check_place(path)?;
    let file = File::create(path).map_err(|e| unwritable(path, &e))?;
    let header = Header {
        format: FORMAT.into(),
        version: VERSION,
        domain: inputs.domain.to_string_lossy().into(),
        world: inputs.world.as_ref().map(|w| w.to_string_lossy().into()),
        task,
        seed,
    };
    let clock = with_times.then(|| {
        #[expect(clippy::disallowed_methods, reason = "the times of `--trace-times`")]
        let begin = Instant::now();
        let clock = move || u64::try_from(begin.elapsed().as_micros()).unwrap_or(u64::MAX);
        Box::new(clock) as Box<dyn FnMut() -> u64>
    });
    Ok(Sink {
        path: path.to_owned(),
        writer: Writer::new(BufWriter::with_capacity(1 << 16, file), &header, clock),
    })
}

impl Sink {
    /// Writes what is left.
    pub(super) fn finish(self) -> Result<(), Failure> {
        let path = self.path;
        self.writer.finish().map_err(|e| unwritable(&path, &e))
    }
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::Output(format!("can't write the trace `{}`: {}", path.display(), error.kind()))
}
