//! Convex shapes, each in its own frame S.

use std::sync::Arc;

use super::Vec3;
use super::hull::Hull;

/// A convex solid about its frame's origin; long axes along z (URDF's convention).
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Half of each side [m].
    Box {
        half: Vec3,
    },
    /// Axis along z [m].
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    Sphere {
        radius: f64,
    },
    /// Axis along z; `half_length` without the caps [m].
    Capsule {
        radius: f64,
        half_length: f64,
    },
    /// Of a mesh. Shared: a mesh is named by many links.
    Hull(Arc<Hull>),
}

impl Shape {
    /// Returns the radius of the sphere about the frame's origin that contains the shape [m].
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Shape::Box { half } => half.norm(),
            Shape::Cylinder { radius, half_length } => (radius * radius + half_length * half_length).sqrt(),
            Shape::Sphere { radius } => *radius,
            Shape::Capsule { radius, half_length } => radius + half_length,
            Shape::Hull(hull) => hull.vertices.iter().map(Vec3::norm).fold(0.0, f64::max),
        }
    }

    /// Returns the volume [m^3].
    pub fn volume(&self) -> f64 {
        use std::f64::consts::PI;
        match self {
            Shape::Box { half } => 8.0 * half.x * half.y * half.z,
            Shape::Cylinder { radius, half_length } => 2.0 * PI * radius * radius * half_length,
            Shape::Sphere { radius } => 4.0 / 3.0 * PI * radius.powi(3),
            Shape::Capsule { radius, half_length } => {
                2.0 * PI * radius * radius * half_length + 4.0 / 3.0 * PI * radius.powi(3)
            }
            Shape::Hull(hull) => hull.volume(),
        }
    }

    /// Returns the centre of volume, measured in the shape's frame [m].
    pub fn centre(&self) -> Vec3 {
        match self {
            Shape::Box { .. } | Shape::Cylinder { .. } | Shape::Sphere { .. } | Shape::Capsule { .. } => Vec3::zeros(),
            Shape::Hull(hull) => hull.centre(),
        }
    }

    /// Returns half of the sides of the box about the shape with its middle at the origin, aligned with its own axes [m].
    pub fn half_extents(&self) -> Vec3 {
        match self {
            Shape::Box { half } => *half,
            Shape::Cylinder { radius, half_length } => Vec3::new(*radius, *radius, *half_length),
            Shape::Sphere { radius } => Vec3::new(*radius, *radius, *radius),
            Shape::Capsule { radius, half_length } => Vec3::new(*radius, *radius, half_length + radius),
            Shape::Hull(hull) => hull.half_extents(),
        }
    }
}
