//! A world with the domain that names its entities, and short ways to ask the reasoner.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use sgap::diag::render;
use sgap::engine::{Call, Formula, Projection, Reasoner, Request};
use sgap::geom::Pose;
use sgap::grp::{Fact, Grp, Settings};
use sgap::ir::{Domain, Value};
use sgap::load::{Input, load};
use sgap::plan::ActionRefusal;
use sgap::source::{Files, Sources};
use sgap::world::{EntityRef, Held, World};

/// The package's files, and one world in memory.
struct InMemory(BTreeMap<&'static str, String>);

impl Files for InMemory {
    fn read(&self, path: &str) -> Result<String, String> {
        match self.0.get(path) {
            Some(text) => Ok(text.clone()),
            None => std::fs::read_to_string(path).map_err(|e| e.to_string()),
        }
    }
}

/// A small table ahead of the robot, 0.75 m high; its top reaches 0.2 m from its middle along x, 0.4 m along y.
pub const TABLE: &str = r#"
[objects.TABLE]
type = "Support"
movable = false
box = [0.4, 0.8, 0.75]
xyz = [0.75, 0, 0.375]
"#;

/// On the table, within reach of the robot's right arm.
pub const CUBE: &str = r#"
[objects.CUBE]
type = "Object"
box = [0.06, 0.06, 0.06]
on = "TABLE"
at = [-0.1, -0.2]
"#;

pub const ROBOT: &str = r#"
[robots.PR2]
model = "models/pr2.toml"
"#;

/// Opposite the robot, looking at it.
pub const HUMAN: &str = r#"
[humans.BOB]
model = "models/human.toml"
base = { x = 1.25, y = 0, yaw = 3.141592653589793 }
"#;

pub struct Case {
    pub domain: Domain,
    pub world: World,
}

impl Case {
    /// Loads a world of the package.
    pub fn shipped(path: &str) -> Case {
        Case::load(path, InMemory(BTreeMap::new()))
    }

    /// Loads a world made of these pieces of TOML.
    pub fn of(pieces: &[&str]) -> Case {
        let path = "worlds/case.toml";
        Case::load(path, InMemory(BTreeMap::from([(path, pieces.concat())])))
    }

    /// Loads such a world whose robot has this model; its URDF is `models/pr2.urdf`.
    pub fn with_model(model: &str, pieces: &[&str]) -> Case {
        let path = "worlds/case.toml";
        let robot = "[robots.PR2]\nmodel = \"model.toml\"\n";
        let files = BTreeMap::from([
            (path, robot.to_owned() + &pieces.concat()),
            ("worlds/model.toml", model.to_owned()),
        ]);
        Case::load(path, InMemory(files))
    }

    fn load(path: &str, files: InMemory) -> Case {
        let mut sources = Sources::default();
        let (input, problems) = load("domains/three_objects.hatp", path, None, &mut sources, &files);
        let Some(Input { domain, world, .. }) = input else {
            panic!("{}", render::render(&problems, &sources, false));
        };
        Case { domain, world }
    }

    pub fn grp(&self, seed: u64) -> Grp<'_> {
        self.grp_with(seed, Arc::new(AtomicBool::new(false)))
    }

    pub fn grp_with(&self, seed: u64, stop: Arc<AtomicBool>) -> Grp<'_> {
        let settings = Settings {
            placements: 200,
            ik_restarts: 8,
            motion_samples: 3000,
        };
        Grp::new(&self.world, settings, seed, stop).unwrap()
    }

    pub fn object(&self, name: &str) -> usize {
        match self.world.scene.find(name) {
            Some(EntityRef::Object(o)) => o,
            other => panic!("{name} is {other:?}"),
        }
    }

    pub fn agent(&self, name: &str) -> usize {
        match self.world.scene.find(name) {
            Some(EntityRef::Agent(a)) => a,
            other => panic!("{name} is {other:?}"),
        }
    }

    pub fn on(&self, a: &str, b: &str) -> Fact {
        let (a, b) = (self.object(a), self.object(b));
        Fact::IsOn { a, b }
    }

    pub fn in_hand(&self, agent: &str, object: &str) -> Fact {
        let (agent, object) = (self.agent(agent), self.object(object));
        Fact::HasInHand { agent, object }
    }

    pub fn reachable(&self, object: &str, agent: &str) -> Fact {
        let (agent, object) = (self.agent(agent), self.object(object));
        Fact::IsReachable { object, agent }
    }

    pub fn visible(&self, object: &str, agent: &str) -> Fact {
        let (agent, object) = (self.agent(agent), self.object(object));
        Fact::IsVisible { object, agent }
    }

    /// Says whether a fact holds at the start.
    pub fn holds(&self, fact: Fact) -> bool {
        self.grp(0).holds(fact)
    }

    pub fn X_WO(&mut self, object: &str) -> &mut Pose {
        let object = self.object(object);
        &mut self.world.start.objects[object].X_WO
    }

    /// Puts an object into a hand as it lies: it does not move.
    pub fn give(&mut self, object: &str, agent: &str, arm: usize) {
        let (object, agent) = (self.object(object), self.agent(agent));
        let X_WT = self.tool(agent, arm, &self.world.start.agents[agent].q);
        let thing = &mut self.world.start.objects[object];
        let X_TO = X_WT.inverse() * thing.X_WO;
        thing.held = Some(Held { agent, arm, X_TO });
    }

    /// Returns X_WT at a full configuration of the agent.
    pub fn tool(&self, agent: usize, arm: usize, q: &[f64]) -> Pose {
        let body = &self.world.scene.agents[agent];
        let arm = &body.arms[arm];
        body.tree.link_poses(&self.world.start.agents[agent].X_WB, q)[arm.tip_link] * arm.X_LT
    }

    /// Projects a call whose arguments are entities.
    pub fn project(&self, grp: &mut Grp<'_>, name: &str, args: &[&str]) -> Result<Projection, ActionRefusal> {
        let args: Vec<Value> = args
            .iter()
            .map(|a| Value::Entity(self.domain.entity(a).unwrap()))
            .collect();
        grp.project(
            &self.domain,
            &Call {
                name,
                args: &args,
                given: &[],
                constraints: &Formula::TRUE,
            },
        )
    }

    /// Asks a request or a fact about entities.
    pub fn ask(&self, grp: &mut Grp<'_>, name: &str, args: &[&str]) -> Option<Value> {
        let args: Vec<Value> = args.iter().map(|a| self.value(a)).collect();
        grp.request(&self.domain, &Request { name, args: &args })
    }

    /// Says what a request about the start answers: a truth value.
    pub fn says(&self, name: &str, args: &[&str]) -> Option<bool> {
        match self.ask(&mut self.grp(0), name, args)? {
            Value::Bool(b) => Some(b),
            other => panic!("{name} answers {other:?}"),
        }
    }

    pub fn value(&self, entity: &str) -> Value {
        Value::Entity(self.domain.entity(entity).unwrap())
    }

    /// Returns what a shared attribute of an entity says, as the language writes it.
    pub fn attribute(&self, grp: &mut Grp<'_>, entity: &str, name: &str) -> String {
        let slot = self.domain.slots.iter().find(|s| {
            self.domain.entities[s.entity.index()].name == entity
                && self.domain.attributes[s.attribute.index()].name == name
        });
        let slot = slot.unwrap();
        let value = grp.fact(&self.domain, slot.attribute, slot.entity);
        self.domain.show(&value)
    }
}
