//! Text out: to the terminal, or to a file that is whole or not there.

use std::io::{BufWriter, IsTerminal, Write};
use std::path::Path;
use std::sync::OnceLock;

/// How a command failed.
#[derive(Debug)]
pub(super) enum Failure {
    /// Everything is said already; the exit code.
    Code(u8),
    /// What could not be written, and why.
    Output(String),
}

/// Writes to the standard error. Where its reader went away there is nobody left to tell.
pub(super) fn say(text: &str) {
    let _ = std::io::stderr().lock().write_all(text.as_bytes());
}

/// How much is said besides answers and problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verbosity {
    /// Nothing.
    Quiet,
    /// Notes and progress.
    Normal,
    /// Counts and times, too.
    Verbose,
}

/// Set once, before any command runs.
static VERBOSITY: OnceLock<Verbosity> = OnceLock::new();

pub(super) fn set_verbosity(verbosity: Verbosity) {
    // Nobody sets it twice.
    let _ = VERBOSITY.set(verbosity);
}

pub(super) fn verbosity() -> Verbosity {
    VERBOSITY.get().copied().unwrap_or(Verbosity::Normal)
}

/// Says what is neither an answer nor a problem; nothing under `--quiet`.
pub(super) fn note(text: &str) {
    if verbosity() != Verbosity::Quiet {
        say(text);
    }
}

/// Writes to the standard output. A reader that went away (`| head`) is no error.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    print_by(&mut |out| out.write_all(text.as_bytes()))
}

fn print_by(write: Writing<'_>) -> Result<(), Failure> {
    let mut out = BufWriter::with_capacity(BUFFER, std::io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Output(format!("can't write to the standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// What writes a text bit by bit.
type Writing<'a> = &'a mut dyn FnMut(&mut dyn Write) -> std::io::Result<()>;

/// Bytes written at once.
const BUFFER: usize = 1 << 16;

/// Writes a file beside its place and renames it: no half-written file is ever seen.
pub(super) fn write_file(path: &Path, text: &str) -> Result<(), Failure> {
    write_file_by(path, &mut |out| out.write_all(text.as_bytes()))
}

fn write_file_by(path: &Path, write: Writing<'_>) -> Result<(), Failure> {
    check_place(path)?;
    let mut buffered = |out: &mut dyn Write| -> std::io::Result<()> {
        let mut out = BufWriter::with_capacity(BUFFER, out);
        write(&mut out)?;
        out.flush()
    };
    let mut write = || -> std::io::Result<()> {
        // A link stays a link, and a device is written to, not replaced.
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if std::fs::metadata(&target).is_ok_and(|m| !m.is_file()) {
            return buffered(&mut std::fs::OpenOptions::new().write(true).open(&target)?);
        }
        let mut file = tempfile::Builder::new().prefix(".sgap-").tempfile_in(folder(&target))?;
        buffered(&mut file)?;
        match std::fs::metadata(&target) {
            Ok(old) => file.as_file().set_permissions(old.permissions())?,
            Err(_) => share(file.as_file())?,
        }
        file.persist(&target).map_err(|e| e.error)?;
        Ok(())
    };
    write().map_err(|e| unwritable(path, &why(&e)))
}

/// Says whether a file can be written at `path`, as far as that can be known before: a search may take long.
pub(super) fn check_place(path: &Path) -> Result<(), Failure> {
    if path.is_dir() {
        return Err(unwritable(path, "it is a directory"));
    }
    match std::fs::metadata(folder(path)) {
        Ok(found) if found.is_dir() => Ok(()),
        Ok(_) => Err(unwritable(
            path,
            &format!("`{}` is not a directory", folder(path).display()),
        )),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let why = format!("there is no directory `{}`", folder(path).display());
            Err(unwritable(path, &why))
        }
        Err(e) => Err(unwritable(path, &why(&e))),
    }
}

fn folder(path: &Path) -> &Path {
    path.parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

fn unwritable(path: &Path, why: &str) -> Failure {
    Failure::Output(format!("can't write `{}`: {why}", path.display()))
}

/// Returns the reason alone: the system's own text may name a temporary file.
fn why(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::PermissionDenied => "no permission to write there".into(),
        kind => kind.to_string(),
    }
}

/// Temporary files are their owner's alone; what the user asked for is as readable as any file.
#[cfg(unix)]
fn share(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn share(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

/// Writes to the file if one is named, else to the standard output.
pub(super) fn deliver(path: Option<&Path>, write: Writing<'_>) -> Result<(), Failure> {
    match path {
        Some(path) => write_file_by(path, write),
        None => print_by(write),
    }
}

/// Colours only on a terminal, and not where `NO_COLOR` is set (no-color.org).
pub(super) fn stderr_has_colors() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}
