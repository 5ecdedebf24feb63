//! The page of each code: what it means, a wrong example and a right one. `sgap explain` prints them.
//!
//! A page is a file of `docs/errors`, named after its code. How bad a problem is that carries the code is said by the
//! page's first line, so that there is one place for it: `Warning: `, or [`OFF`], or neither for an error.

use super::levels::Level;
use super::suggest::nearest;

/// A page of `docs/errors`.
#[derive(Debug, Clone, Copy)]
pub struct Page {
    /// The file's name without its end: `hatp-unknown-task`.
    pub name: &'static str,
    /// Markdown; the first line is `# hatp::unknown-task`.
    pub text: &'static str,
}

/// How the page of a warning begins that is only given when asked for.
pub const OFF: &str = "Warning, off unless asked for: ";

/// How the page of any other warning begins.
const ON: &str = "Warning: ";

impl Page {
    /// Returns the code: `hatp::unknown-task`.
    pub fn code(&self) -> String {
        self.name.replacen('-', "::", 1)
    }

    /// Returns what the page says in one paragraph, on one line.
    pub fn summary(&self) -> String {
        let paragraph = self.text.split("\n\n").nth(1).unwrap_or_default();
        paragraph.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Returns the level at which a warning is given if nobody says otherwise; `None` for an error.
    pub fn warning(&self) -> Option<Level> {
        let summary = self.summary();
        if summary.starts_with(OFF) {
            Some(Level::Allow)
        } else {
            summary.starts_with(ON).then_some(Level::Warn)
        }
    }

    /// Says whether a user may call the page so: by its code, or by the part after the room.
    fn is_called(&self, name: &str) -> bool {
        let part = self.name.split_once('-').map(|(_, part)| part);
        self.code() == name || part == Some(name)
    }
}

/// Returns the pages that `name` may mean, by its code or by the part after `::`; two rooms may share that part.
pub fn called(name: &str) -> impl Iterator<Item = &'static Page> {
    PAGES.iter().filter(move |p| p.is_called(name))
}

/// Returns the code nearest to a name that no page has; of a name without a room, the part after `::`.
pub fn nearest_code(name: &str) -> Option<String> {
    let codes: Vec<String> = PAGES.iter().map(Page::code).collect();
    let part = |code: &'_ str| {
        code.split_once("::")
            .map_or_else(String::new, |(_, part)| part.to_owned())
    };
    let parts: Vec<String> = codes.iter().map(|c| part(c)).collect();
    let among = if name.contains("::") { &codes } else { &parts };
    nearest(name, among.iter().map(String::as_str)).map(str::to_owned)
}

/// Returns the Markdown index of all pages, `docs/errors/README.md`.
pub fn index() -> String {
    let mut out = String::from(
        "# Problems\n\nWhat can be wrong with the input, by code. `sgap explain CODE` prints a page. Written from the pages by\n\
         `INSTA_UPDATE=always cargo test --test reference`.\n",
    );
    let mut room = "";
    for page in PAGES {
        let (of, _) = page.name.split_once('-').unwrap_or((page.name, ""));
        if of != room {
            room = of;
            out += &format!("\n## {room}\n\n| code | what |\n|---|---|\n");
        }
        let summary = page.summary().replace('|', "\\|");
        out += &format!("| [`{}`]({}.md) | {summary} |\n", page.code(), page.name);
    }
    out
}

macro_rules! pages {
    ($($name:literal)*) => {
        /// Every page, by name.
        pub const PAGES: &[Page] = &[$(
            Page { name: $name, text: include_str!(concat!("../../docs/errors/", $name, ".md")) },
        )*];
    };
}

// Written from the names of the files by `INSTA_UPDATE=always cargo test --test reference`.
pages! {
    "hatp-assign-in-test"
    "hatp-bad-allow"
    "hatp-bad-duration"
    "hatp-bad-sequence"
    "hatp-bad-sub-action"
    "hatp-bad-weight"
    "hatp-compare-in-effect"
    "hatp-contradicts-goal"
    "hatp-duplicate-name"
    "hatp-empty"
    "hatp-endless-recursion"
    "hatp-negative-cost"
    "hatp-never-applies"
    "hatp-never-read"
    "hatp-never-set"
    "hatp-no-agent"
    "hatp-not-constant"
    "hatp-not-per-agent"
    "hatp-not-projected"
    "hatp-not-supported"
    "hatp-null-spelling"
    "hatp-order-cycle"
    "hatp-overruled"
    "hatp-recursive-function"
    "hatp-select-follows"
    "hatp-state-in-fact"
    "hatp-static-assigned"
    "hatp-syntax"
    "hatp-time-part"
    "hatp-too-large"
    "hatp-type-conflict"
    "hatp-type-cycle"
    "hatp-unbound-variable"
    "hatp-unknown-attribute"
    "hatp-unknown-choice"
    "hatp-unknown-fact"
    "hatp-unknown-function"
    "hatp-unknown-geometric"
    "hatp-unknown-geometric-word"
    "hatp-unknown-label"
    "hatp-unknown-name"
    "hatp-unknown-setting"
    "hatp-unknown-task"
    "hatp-unknown-type"
    "hatp-unreached-task"
    "hatp-unreadable"
    "hatp-unused-parameter"
    "hatp-unused-variable"
    "hatp-wrong-count"
    "hatp-wrong-fact"
    "hatp-wrong-type"
    "hddl-duplicate-name"
    "hddl-no-task"
    "hddl-not-supported"
    "hddl-order-cycle"
    "hddl-syntax"
    "hddl-too-large"
    "hddl-type-cycle"
    "hddl-unknown-name"
    "hddl-unknown-predicate"
    "hddl-unknown-task"
    "hddl-unknown-type"
    "hddl-unreadable"
    "hddl-wrong-count"
    "hddl-wrong-domain"
    "hddl-wrong-type"
    "mesh-not-found"
    "mesh-unreadable"
    "output-unwritable"
    "plan-too-short"
    "plan-unreadable"
    "srdf-bad-value"
    "srdf-joint-limit"
    "srdf-unknown-name"
    "srdf-unreadable"
    "trace-unreadable"
    "urdf-bad-axis"
    "urdf-bad-limit"
    "urdf-bad-number"
    "urdf-bad-size"
    "urdf-cycle"
    "urdf-duplicate-name"
    "urdf-empty-robot"
    "urdf-held-joint"
    "urdf-joint-not-supported"
    "urdf-mimic-without-leader"
    "urdf-missing-attribute"
    "urdf-missing-element"
    "urdf-missing-limit"
    "urdf-no-geometry"
    "urdf-no-robot"
    "urdf-no-shape"
    "urdf-no-velocity"
    "urdf-not-empty"
    "urdf-not-xml"
    "urdf-too-deep"
    "urdf-two-parents"
    "urdf-two-roots"
    "urdf-unknown-joint"
    "urdf-unknown-joint-type"
    "urdf-unknown-link"
    "urdf-unknown-shape"
    "urdf-unreadable"
    "urdf-xacro"
    "world-bad-size"
    "world-bad-value"
    "world-duplicate-id"
    "world-joint-limit"
    "world-missing-key"
    "world-no-arm"
    "world-no-chain"
    "world-no-container"
    "world-no-geometry"
    "world-no-grasp"
    "world-no-place"
    "world-no-shape"
    "world-no-support"
    "world-no-task"
    "world-not-stable"
    "world-not-toml"
    "world-off-support"
    "world-on-cycle"
    "world-start-in-collision"
    "world-unknown-agent"
    "world-unknown-arm"
    "world-unknown-color"
    "world-unknown-container"
    "world-unknown-end-effector"
    "world-unknown-fact"
    "world-unknown-grasp"
    "world-unknown-group"
    "world-unknown-joint"
    "world-unknown-key"
    "world-unknown-link"
    "world-unknown-object"
    "world-unknown-orientation"
    "world-unknown-posture"
    "world-unknown-support"
    "world-unreadable-file"
    "world-wrong-type"
}
