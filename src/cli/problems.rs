//! How problems leave the program: in which form, and which warnings at all.

use clap::{Args, ValueEnum};

use super::code;
use super::output::{self, Failure, print, say};
use sgap::diag::levels::{Level, Levels, warnings_called};
use sgap::diag::{Problems, json, render};
use sgap::source::Sources;

/// What the user asks for.
#[derive(Debug, Args)]
pub(super) struct ProblemOptions {
    /// Form in which problems are printed; of `plan` and `view` also that of the answer
    #[arg(long, value_name = "FORM", value_enum, default_value_t = Form::Human, help_heading = "Problems")]
    pub format: Form,
    /// Count this warning as an error; `warnings` stands for all
    #[arg(long, value_name = "NAME", value_parser = named_or_all, help_heading = "Problems")]
    deny: Vec<Named>,
    /// Give this warning even if it is off by default
    #[arg(long, value_name = "NAME", value_parser = named, help_heading = "Problems")]
    warn: Vec<Named>,
    /// Do not give this warning
    #[arg(long, value_name = "NAME", value_parser = named, help_heading = "Problems")]
    allow: Vec<Named>,
}

/// A form of problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Form {
    /// With the lines of the file, for a terminal
    Human,
    /// One line each: FILE:LINE:COLUMN: error[CODE]: MESSAGE (HELP)
    Concise,
    /// One JSON object on each line
    Json,
    /// `plan` of an HDDL pair only: the plan in the form of the planning competition; problems as `human`
    Ipc,
    /// `plan` and `view` only, problems as `human`: the scene with its animation as glTF 2.0, for any 3D viewer
    Gltf,
    /// So, too: the trajectories as a table
    Csv,
    /// So, too: the trajectories as ROS 2 messages `trajectory_msgs/JointTrajectory` in YAML
    Ros,
    /// So, too: the world around the robot as a MoveIt planning scene in YAML
    Moveit,
    /// So, too: the decomposition tree and the causal links as a graph for Graphviz
    Dot,
}

/// Where problems go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum To {
    /// The standard error.
    Error,
    /// The standard output, for a command whose answer they are; what is for people goes to the standard error all the same.
    Output,
}

/// The codes of the warnings that the user named; none stands for all.
#[derive(Debug, Clone)]
struct Named(Vec<String>);

fn named(name: &str) -> Result<Named, String> {
    let found = warnings_called(name).map(Named);
    found.map_err(|help| format!("no warning is called `{name}`: {help}"))
}

fn named_or_all(name: &str) -> Result<Named, String> {
    match name {
        "warnings" => Ok(Named(Vec::new())),
        _ => named(name),
    }
}

impl ProblemOptions {
    fn levels(&self) -> Levels {
        let of = [
            (&self.deny, Level::Deny),
            (&self.warn, Level::Warn),
            (&self.allow, Level::Allow),
        ];
        let codes = of.into_iter().flat_map(|(named, level)| {
            let codes = named.iter().flat_map(|n| n.0.clone());
            codes.map(move |code| (code, level))
        });
        Levels {
            of: codes.collect(),
            deny_all: self.deny.iter().any(|named| named.0.is_empty()),
        }
    }

    /// Prints the problems that the user wants; fails with exit code 1 if there is no value or an error among them.
    pub(super) fn report<T>(
        &self,
        problems: Problems,
        sources: &Sources,
        value: Option<T>,
        to: To,
    ) -> Result<T, Failure> {
        let problems = self.levels().apply(problems, sources);
        if !problems.0.is_empty() {
            let text = match self.format {
                Form::Concise => render::render_concise(&problems, sources),
                Form::Json => json::lines(&problems, sources),
                Form::Human | Form::Ipc | Form::Gltf | Form::Csv | Form::Ros | Form::Moveit | Form::Dot => {
                    render::render(&problems, sources, output::stderr_has_colors())
                }
            };
            if to == To::Output && matches!(self.format, Form::Concise | Form::Json) {
                print(&text)?;
            } else {
                say(&text);
            }
        }
        let value = value.filter(|_| !problems.has_errors());
        value.ok_or(Failure::Code(code::PROBLEMS))
    }
}
