//! `sgap explain CODE`: the pages of docs/errors, which are part of the program.

use clap::Args;

use super::code;
use super::output::{Failure, print, say};
use sgap::diag::pages::{self, PAGES, Page};

/// Which problem.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Code of the problem, with or without the part before `::`
    #[arg(required_unless_present = "list")]
    code: Option<String>,
    /// List every code with one line about it
    #[arg(long, conflicts_with = "code")]
    list: bool,
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let Some(name) = options.code.as_deref().filter(|_| !options.list) else {
        let line = |page: &Page| format!("{}  {}\n", page.code(), page.summary());
        return print(&PAGES.iter().map(line).collect::<String>());
    };
    let pages: Vec<&str> = pages::called(name).map(|page| page.text.trim_end()).collect();
    if pages.is_empty() {
        let near = pages::nearest_code(name).map(|near| format!("did you mean `{near}`?"));
        let help = near.unwrap_or_else(|| "`sgap explain --list` shows all".into());
        say(&format!("error: no problem has the code `{name}`\nhelp: {help}\n"));
        return Err(Failure::Code(code::PROBLEMS));
    }
    print(&format!("{}\n", pages.join("\n\n")))
}
