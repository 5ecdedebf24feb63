//! Poses as a file writes them: `xyz`, and `rpy` or `yaw`.

use super::problems;
use super::table::Table;
use crate::diag::Problems;
use crate::geom::{Pose, pose_xyz_rpy};

/// The keys that [`read`] understands, for a table's list of keys.
pub const KEYS: [&str; 3] = ["xyz", "rpy", "yaw"];

/// No world is larger; a coordinate beyond it is in millimetres, or a slip [m].
pub const FARTHEST: f64 = 200.0;

/// No part of a thing is farther from its frame [m].
pub const LARGEST: f64 = 50.0;

/// Returns the pose in the world of `xyz` [m] and `rpy` [rad] (fixed axes, URDF's convention), or `yaw` [rad] alone; each is zero when
/// absent.
pub fn read(table: &Table<'_>, problems: &mut Problems) -> Pose {
    read_within(table, FARTHEST, problems)
}

/// Like [`read`], for a pose in the frame of an object or a link.
pub fn read_in_frame(table: &Table<'_>, problems: &mut Problems) -> Pose {
    read_within(table, LARGEST, problems)
}

fn read_within(table: &Table<'_>, farthest: f64, problems: &mut Problems) -> Pose {
    let xyz = match table.vector::<3>("xyz", problems) {
        Some((xyz, span)) => {
            if let Some(far) = xyz.iter().find(|v| v.abs() > farthest) {
                problems.push(problems::bad_size(
                    format!("{} is placed {} m away", table.place, far.abs()),
                    span,
                    format!("lengths are in metres: {} mm are {}", far.abs(), far.abs() / 1000.0),
                ));
            }
            xyz
        }
        None => [0.0; 3],
    };
    let rpy = table.vector::<3>("rpy", problems);
    let yaw = table.number("yaw", problems);
    if let (Some(_), Some((_, span))) = (&rpy, &yaw) {
        problems.push(problems::bad_value(
            format!("{} has both `rpy` and `yaw`", table.place),
            *span,
            "",
            "keep `rpy`; its third number is the yaw",
        ));
    }
    for (name, value, span) in rpy
        .iter()
        .flat_map(|(v, s)| v.iter().map(move |v| ("rpy", *v, *s)))
        .chain(yaw.iter().map(|(v, s)| ("yaw", *v, *s)))
    {
        angle_is_plausible(name, value, &table.place, span, problems);
    }
    let rpy = rpy.map_or([0.0, 0.0, yaw.map_or(0.0, |(y, _)| y)], |(v, _)| v);
    pose_xyz_rpy(xyz, rpy)
}

/// Returns `yaw` alone [rad]; zero when absent.
pub fn yaw(table: &Table<'_>, problems: &mut Problems) -> f64 {
    let Some((value, span)) = table.number("yaw", problems) else {
        return 0.0;
    };
    angle_is_plausible("yaw", value, &table.place, span, problems);
    value
}

/// Complains about an angle of more than two turns: it is in degrees.
fn angle_is_plausible(name: &str, value: f64, place: &str, span: crate::source::Span, problems: &mut Problems) {
    if value.abs() > 4.0 * std::f64::consts::PI {
        problems.push(problems::bad_value(
            format!("`{name}` of {place} turns by {value} rad"),
            span,
            "more than two turns",
            format!("angles are in radians: {value} degrees are {:.4}", value.to_radians()),
        ));
    }
}

/// Returns a color: a name, or red, green, blue and maybe alpha in [0, 1].
pub fn color(table: &Table<'_>, problems: &mut Problems) -> Option<[f32; 4]> {
    let value = table.get("color")?;
    let what = format!("`color` of {}", table.place);
    if let toml::de::DeValue::String(name) = value.value {
        let known = NAMED_COLORS.iter().find(|(n, _)| *n == name.as_ref());
        if known.is_none() {
            problems.push(problems::unknown_name(
                "world::unknown-color",
                "color",
                name,
                &table.place,
                NAMED_COLORS.iter().map(|(n, _)| *n),
                value.span,
            ));
        }
        return known.map(|(_, rgb)| scene_color(*rgb, 1.0));
    }
    let four = matches!(value.value, toml::de::DeValue::Array(a) if a.len() == 4);
    let rgba = if four {
        value.vector::<4>(&what, problems)?
    } else {
        let [r, g, b] = value.vector::<3>(&what, problems)?;
        [r, g, b, 1.0]
    };
    if rgba.iter().any(|c| !(0.0..=1.0).contains(c)) {
        problems.push(problems::bad_value(
            format!("{what} is not within 0 to 1"),
            value.span,
            "",
            "write red, green and blue from 0 to 1, or a name such as `\"red\"`",
        ));
        return None;
    }
    Some(scene_color([rgba[0], rgba[1], rgba[2]], rgba[3]))
}

/// The grey of things without a color.
pub const GREY: [f32; 4] = [0.62, 0.62, 0.62, 1.0];

fn scene_color(rgb: [f64; 3], alpha: f64) -> [f32; 4] {
    [rgb[0] as f32, rgb[1] as f32, rgb[2] as f32, alpha as f32]
}

const NAMED_COLORS: [(&str, [f64; 3]); 12] = [
    ("black", [0.1, 0.1, 0.1]),
    ("white", [0.95, 0.95, 0.95]),
    ("grey", [0.55, 0.55, 0.57]),
    ("red", [0.80, 0.18, 0.16]),
    ("orange", [0.93, 0.50, 0.13]),
    ("yellow", [0.93, 0.80, 0.22]),
    ("green", [0.25, 0.62, 0.29]),
    ("blue", [0.20, 0.40, 0.75]),
    ("purple", [0.50, 0.28, 0.62]),
    ("pink", [0.92, 0.56, 0.68]),
    ("brown", [0.48, 0.33, 0.20]),
    ("wood", [0.76, 0.60, 0.42]),
];
