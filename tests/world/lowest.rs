//! How high an agent stands, from the shapes of its links.

use sgap::geom::{Vec3, shape::Shape};
use sgap::world::World;

/// Returns the height of the lowest point of an agent at the start [m].
pub fn lowest(world: &World, agent: usize) -> f64 {
    let (body, stands) = (&world.scene.agents[agent], &world.start.agents[agent]);
    let X_WL = body.tree.link_poses(&stands.X_WB, &stands.q);
    let heights = body.bodies.iter().map(|b| {
        let X_WS = X_WL[b.link] * b.X_LS;
        // Down, measured in the shape's frame.
        let down = X_WS.rotation.inverse() * -Vec3::z();
        let depth = match &b.shape {
            Shape::Box { half } => half.dot(&down.abs()),
            Shape::Sphere { radius } => *radius,
            Shape::Capsule { radius, half_length } => radius + half_length * down.z.abs(),
            Shape::Cylinder { radius, half_length } => radius * down.xy().norm() + half_length * down.z.abs(),
            Shape::Hull(hull) => hull
                .vertices
                .iter()
                .map(|p| p.dot(&down))
                .fold(f64::NEG_INFINITY, f64::max),
        };
        X_WS.translation.z - depth
    });
    heights.fold(f64::INFINITY, f64::min)
}
