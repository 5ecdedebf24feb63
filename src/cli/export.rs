//! Plans and worlds in the forms of other people's tools.

use super::code;
use super::output::{Failure, say};
use super::problems::Form;
use sgap::plan::Plan;
use sgap::report::{csv, dot, gltf, moveit, ros};
use sgap::world::World;

/// A form that this file writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Export {
    Gltf,
    Csv,
    Ros,
    Moveit,
    Dot,
}

impl Form {
    /// Returns the form of the answer that this asks for, if it is one.
    pub(super) fn export(self) -> Option<Export> {
        match self {
            Form::Human | Form::Concise | Form::Json | Form::Ipc => None,
            Form::Gltf => Some(Export::Gltf),
            Form::Csv => Some(Export::Csv),
            Form::Ros => Some(Export::Ros),
            Form::Moveit => Some(Export::Moveit),
            Form::Dot => Some(Export::Dot),
        }
    }
}

impl Form {
    /// Returns why the command of that name can't write its answer in this form; `None` if it can.
    pub(super) fn refused_by(self, command: &str) -> Option<&'static str> {
        match (self, self.export()) {
            (Form::Ipc, _) if command != "plan" => {
                Some("only `sgap plan` of a pair of HDDL files has a plan to write with `--format ipc`\n")
            }
            (_, Some(_)) if !["plan", "view"].contains(&command) => {
                Some("only `sgap plan` and `sgap view` write this form\n")
            }
            _ => None,
        }
    }
}

/// Returns the text of a world, or of a plan in it; `title` names what it came from.
pub(super) fn text(export: Export, world: &World, plan: Option<&Plan>, title: &str) -> Result<String, Failure> {
    let wrong = |why: &str| {
        say(&format!("error: {why}\n"));
        Failure::Code(code::WRONG_USAGE)
    };
    let plan_of = |form: &str| {
        let moves = |plan: &&Plan| plan.actions.iter().any(|a| a.geometry.is_some());
        match plan {
            Some(plan) if moves(&plan) => Ok(plan),
            Some(_) => Err(wrong(&format!(
                "nothing moves in this plan, so `--format {form}` has nothing to write"
            ))),
            None => Err(wrong(&format!(
                "`--format {form}` writes the motions of a plan: name a domain, or a plan, besides the world"
            ))),
        }
    };
    match export {
        Export::Gltf if world.scene.agents.is_empty() && world.scene.objects.is_empty() => Err(wrong(
            "there is no world, so `--format gltf` has nothing to write: name a world file",
        )),
        Export::Gltf => Ok(gltf::write(&world.scene, &world.start, plan)),
        Export::Csv => plan_of("csv").map(csv::write),
        Export::Ros => plan_of("ros").map(ros::write),
        Export::Moveit => moveit::write(&world.scene, &world.start, title)
            .ok_or_else(|| wrong("there is no robot in this world, so `--format moveit` has nothing to write")),
        Export::Dot => match plan {
            Some(plan) => Ok(dot::write(plan)),
            None => Err(wrong(
                "`--format dot` writes the tree of a plan: name a domain, or a plan, besides the world",
            )),
        },
    }
}
