//! Builds the files of a page step by step in a folder of its own and runs the page's commands there.
//!
//! A command prints its standard error first, then its standard output. Only `sgap` is known; `; echo $?` after it shows the
//! exit code.

use std::fmt::Write;
use std::path::Path;

use assert_cmd::Command;

use super::blocks::{Block, blocks};

/// Runs the page's commands; returns what differs. With `UPDATE_DOCS` set, writes it into the page instead.
pub(crate) fn run(path: &Path, page: &str) -> Vec<String> {
    let all = blocks(page);
    if !all.iter().any(|b| b.language == "console") {
        return Vec::new();
    }
    let lab = tempfile::tempdir().unwrap();
    for folder in ["worlds", "domains"] {
        copy(Path::new(folder), &lab.path().join(folder));
    }
    let is_update = std::env::var_os("UPDATE_DOCS").is_some();
    let (mut faults, mut updated, mut kept) = (Vec::new(), String::new(), 0);
    for block in &all {
        if let Some(name) = block.value("file") {
            write(lab.path(), name, block, path);
        }
        if block.language != "console" {
            continue;
        }
        let mut printed = String::new();
        for command in block.text.lines().filter_map(|l| l.strip_prefix("$ ")) {
            let _ = writeln!(printed, "$ {command}\n{}", execute(lab.path(), command));
            printed.truncate(printed.trim_end().len());
            printed.push('\n');
        }
        if printed != block.text {
            let at = format!("{}:{}", path.display(), block.line);
            faults.push(format!("{at}: shown\n{}\nprinted\n{printed}", block.text));
        }
        updated += &page[kept..block.start];
        updated += &printed;
        kept = block.start + block.text.len();
    }
    if is_update && !faults.is_empty() {
        updated += &page[kept..];
        std::fs::write(path, updated).unwrap();
        return Vec::new();
    }
    faults
}

fn execute(folder: &Path, command: &str) -> String {
    let (command, shows_code) = match command.strip_suffix("; echo $?") {
        Some(command) => (command, true),
        None => (command, false),
    };
    let words = words(command);
    let Some(("sgap", arguments)) = words.split_first().map(|(w, rest)| (w.as_str(), rest)) else {
        panic!("only `sgap` can be run: {command}");
    };
    let output = Command::cargo_bin("sgap")
        .unwrap()
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let mut shown = text(&output.stderr) + &text(&output.stdout);
    if shows_code {
        let _ = writeln!(shown, "{}", output.status.code().unwrap());
    }
    shown
}

/// Splits at blanks outside single quotes.
fn words(command: &str) -> Vec<String> {
    let mut out = Vec::new();
    for (i, part) in command.split('\'').enumerate() {
        if i % 2 == 1 {
            out.push(part.to_owned());
        } else {
            out.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    out
}

/// Writes the block to a file, or into it.
fn write(folder: &Path, name: &str, block: &Block<'_>, page: &Path) {
    let path = folder.join(name);
    let line = block.line;
    let old = || std::fs::read_to_string(&path).unwrap_or_default();
    let new = match (block.value("add"), block.value("replace")) {
        (None, None) => block.text.to_owned(),
        // Before the line `}` that ends the block: `HTN {`.
        (Some(of), None) => {
            let old = old();
            let begin = old.find(&format!("{of} {{\n"));
            let end = begin.and_then(|b| old[b..].find("\n}\n").map(|e| b + e + 1));
            let end = end.unwrap_or_else(|| panic!("{}:{line}: {name} has no block {of}", page.display()));
            // A blank line apart, unless it is the first thing in it.
            let gap = if old[..end].ends_with("{\n") { "" } else { "\n" };
            format!("{}{gap}{}{}", &old[..end], block.text, &old[end..])
        }
        // From the line `  method Bring(` to the next line `  }`.
        (None, Some(item)) => {
            let (old, head) = (old(), item.replacen(':', " ", 1));
            let begin = old.find(&format!("\n  {head}")).map(|b| b + 1);
            let end = begin.and_then(|b| old[b..].find("\n  }\n").map(|e| b + e + "\n  }\n".len()));
            let (Some(begin), Some(end)) = (begin, end) else {
                panic!("{}:{line}: {name} has no `{head}`", page.display())
            };
            format!("{}{}{}", &old[..begin], block.text, &old[end..])
        }
        (Some(_), Some(_)) => panic!("{}:{line}: either `add` or `replace`", page.display()),
    };
    if let Some(parent) = path.parent() {
        std::fs::create_dir_all(parent).unwrap();
    }
    std::fs::write(path, new).unwrap();
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(path, target).unwrap();
        }
    }
}
