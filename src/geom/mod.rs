//! Pure functions of shapes, poses and configurations; knows nothing of worlds, agents or tasks.
//!
//! Poses in monogram notation (`docs/notation.md`): `X_AB` is the pose of frame B in frame A. Metres, radians, seconds.

pub mod checker;
pub mod collide;
pub mod cover;
pub mod hull;
pub mod ik;
pub mod kinematics;
pub mod mesh;
pub mod motion;
pub mod navigation;
pub mod shape;
pub mod sight;

/// A rigid transform; `X_AB * p_BQ` is `p_AQ`.
pub type Pose = nalgebra::Isometry3<f64>;
/// A point or a direction [m].
pub type Vec3 = nalgebra::Vector3<f64>;

/// Returns the pose with translation `xyz` [m] and fixed-axis roll, pitch, yaw `rpy` [rad] (URDF's convention).
pub fn pose_xyz_rpy(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    Pose::from_parts(
        nalgebra::Translation3::new(xyz[0], xyz[1], xyz[2]),
        nalgebra::UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]),
    )
}
