//! A page as a picture, by a browser that is installed.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use super::output::Failure;

/// Names of Chromium and what is made of it.
const BROWSERS: [&str; 5] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
];
/// Longest wait for the picture, and how often it is looked for.
const LONGEST: Duration = Duration::from_secs(120);
const LOOK: Duration = Duration::from_millis(50);

/// Writes what `page` shows at `t` [s] to `target` as PNG, 1280 x 800.
pub(super) fn write(page: &str, t: f64, target: &Path) -> Result<(), Failure> {
    let browser = find().ok_or_else(|| {
        let why = "no browser in the PATH can draw it: install chromium, or open the page and take a picture there";
        unwritable(target, why)
    })?;
    let folder = tempfile::tempdir().map_err(|e| unwritable(target, &format!("no temporary folder: {e}")))?;
    let (html, picture) = (folder.path().join("page.html"), folder.path().join("picture.png"));
    std::fs::write(&html, page).map_err(|e| unwritable(target, &format!("no temporary page: {}", e.kind())))?;
    let mut command = Command::new(browser);
    command.args([
        "--headless=new",
        "--no-sandbox",
        "--use-gl=angle",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
        "--hide-scrollbars",
        "--window-size=1280,887",
        "--virtual-time-budget=4000",
        "--disable-background-networking",
        "--no-first-run",
    ]);
    let argument = |name: &str, path: &Path| {
        let mut argument = OsString::from(name);
        argument.push(path);
        argument
    };
    command.arg(argument("--user-data-dir=", &folder.path().join("profile")));
    command.arg(argument("--screenshot=", &picture));
    let mut address = argument("file://", &html);
    address.push(format!("#t={t}"));
    command.arg(address).stdout(Stdio::null()).stderr(Stdio::null());
    run(&mut command).map_err(|why| unwritable(target, &why))?;
    // A rename would not cross file systems.
    std::fs::copy(&picture, target).map_err(|e| match picture.exists() {
        true => unwritable(target, &e.kind().to_string()),
        false => unwritable(target, "the browser drew nothing"),
    })?;
    Ok(())
}

fn run(command: &mut Command) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("the browser can't be run: {}", e.kind());
    let mut child = command.spawn().map_err(failed)?;
    for _ in 0..LONGEST.as_millis() / LOOK.as_millis() {
        if child.try_wait().map_err(failed)?.is_some() {
            return Ok(());
        }
        std::thread::sleep(LOOK);
    }
    let _ = child.kill();
    let _ = child.wait();
    Err(format!("the browser did not end within {} s", LONGEST.as_secs()))
}

fn find() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .flat_map(|folder| BROWSERS.map(|name| folder.join(name)))
        .find(|file| file.is_file())
}

fn unwritable(path: &Path, why: &str) -> Failure {
    Failure::Output(format!("can't write `{}`: {why}", path.display()))
}
