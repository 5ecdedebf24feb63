//! `sgap doc [DOMAIN] [NAME]`.

use clap::Args;

use super::code;
use super::output::{Failure, print, say};
use super::problems::{ProblemOptions, To};
use sgap::Disk;
use sgap::diag::suggest::did_you_mean;
use sgap::diag::{Problem, Problems};
use sgap::doc::{self, Entry};
use sgap::source::{Files, Sources};
use sgap::syntax;

/// What to look up.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Domain file (.hatp, .dom), and the name of one declaration or built-in; each may be left out
    #[arg(value_names = ["DOMAIN", "NAME"], num_args = 0..=2)]
    what: Vec<String>,
    /// Print an array of JSON objects instead of Markdown
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    problems: ProblemOptions,
}

/// Says whether the argument is a file: names have neither an end nor a folder.
fn is_file(argument: &str) -> bool {
    argument.ends_with(".hatp") || argument.ends_with(".dom") || argument.contains(['/', '\\'])
}

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let (files, names): (Vec<&String>, Vec<&String>) = options.what.iter().partition(|what| is_file(what));
    let entries = match files.as_slice() {
        [] => doc::builtins(),
        [file] => of_domain(file, &options.problems)?,
        [_, second, ..] => {
            say(&format!(
                "error: one domain at a time, and `{second}` is another file\n"
            ));
            return Err(Failure::Code(code::WRONG_USAGE));
        }
    };
    let (title, shown) = match names.as_slice() {
        [] => (title(files.first().copied()), entries),
        [name] => (String::new(), named(name, entries)?),
        [_, second, ..] => {
            say(&format!(
                "error: one name at a time, and `{second}` is another; a domain ends with .hatp or .dom\n"
            ));
            return Err(Failure::Code(code::WRONG_USAGE));
        }
    };
    if options.json {
        return print(&doc::json(&shown));
    }
    print(&format!("{title}{}", doc::markdown(&shown)))
}

fn title(file: Option<&String>) -> String {
    file.map_or_else(|| doc::TITLE.to_owned(), |file| format!("# {file}\n\n"))
}

/// Returns what the domain declares; problems of its syntax are told, and the rest is shown all the same.
fn of_domain(path: &str, problems: &ProblemOptions) -> Result<Vec<Entry>, Failure> {
    let mut sources = Sources::default();
    let text = match Disk.read(path) {
        Ok(text) => text,
        Err(why) => {
            let problem = Problem::unplaced("hatp::unreadable", format!("can't read `{path}`: {why}"));
            return problems.report(Problems(vec![problem]), &sources, None, To::Error);
        }
    };
    let file = sources.add(path, text);
    let (ast, found) = syntax::parse(file, &sources.get(file).text);
    let entries = doc::entries(&ast, &sources.get(file).text);
    problems.report(found, &sources, Some(entries), To::Error)
}

/// Returns the entries of that name: those of the domain, else the built-ins.
fn named(name: &str, entries: Vec<Entry>) -> Result<Vec<Entry>, Failure> {
    let builtins = doc::builtins();
    let mut found = doc::called(name, &entries);
    if found.is_empty() {
        found = doc::called(name, &builtins);
    }
    if found.is_empty() {
        let names = entries.iter().chain(&builtins).map(|entry| entry.name.as_str());
        let help = did_you_mean(name, names).unwrap_or_else(|| "`sgap doc` lists what is built in".into());
        say(&format!("error: nothing is called `{name}`\nhelp: {help}\n"));
        return Err(Failure::Code(code::PROBLEMS));
    }
    Ok(found)
}
