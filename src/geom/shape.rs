//! Convex shapes, each in its own frame S.

use super::Vec3;

/// A convex solid, centred on its frame's origin; long axes along z (URDF's convention).
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
}

impl Shape {
    /// Returns the radius of the sphere about the frame's origin that contains the shape [m].
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Shape::Box { half } => half.norm(),
            Shape::Cylinder { radius, half_length } => (radius * radius + half_length * half_length).sqrt(),
            Shape::Sphere { radius } => *radius,
            Shape::Capsule { radius, half_length } => radius + half_length,
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
        }
    }

    /// Returns half of the sides of the box about the shape, aligned with its own axes [m].
    pub fn half_extents(&self) -> Vec3 {
        match self {
            Shape::Box { half } => *half,
            Shape::Cylinder { radius, half_length } => Vec3::new(*radius, *radius, *half_length),
            Shape::Sphere { radius } => Vec3::new(*radius, *radius, *radius),
            Shape::Capsule { radius, half_length } => Vec3::new(*radius, *radius, half_length + radius),
        }
    }
}
