//! The `sgap` program: see `sgap --help`.

mod cli;

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(|info| {
        // Where nobody reads the standard error, a second panic would end the program without its exit code.
        let _ = writeln!(
            std::io::stderr(),
            "this is a bug of sgap, not of your files: {info}\n\
             please report it with the command that you ran and the files it read"
        );
    }));
    std::panic::catch_unwind(cli::run).unwrap_or(ExitCode::from(cli::code::BUG))
}
