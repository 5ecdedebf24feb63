//! The page of `report::html`: what is in the file, and what it shows in a real browser.
//!
//! The browser tests need `chromium` in the PATH and say that they are skipped where it is not.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]
#![expect(clippy::unwrap_used, reason = "a test says by a panic what is wrong")]
#![expect(clippy::disallowed_methods, reason = "a browser that hangs is ended by the clock")]

#[path = "view/browser.rs"]
mod browser;
#[path = "view/small_world.rs"]
mod small_world;

use serde_json::{Value, json};
use sgap::{geom::Pose, plan::PoseDocument, report::html, world::World};

use browser::{Graphics, open};
use small_world::{FOREARM, RIGHT_FINGER, box_pose, link_poses, pick_and_place, placed_box, small_world};

fn page_with_plan() -> String {
    let (scene, start) = small_world();
    html::page(&scene, &start, Some(&pick_and_place()), "small world")
}

/// Returns the text of the element with that id in the page's source.
fn data<'a>(page: &'a str, id: &str) -> &'a str {
    let (_, rest) = page.split_once(&format!("id=\"{id}\">")).unwrap();
    rest.split_once("</script>").unwrap().0
}

fn pose(document: &Value) -> Pose {
    serde_json::from_value::<PoseDocument>(document.clone()).unwrap().pose()
}

/// Panics when the two are more than a nanometre or a nanoradian apart (a quaternion and its negative are the same turn).
#[track_caller]
fn assert_same(shown: &Value, expected: &Pose, what: &str) {
    let shown = pose(shown);
    let apart = (shown.translation.vector - expected.translation.vector).norm();
    let turned = 2.0 * (shown.rotation.inverse() * expected.rotation).imag().norm();
    assert!(apart < 1e-9 && turned < 1e-9, "{what}: {shown} is not {expected}");
}

#[test]
fn the_page_loads_nothing() {
    let page = page_with_plan();
    // three.js is packed, so every address that a browser would see is in plain sight here.
    for word in ["http:", "https:", "src=", "@import", "url(", "import(", "fetch("] {
        assert!(!page.contains(word), "the page contains `{word}`");
    }
    let links: Vec<_> = page
        .split("href=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap())
        .collect();
    assert_eq!(links, ["data:,"]);
    assert!(page.contains("default-src 'none'"));
    assert!(data(&page, "three-license").contains("The MIT License"));
    assert!(!page.contains("{{"), "a place of the template was left empty");
}

#[test]
fn the_page_holds_the_plan_as_it_is() {
    let plan: sgap::plan::Plan = serde_json::from_str(data(&page_with_plan(), "plan-data")).unwrap();
    assert_eq!(plan, pick_and_place());
    let (scene, start) = small_world();
    assert_eq!(data(&html::page(&scene, &start, None, "x"), "plan-data"), "null");
}

#[test]
fn hostile_names_stay_text() {
    let hostile = "</script><script>alert(1)</script><!-- {{three}} \"&";
    let (mut scene, start) = small_world();
    scene.objects[1].id = hostile.into();
    let page = html::page(&scene, &start, None, hostile);
    assert_eq!(page.matches("<script>").count(), 1);
    assert!(!page.contains("<!--"));
    let document: Value = serde_json::from_str(data(&page, "scene-data")).unwrap();
    assert_eq!(document["objects"][1]["id"], hostile);
    assert!(
        page.contains("<h1>&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;!-- {{three}} &quot;&amp;</h1>")
    );
}

#[test]
fn same_world_same_bytes() {
    assert_eq!(page_with_plan(), page_with_plan());
}

/// Reports, at each of `TIMES`, the poses of the box, of the forearm (which carries the tool) and of the mirrored finger,
/// and what the page says is going on.
const WATCH: &str = r##"
    const text = (selector) => [...document.querySelectorAll(selector)].map((e) => e.textContent);
    return TIMES.map((t) => {
        sgap.setTime(t);
        return { box: sgap.objectPose("BOX"), forearm: sgap.linkPose("ARM", "forearm"), finger: sgap.linkPose("ARM", "right_finger"),
                 now: text("#now")[0], current: text("#list [aria-current] .what") };
    });"##;

/// An instant of the plan of `small_world.rs`: time, shoulder, elbow, finger, whether the box is in the hand, what goes on.
type Instant = (f64, f64, f64, f64, bool, &'static str);

const INSTANTS: [Instant; 9] = [
    (0.0, 0.0, 0.0, 0.04, false, "Pick(ARM, BOX) · approach"),
    (0.4, 0.0, 0.24, 0.04, false, "Pick(ARM, BOX) · approach"),
    (1.0, 0.0, 0.6, 0.04, false, "Pick(ARM, BOX) · grasp"),
    (1.35, 0.0, 0.6, 0.026, false, "Pick(ARM, BOX) · grasp"),
    // The first action is over at 1.5 s, the second begins at 2.5 s.
    (2.0, 0.0, 0.6, 0.02, true, ""),
    (3.25, 0.4, 0.3, 0.02, true, "Place(ARM, BOX, TABLE) · approach"),
    (4.0, 0.8, 0.6, 0.02, false, "Place(ARM, BOX, TABLE) · release"),
    (4.1, 0.8, 0.6, 0.024, false, "Place(ARM, BOX, TABLE) · release"),
    // After the end (4.5 s) everything stays.
    (9.0, 0.8, 0.6, 0.04, false, "Place(ARM, BOX, TABLE) · release"),
];

#[test]
fn the_page_shows_what_the_plan_says() {
    let times: Vec<f64> = INSTANTS.iter().map(|instant| instant.0).collect();
    let script = WATCH.replace("TIMES", &format!("{times:?}"));
    let Some(report) = open(&page_with_plan(), "", Graphics::Software, &script) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    for (i, (t, shoulder, elbow, finger, held, words)) in INSTANTS.into_iter().enumerate() {
        let shown = &report.value[i];
        let X_WL = link_poses(shoulder, elbow, finger);
        assert_same(&shown["forearm"], &X_WL[FOREARM], &format!("forearm at {t} s"));
        assert_same(&shown["finger"], &X_WL[RIGHT_FINGER], &format!("finger at {t} s"));
        let X_WO = match (held, t < 2.0) {
            // Grasped at (0, 0.6), and fixed to the forearm from then on.
            (true, _) => X_WL[FOREARM] * link_poses(0.0, 0.6, 0.0)[FOREARM].inverse() * box_pose(0.0, 0.6),
            (false, true) => box_pose(0.0, 0.6),
            (false, false) => placed_box(),
        };
        assert_same(&shown["box"], &X_WO, &format!("box at {t} s"));
        assert_eq!(shown["now"], words, "at {t} s");
        let current: Vec<&str> = words
            .split(" · ")
            .next()
            .filter(|w| !w.is_empty())
            .into_iter()
            .collect();
        assert_eq!(shown["current"], json!(current), "at {t} s");
    }
}

#[test]
fn controls_move_the_time() {
    let script = r##"
        const time = () => Math.round(1000 * document.getElementById("time").value) / 1000;
        const press = (key, shiftKey = false) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey, bubbles: true, cancelable: true }));
        const play = document.getElementById("play");
        const seen = { duration: sgap.duration, address: time(), paused: play.getAttribute("aria-pressed") };
        press("ArrowLeft"); seen.left = time();
        press("ArrowRight", true); seen.right = time();
        press("End"); seen.end = time();
        press("ArrowRight"); seen.past = time();
        press("Home"); seen.home = time();
        document.querySelectorAll("#list button")[1].click(); seen.second = time();
        press(" "); seen.playing = play.getAttribute("aria-label");
        play.click(); seen.stopped = play.getAttribute("aria-label");
        const gl = document.getElementById("canvas").getContext("webgl2");
        seen.faults = gl ? gl.getError() : 0;
        seen.unnamed = [...document.querySelectorAll("button, input, select")]
            .filter((e) => !(e.ariaLabel || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).map((e) => e.id);
        return seen;"##;
    let Some(report) = open(&page_with_plan(), "#t=3.2", Graphics::Software, script) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    let expected = json!({
        "duration": 4.5, "address": 3.2, "paused": "false", "left": 3.1, "right": 4.1, "end": 4.5, "past": 4.5, "home": 0,
        "second": 2.5, "playing": "Pause", "stopped": "Play", "faults": 0, "unnamed": [],
    });
    assert_eq!(report.value, expected);
}

#[test]
fn lanes_tree_and_details_follow_the_time() {
    let script = r##"
        const text = (selector) => [...document.querySelectorAll(selector)].map((e) => e.textContent);
        const facts = () => Object.fromEntries(text("#facts dt").map((name, i) => [name, text("#facts dd")[i]]));
        const seen = { lanes: text("#lane-names li"), bars: text(".bar"), tree: text("#tree .what"), waits: document.querySelectorAll(".wait").length };
        const [first, second] = document.querySelectorAll(".bar");
        seen.left = second.style.left;
        second.click();
        seen.current = [text(".bar[aria-current]"), text("#tree [aria-current] b"), text("#list [aria-current] b")].flat();
        seen.title = text("#details-title")[0];
        seen.facts = facts();
        seen.head = document.querySelector(".head").style.left;
        document.querySelector("#tree button").click(); // closes the root
        seen.open = [...document.querySelectorAll("#tree li")].filter((row) => !row.hidden).length;
        document.getElementById("tab-tree").click();
        seen.shown = [document.getElementById("list").hidden, document.getElementById("tree").hidden];
        return seen;"##;
    let Some(report) = open(&page_with_plan(), "", Graphics::Software, script) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    // 2.5 s of 4.5 s, as the browser rounds it.
    let second = "55.5556%";
    let facts = json!({ "who": "ARM", "when": "2.50 – 4.50 s, lasts 2 to 2 s", "hand": "only, grasp side",
        "solution": "the first", "cost": "1" });
    assert_eq!(
        report.value,
        json!({
            "lanes": ["ARM"], "bars": ["Pick", "Place"], "waits": 1, "left": second, "head": second,
            "tree": ["Move(ARM, BOX) way 1", "Pick(ARM, BOX)", "Place(ARM, BOX)"],
            "current": ["Place", "Place", "Place"], "title": "Place(ARM, BOX, TABLE)", "facts": facts, "open": 1,
            "shown": [true, false],
        })
    );
}

const MESSAGE: &str = r##"
    const box = document.getElementById("message");
    return { message: box.hidden ? "" : box.textContent, player: !document.getElementById("player").hidden,
             list: [...document.querySelectorAll("#list .what")].map((e) => e.textContent), box: sgap.objectPose("BOX") };"##;

#[test]
fn a_world_alone_has_no_player() {
    let (scene, start) = small_world();
    let page = html::page(&scene, &start, None, "small world");
    let Some(report) = open(&page, "", Graphics::Software, MESSAGE) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    assert_eq!(report.value["message"], "");
    assert_eq!(report.value["player"], false);
    assert_eq!(report.value["list"], json!(["ARM", "TABLE", "BOX"]));
    assert_same(&report.value["box"], &start.objects[1].X_WO, "box");
}

#[test]
fn a_plan_on_symbols_alone_has_lanes_and_no_picture() {
    let World { scene, start, .. } = World::empty();
    let mut plan = pick_and_place();
    plan.actions.iter_mut().for_each(|action| action.geometry = None);
    let page = html::page(&scene, &start, Some(&plan), "symbols");
    assert_eq!(data(&page, "three-data"), "");
    let script = r##"
        document.querySelectorAll(".bar")[1].click();
        return { picture: !document.getElementById("view").hidden, message: document.getElementById("message").textContent,
                 duration: sgap.duration, current: document.querySelector("#list [aria-current] .what").textContent };"##;
    let Some(report) = open(&page, "", Graphics::Software, script) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    let expected = json!({ "picture": false, "message": "", "duration": 4.5, "current": "Place(ARM, BOX, TABLE)" });
    assert_eq!(report.value, expected);
}

#[test]
fn without_webgl_the_page_says_so() {
    let Some(report) = open(&page_with_plan(), "", Graphics::None, MESSAGE) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    let message = report.value["message"].as_str().unwrap();
    assert!(message.starts_with("This browser has no WebGL 2"), "{message}");
    assert_eq!(
        report.value["list"],
        json!(["Pick(ARM, BOX)", "Place(ARM, BOX, TABLE)"])
    );
}

#[test]
fn a_plan_of_another_world_is_named() {
    let (mut scene, start) = small_world();
    scene.objects[1].id = "CUP".into();
    let page = html::page(&scene, &start, Some(&pick_and_place()), "small world");
    let script = r#"return document.getElementById("message").textContent;"#;
    let Some(report) = open(&page, "", Graphics::Software, script) else {
        return;
    };
    assert_eq!(report.complaints, [""; 0]);
    let message = report.value.as_str().unwrap();
    assert!(message.contains("BOX"), "{message}");
}
