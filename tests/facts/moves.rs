//! Random moves of a world: things put elsewhere, taken and let go, arms, heads and bases that move.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use sgap::geom::{Pose, Vec3};
use sgap::world::{EntityRef, Held, Scene, State, World};

/// What a move changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Move {
    /// A thing stands elsewhere on some support.
    Put(usize),
    /// A thing is in a hand, there where the hand is.
    Take(usize),
    /// Some joints of an agent are elsewhere, with what it holds.
    Joints(usize),
    /// An agent is elsewhere on the floor, with what it holds.
    Base(usize),
}

/// Puts a thing that nobody holds at a random place of a random support that looks up, where no other thing's middle is near.
pub fn put(world: &World, state: &mut State, rng: &mut ChaCha8Rng) -> Option<Move> {
    let scene = &world.scene;
    let movable = |o: &usize| {
        scene.objects[*o].movable && !scene.objects[*o].stable.is_empty() && state.objects[*o].held.is_none()
    };
    let things: Vec<usize> = (0..scene.objects.len()).filter(movable).collect();
    let thing = *things.get(rng.random_range(0..things.len().max(1)))?;
    let below: Vec<usize> = (0..scene.objects.len())
        .filter(|o| !scene.objects[*o].movable && !scene.objects[*o].supports.is_empty())
        .collect();
    for _ in 0..200 {
        let on = below[rng.random_range(0..below.len())];
        let face = &scene.objects[on].supports[rng.random_range(0..scene.objects[on].supports.len())];
        let stable = &scene.objects[thing].stable[0];
        let at = |half: f64, u: f64| (half - 0.06).max(0.0) * (2.0 * u - 1.0);
        let (x, y) = (at(face.half[0], rng.random()), at(face.half[1], rng.random()));
        let X_FQ = Pose::new(Vec3::new(x, y, 0.0), Vec3::z() * rng.random_range(-3.0..3.0));
        let X_WO = state.objects[on].X_WO * face.X_OF * X_FQ * stable.X_QO;
        let is_far = |o: usize| (state.objects[o].X_WO.translation.vector - X_WO.translation.vector).norm() > 0.14;
        if (0..scene.objects.len())
            .filter(|o| *o != thing && scene.objects[*o].movable)
            .all(is_far)
        {
            state.objects[thing].X_WO = X_WO;
            return Some(Move::Put(thing));
        }
    }
    None
}

/// Carries what an agent holds along with its hands.
fn carry(scene: &Scene, state: &mut State, agent: usize) {
    let body = &scene.agents[agent];
    let X_WL = body.tree.link_poses(&state.agents[agent].X_WB, &state.agents[agent].q);
    for object in &mut state.objects {
        if let Some(held) = object.held.as_ref().filter(|h| h.agent == agent) {
            let arm = &body.arms[held.arm];
            object.X_WO = X_WL[arm.tip_link] * arm.X_LT * held.X_TO;
        }
    }
}

/// Makes one random move of any kind.
pub fn any(world: &World, state: &mut State, rng: &mut ChaCha8Rng) -> Option<Move> {
    let scene = &world.scene;
    let agent = rng.random_range(0..scene.agents.len());
    let done = match rng.random_range(0..6) {
        0 | 1 => return put(world, state, rng),
        2 => {
            // Takes something into an empty hand, or lets go what is in it.
            let arm = rng.random_range(0..scene.agents[agent].arms.len());
            let in_hand = |o: &usize| matches!(&state.objects[*o].held, Some(h) if h.agent == agent && h.arm == arm);
            if let Some(thing) = (0..state.objects.len()).find(in_hand) {
                state.objects[thing].held = None;
                return put(world, state, rng);
            }
            let movable = |o: &usize| scene.objects[*o].movable && state.objects[*o].held.is_none();
            let things: Vec<usize> = (0..scene.objects.len()).filter(movable).collect();
            let thing = *things.get(rng.random_range(0..things.len().max(1)))?;
            state.objects[thing].held = Some(Held {
                agent,
                arm,
                X_TO: Pose::translation(0.03, 0.0, 0.0),
            });
            Move::Take(thing)
        }
        3 => {
            let posture = scene.agents[agent].postures.get("rest").cloned();
            state.agents[agent].q = posture.unwrap_or_else(|| world.start.agents[agent].q.clone());
            Move::Joints(agent)
        }
        4 => {
            // A few joints: an arm's, or the head's.
            let dofs = &scene.agents[agent].tree.dofs;
            for _ in 0..3 {
                let i = rng.random_range(0..dofs.len());
                let (low, high) = (dofs[i].lower.max(-2.0), dofs[i].upper.min(2.0));
                state.agents[agent].q[i] = low + rng.random::<f64>() * (high - low);
            }
            Move::Joints(agent)
        }
        _ => {
            let by = Vec3::new(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1), 0.0);
            let turn = Vec3::z() * rng.random_range(-0.3..0.3);
            state.agents[agent].X_WB *= Pose::new(by, turn);
            Move::Base(agent)
        }
    };
    carry(scene, state, agent);
    Some(done)
}

/// Loads a world file of the package.
pub fn load(path: &str) -> World {
    let mut sources = sgap::source::Sources::default();
    let (world, problems) = sgap::world::load(path, &mut sources, &sgap::planner::Disk);
    world.unwrap_or_else(|| panic!("{}", sgap::diag::render::render(&problems, &sources, false)))
}

/// Returns the name of what was moved, for messages.
pub fn name(world: &World, done: Move) -> String {
    match done {
        Move::Put(o) | Move::Take(o) => world.scene.id(EntityRef::Object(o)).to_owned(),
        Move::Joints(a) | Move::Base(a) => world.scene.id(EntityRef::Agent(a)).to_owned(),
    }
}
