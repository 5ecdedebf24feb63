//! `sgap watch DOMAIN WORLD ..`: `sgap plan` with the same arguments, again whenever one of the files that it reads is saved.
//!
//! Each search is a process of its own, so that one that takes long can be ended when a file changes under it.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, SystemTime};

use super::output::{Failure, note, say};
use super::plan;
use sgap::load::{Paths, load_paths};
use sgap::planner::Disk;
use sgap::source::{Files, Sources};

/// Between two looks at the files.
const LOOK: Duration = Duration::from_millis(200);

/// What a file was when it was looked at: when it was written, and its length; `None` where there is none.
type Stamps = BTreeMap<String, Option<(SystemTime, u64)>>;

pub(super) fn run(options: &plan::Options) -> Result<(), Failure> {
    loop {
        let before = stamps(options);
        let mut child = start()?;
        loop {
            std::thread::sleep(LOOK);
            if before.iter().any(|(path, stamp)| stamp_of(path) != *stamp) {
                break;
            }
        }
        // An editor may write in two steps.
        std::thread::sleep(LOOK);
        stop(&mut child);
        note("\na file has changed: planning again\n");
    }
}

/// Starts `sgap plan` with this process's own arguments.
fn start() -> Result<Child, Failure> {
    let failed = |e: std::io::Error| Failure::Output(format!("can't start `sgap plan`: {e}"));
    let mut arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    // Before it come options without values alone.
    if let Some(word) = arguments.iter_mut().find(|a| *a == "watch") {
        *word = "plan".into();
    }
    let program = std::env::current_exe().map_err(failed)?;
    Command::new(program).args(arguments).spawn().map_err(failed)
}

fn stop(child: &mut Child) {
    match child.try_wait() {
        Ok(Some(_)) => {}
        Ok(None) | Err(_) => {
            if let Err(why) = child.kill() {
                say(&format!("the search before can't be ended: {why}\n"));
            }
            let _ = child.wait();
        }
    }
}

/// Returns the files that the input names, and what they are now. Problems are the search's to tell.
fn stamps(options: &plan::Options) -> Stamps {
    let files = Recorder::default();
    let inputs = &options.inputs;
    let domain = inputs.domain.to_string_lossy();
    let world = inputs.world.as_ref().map(|w| w.to_string_lossy());
    let with: Vec<_> = inputs.with.iter().map(|w| w.to_string_lossy()).collect();
    let with: Vec<&str> = with.iter().map(AsRef::as_ref).collect();
    let paths = Paths {
        domain: &domain,
        with: &with,
        world: world.as_deref(),
        task: inputs.task.as_deref(),
    };
    let _ = load_paths(&paths, &mut Sources::default(), &files);
    let read = files.read.into_inner();
    read.into_iter()
        .map(|path| {
            let stamp = stamp_of(&path);
            (path, stamp)
        })
        .collect()
}

/// The disk, and what was read of it.
#[derive(Debug, Default)]
struct Recorder {
    read: RefCell<BTreeSet<String>>,
}

impl Files for Recorder {
    fn read(&self, path: &str) -> Result<String, String> {
        self.read.borrow_mut().insert(path.to_owned());
        Disk.read(path)
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read.borrow_mut().insert(path.to_owned());
        Disk.read_bytes(path)
    }

    fn packages(&self) -> Vec<String> {
        Disk.packages()
    }

    fn cached(&self, key: &str) -> Option<Vec<u8>> {
        Disk.cached(key)
    }

    fn keep(&self, key: &str, bytes: &[u8]) {
        Disk.keep(key, bytes);
    }

    fn list(&self, folder: &str) -> Vec<String> {
        Disk.list(folder)
    }
}

fn stamp_of(path: &str) -> Option<(SystemTime, u64)> {
    let found = std::fs::metadata(Path::new(path)).ok()?;
    Some((found.modified().ok()?, found.len()))
}
