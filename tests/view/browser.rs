//! Runs a page in headless Chromium and hands back what a script in it reports.

use std::{
    fs::{self, File},
    path::PathBuf,
    process::{Command, Stdio},
    time::{Duration, Instant},
};

use serde_json::Value;

/// Whether the browser may draw in 3D (in software, so that no graphics card is needed).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Graphics {
    Software,
    None,
}

/// What the page reported.
#[derive(Debug)]
pub struct Report {
    /// What the script returned.
    pub value: Value,
    /// Uncaught errors, and `console.error` and `console.warn` calls.
    pub complaints: Vec<String>,
}

/// Runs before the page's own script: collects complaints.
const LISTEN: &str = r#"<script>
    globalThis.complaints = [];
    for (const level of ["error", "warn"]) console[level] = (...words) => complaints.push(words.join(" "));
    addEventListener("error", (event) => complaints.push(event.message));
    addEventListener("unhandledrejection", (event) => complaints.push(String(event.reason)));
    addEventListener("securitypolicyviolation", (event) => complaints.push("load of " + event.blockedURI));
</script>"#;

/// Opens the page at `#address`, runs the body of a function once it is ready, and returns what it returned;
/// `None` (and a word on stderr) where there is no Chromium.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
pub fn open(page: &str, address: &str, graphics: Graphics, script: &str) -> Option<Report> {
    let Some(chromium) = find_chromium() else {
        eprintln!("skipped: no chromium in the PATH");
        return None;
    };
    let folder = tempfile::tempdir().unwrap();
    let report = format!(
        r#"<script>addEventListener("sgap-ready", () => {{
            const value = (() => {{ {script} }})();
            const report = document.createElement("pre");
            report.id = "report";
            report.textContent = encodeURIComponent(JSON.stringify({{ value, complaints }}));
            document.body.append(report);
        }});</script>"#
    );
    let page =
        page.replacen("<head>", &format!("<head>{LISTEN}"), 1)
            .replacen("</head>", &format!("{report}</head>"), 1);
    let (html, dom) = (folder.path().join("page.html"), folder.path().join("dom.html"));
    fs::write(&html, page).unwrap();

    let mut command = Command::new(chromium);
    command.args([
        "--headless=new",
        "--no-sandbox",
        "--hide-scrollbars",
        "--window-size=1280,887",
        "--virtual-time-budget=4000",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--no-first-run",
        "--dump-dom",
    ]);
    command.args(match graphics {
        Graphics::Software => vec![
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ],
        Graphics::None => vec!["--disable-gpu", "--disable-3d-apis"],
    });
    command.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
    command.arg(format!("file://{}{address}", html.display()));
    // Not pipes: nobody reads them while we wait.
    command.stdout(File::create(&dom).unwrap()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("chromium did not end within two minutes");
        }
        std::thread::sleep(Duration::from_millis(50));
    }

    let dom = fs::read_to_string(&dom).unwrap();
    let (_, rest) = dom
        .split_once("<pre id=\"report\">")
        .expect("the page never became ready");
    let (coded, _) = rest.split_once("</pre>").unwrap();
    let mut parts: Value = serde_json::from_str(&percent_decode(coded)).unwrap();
    let complaints = parts["complaints"].as_array().unwrap();
    Some(Report {
        complaints: complaints.iter().map(|c| c.as_str().unwrap().to_owned()).collect(),
        value: parts["value"].take(),
    })
}

fn find_chromium() -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .flat_map(|folder| ["chromium", "chromium-browser"].map(|name| folder.join(name)))
        .find(|file| file.is_file())
}

/// The inverse of JavaScript's `encodeURIComponent`, which keeps the report clear of HTML's own escapes.
fn percent_decode(coded: &str) -> String {
    let mut pieces = coded.split('%');
    let mut bytes = pieces.next().unwrap().as_bytes().to_vec();
    for piece in pieces {
        bytes.push(u8::from_str_radix(&piece[..2], 16).unwrap());
        bytes.extend_from_slice(&piece.as_bytes()[2..]);
    }
    String::from_utf8(bytes).unwrap()
}
