//! What `--help` shows is true: its examples run as they stand there.

use std::path::Path;

use super::Lab;

const COMMANDS: [&str; 17] = [
    "plan",
    "trace",
    "validate",
    "check",
    "explain",
    "doc",
    "fmt",
    "import",
    "facts",
    "view",
    "reproduce",
    "watch",
    "new",
    "schema",
    "completions",
    "man",
    "lsp",
];

/// A folder with the project's domains and worlds.
fn project() -> Lab {
    fn copy(from: &Path, to: &Path) {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let path = entry.unwrap().path();
            let target = to.join(path.file_name().unwrap());
            match path.is_dir() {
                true => copy(&path, &target),
                false => drop(std::fs::copy(&path, target).unwrap()),
            }
        }
    }
    let lab = Lab::new();
    for folder in ["domains", "worlds"] {
        copy(Path::new(folder), &lab.path(folder));
    }
    lab
}

/// Splits a command line at spaces outside of single quotes; what comes after ` < ` or ` > FILE` at its end is left out.
fn words(line: &str) -> Vec<String> {
    let line = line.split(" < ").next().unwrap();
    let line = line.split(" > ~/").next().unwrap();
    let line = line.split(" > sgap").next().unwrap();
    let mut words = Vec::new();
    for (i, part) in line.split('\'').enumerate() {
        match i % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    words
}

#[test]
fn every_command_is_listed_and_its_examples_run() {
    let lab = project();
    let all = lab.ends(0, &["--help"]).out;
    for command in COMMANDS {
        assert!(all.contains(&format!("\n  {command} ")), "{command}");
        let help = lab.ends(0, &[command, "--help"]).out;
        let examples: Vec<&str> = help.lines().filter_map(|l| l.strip_prefix("  sgap ")).collect();
        assert_eq!(examples.is_empty(), command == "lsp", "{help}");
        for line in examples {
            // A plan that is read is one that was written for the same input.
            if line.contains("plan.json") && !line.contains(" -o ") {
                let input = match line.contains("clear_table") {
                    true => "domains/clear_table.hatp --task 'ClearTable(TABLE)'",
                    false => "domains/three_objects.hatp worlds/three_objects.toml",
                };
                let made = words(&format!("plan {input} --json -o plan.json"));
                lab.ends(0, &made.iter().map(String::as_str).collect::<Vec<_>>());
            }
            let words = words(line);
            let arguments: Vec<&str> = words.iter().map(String::as_str).collect();
            // The one reads what is typed, the other goes on for ever.
            if arguments.contains(&"-") || command == "watch" {
                continue;
            }
            lab.ends(0, &arguments);
        }
    }
}

#[test]
fn view_shows_each_way_to_call_it() {
    let help = Lab::new().ends(0, &["view", "--help"]).out;
    for usage in ["<DOMAIN> [WORLD]", "<WORLD> [PLAN]", "[OPTIONS] <PLAN>"] {
        assert!(help.contains(usage), "{usage}: {help}");
    }
}
