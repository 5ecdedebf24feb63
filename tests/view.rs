//! The page of `report::html`: what is in the file, and what it shows in a real browser.
//!
//! The browser tests need `chromium` in the PATH and say that they are skipped where it is not.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

#[path = "view/browser.rs"]
mod browser;
#[path = "view/small_world.rs"]
mod small_world;

use serde_json::Value;
use sgap::{geom::Pose, plan::PoseDocument, report::html};

use browser::{Graphics, open};
use small_world::{pick_and_place, small_world, tool_pose};

/// What the page's script reports: `at` time, the pose of the box, of the hand and of the mirrored finger.
const POSES: &str = r#"
    const report = { duration: sgap.duration, address: Number(document.getElementById("time").value), at: [] };
    for (const t of [0, 0.4, 1.0, 1.35, 2.0, 3.25, 4.1, 5.0]) {
        sgap.setTime(t);
        report.at.push({ t, box: sgap.objectPose("BOX"), hand: sgap.linkPose("ARM", "forearm"), finger: sgap.linkPose("ARM", "right_finger"),
                         now: document.getElementById("now").textContent,
                         current: [...document.querySelectorAll("#list [aria-current] b")].map((b) => b.textContent) });
    }
    return report;"#;

/// The same instants, as the plan in `small_world.rs` puts them: time, shoulder, elbow, gap of one finger, held, words shown.
type Instant = (f64, f64, f64, f64, bool, &'static str);
const INSTANTS: [Instant; 8] = [
    (0.0, 0.0, 0.0, 0.04, false, "Pick(ARM, BOX) · approach"),
    (0.4, 0.0, 0.24, 0.04, false, "Pick(ARM, BOX) · approach"),
    (1.0, 0.0, 0.6, 0.04, false, "Pick(ARM, BOX) · grasp"),
    (1.35, 0.0, 0.6, 0.026, false, "Pick(ARM, BOX) · grasp"),
    // The action is over at 1.5 s and the next begins at 2.5 s.
    (2.0, 0.0, 0.6, 0.02, true, ""),
    (3.25, 0.4, 0.3, 0.02, true, "Place(ARM, BOX, TABLE) · approach"),
    (4.1, 0.8, 0.6, 0.024, false, "Place(ARM, BOX, TABLE) · release"),
    (5.0, 0.8, 0.6, 0.04, false, "Place(ARM, BOX, TABLE) · release"),
];
