//! Text out: to the terminal, or to a file that is whole or not there.
#![expect(clippy::print_stderr, reason = "this is where text leaves the program")]

use std::io::{IsTerminal, Write};
use std::path::Path;

/// How a command failed.
#[derive(Debug)]
pub(super) enum Failure {
    /// Everything is said already; the exit code.
    Code(u8),
    /// What could not be written, and why.
    Output(String),
}

/// Writes to the standard error.
pub(super) fn say(text: &str) {
    eprint!("{text}");
}

/// Writes to the standard output. A reader that went away (`| head`) is no error.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Output(format!("can't write to the standard output: {e}")))
        }
        _ => Ok(()),
    }
}

/// Writes a file beside its place and renames it: no half-written file is ever seen.
pub(super) fn write_file(path: &Path, text: &str) -> Result<(), Failure> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let write = || -> std::io::Result<()> {
        let mut file = tempfile::Builder::new().prefix(".sgap-").tempfile_in(folder)?;
        file.write_all(text.as_bytes())?;
        share(file.as_file())?;
        file.persist(path).map_err(|e| e.error)?;
        Ok(())
    };
    write().map_err(|e| Failure::Output(format!("can't write `{}`: {e}", path.display())))
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
pub(super) fn deliver(path: Option<&Path>, text: &str) -> Result<(), Failure> {
    match path {
        Some(path) => write_file(path, text),
        None => print(text),
    }
}

/// Colours only on a terminal, and not where `NO_COLOR` is set (no-color.org).
pub(super) fn stderr_has_colors() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty())
}
