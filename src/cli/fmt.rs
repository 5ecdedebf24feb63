//! `sgap fmt [--check] FILE...`.

use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, note, print, say, write_file};
use super::{code, report};
use sgap::Disk;
use sgap::diag::render::fitted;
use sgap::diag::{Problem, Problems};
use sgap::source::{Files, Sources};
use sgap::syntax;

/// What to format.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Domain files (.hatp, .dom), or `-` for the standard input, which is written to the standard output
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Write nothing; show what would change, and end with exit code 1 if anything would
    #[arg(long)]
    check: bool,
}

/// What the standard input is called in messages.
const STDIN: &str = "standard input";

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let (mut n_wrong, mut n_changed) = (0, 0);
    for path in &options.files {
        let mut sources = Sources::default();
        match formatted(path, &mut sources) {
            Err(problems) => {
                n_wrong += 1;
                // Each file's problems are shown; the others are still formatted.
                let _ = report(problems, &sources, None::<()>);
            }
            Ok((old, new)) => {
                n_changed += usize::from(old != new);
                if options.check {
                    if old != new {
                        say(&format!("{} is not formatted\n{}", name(path), difference(&old, &new)));
                    }
                } else if is_stdin(path) {
                    print(&new)?;
                } else if old != new {
                    write_file(path, &new)?;
                    note(&format!("formatted {}\n", path.display()));
                }
            }
        }
    }
    if n_wrong > 0 || options.check && n_changed > 0 {
        return Err(Failure::Code(code::PROBLEMS));
    }
    Ok(())
}

fn is_stdin(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn name(path: &Path) -> String {
    if is_stdin(path) {
        STDIN.to_owned()
    } else {
        format!("`{}`", path.display())
    }
}

/// Returns the text as it is and as it should be.
fn formatted(path: &Path, sources: &mut Sources) -> Result<(String, String), Problems> {
    let read = if is_stdin(path) {
        let mut bytes = Vec::new();
        let read = std::io::stdin().lock().read_to_end(&mut bytes);
        read.map_err(|e| e.to_string())
            .and_then(|_| String::from_utf8(bytes).map_err(|e| e.to_string()))
    } else {
        Disk.read(&path.to_string_lossy())
    };
    let text = read.map_err(|why| {
        let message = format!("can't read {}: {why}", name(path));
        Problems(vec![Problem::unplaced("hatp::unreadable", message)])
    })?;
    let shown = if is_stdin(path) {
        STDIN.into()
    } else {
        path.to_string_lossy()
    };
    let file = sources.add(shown, text.clone());
    let new = syntax::format(file, &text)?;
    Ok((text, new))
}

/// Returns the lines that differ, between what both texts have in common at their beginning and at their end.
fn difference(old: &str, new: &str) -> String {
    const MOST: usize = 40;
    // Characters of a line.
    const WIDEST: usize = 200;
    let (old, new): (Vec<&str>, Vec<&str>) = (old.split('\n').collect(), new.split('\n').collect());
    let same = |pair: &(&&str, &&str)| pair.0 == pair.1;
    let head = old.iter().zip(&new).take_while(same).count();
    let most = old.len().min(new.len()) - head;
    let tail = old
        .iter()
        .rev()
        .zip(new.iter().rev())
        .take(most)
        .take_while(same)
        .count();
    let mut out = format!("  from line {}:\n", head + 1);
    for (sign, lines) in [('-', &old), ('+', &new)] {
        let lines = &lines[head..lines.len() - tail];
        for line in lines.iter().take(MOST) {
            let shown = fitted(line.trim_end_matches('\r'), WIDEST);
            out.push_str(&format!("  {sign} {shown}\n"));
        }
        if lines.len() > MOST {
            out.push_str(&format!("  {sign} and {} more lines\n", lines.len() - MOST));
        }
    }
    out
}
