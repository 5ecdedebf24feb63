//! The models that ship: they stand on the floor, sit on a chair, and touch nothing in any of their postures.

use sgap::geom::{Pose, collide};
use sgap::world::{BaseKind, World, contacts};

use super::lowest::lowest;
use super::world;

#[test]
fn our_models_stand_on_the_floor() {
    for (path, agent, height) in [
        ("worlds/three_objects.toml", 0, 0.0),
        ("worlds/three_objects.toml", 1, 0.0),
        ("worlds/sitting.toml", 1, 0.0),
        ("worlds/humanoid.toml", 0, 0.0),
        // On the bench; and the arm hangs no lower than the legs.
        ("worlds/arm.toml", 0, 0.7),
        ("worlds/quadrotor.toml", 0, 1.08),
    ] {
        let lowest = lowest(&world(path), agent);
        assert!((lowest - height).abs() < 0.01, "{path}: {lowest}");
    }
}

/// Who sits has the pelvis on the chair and the soles on the floor (above), and goes nowhere.
#[test]
fn the_human_sits_on_the_chair() {
    let world = world("worlds/sitting.toml");
    let human = &world.scene.agents[1];
    assert_eq!((human.manner.is_sitting, human.base), (true, BaseKind::Fixed));
    let chair = world.scene.objects.iter().position(|o| o.id == "CHAIR").unwrap();
    let X_WL = human
        .tree
        .link_poses(&world.start.agents[1].X_WB, &world.start.agents[1].q);
    let seat = &world.scene.objects[chair].parts[0];
    let X_WSeat = world.start.objects[chair].X_WO * seat.X_OS;
    let gap = |link: &str| {
        let link = human.tree.links.iter().position(|l| l == link).unwrap();
        let bodies = human.bodies.iter().filter(|b| b.link == link);
        let to_seat = bodies.map(|b| {
            let (solid, X_WS) = (collide::Solid::new(&b.shape), X_WL[link] * b.X_LS);
            collide::distance(&solid, &X_WS, &collide::Solid::new(&seat.shape), &X_WSeat)
        });
        to_seat.fold(f64::INFINITY, f64::min)
    };
    for link in ["pelvis", "left_thigh", "right_thigh"] {
        assert!(
            (0.0..0.015).contains(&gap(link)),
            "{link} is {} m above the seat",
            gap(link)
        );
    }
}

#[test]
fn every_posture_of_the_models_is_free_of_collisions() {
    for path in [
        "worlds/three_objects.toml",
        "worlds/arm.toml",
        "worlds/humanoid.toml",
        "worlds/quadrotor.toml",
    ] {
        every_posture_is_free(world(path));
    }
}

fn every_posture_is_free(mut world: World) {
    // What is held at the start would not follow the hand here.
    world.start.objects.iter_mut().for_each(|o| o.held = None);
    for a in 0..world.scene.agents.len() {
        let start = world.start.clone();
        // Alone in the world, so that only the posture counts.
        world.start.agents[a].X_WB = Pose::translation(50.0, 0.0, 0.0);
        for (name, q) in world.scene.agents[a].postures.clone() {
            world.start.agents[a].q = q;
            let found = contacts(&world.scene, &world.start, 1e-6);
            assert!(found.is_empty(), "{name}: {found:?}");
        }
        world.start = start;
    }
}
