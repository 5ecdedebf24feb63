//! The `sgap` program: see `sgap --help`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    std::panic::set_hook(Box::new(|info| {
        #[expect(clippy::print_stderr, reason = "the last words of a broken program")]
        {
            eprintln!("this is a bug of sgap, not of your files: {info}");
            eprintln!("please report it with the command that you ran and the files it read");
        }
    }));
    std::panic::catch_unwind(cli::run).unwrap_or(ExitCode::from(cli::code::BUG))
}
