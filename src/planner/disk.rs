//! Reads files. All other rooms see texts alone, through [`Files`].

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::source::Files;

/// The file system. A path is relative to the working directory of the program.
#[derive(Debug, Clone, Copy)]
pub struct Disk;

/// A domain, world or model file is never larger [bytes].
const LARGEST: u64 = 64 << 20;
/// A mesh file is never larger [bytes].
const LARGEST_MESH: u64 = 256 << 20;

/// Nor is a plan: ten million actions, at 800 bytes each.
const LARGEST_PLAN: u64 = 8 << 30;

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        text(path, LARGEST)
    }

    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        bytes(path, LARGEST_MESH)
    }

    fn packages(&self) -> Vec<String> {
        packages()
    }

    fn cached(&self, key: &str) -> Option<Vec<u8>> {
        std::fs::read(cache()?.join(key)).ok()
    }

    fn keep(&self, key: &str, bytes: &[u8]) {
        // A cache that can't be written costs time, and nothing else.
        let _ = cache().and_then(|folder| keep(&folder, key, bytes).ok());
    }

    fn list(&self, folder: &str) -> Vec<String> {
        names_in(folder)
    }
}

impl Disk {
    /// Reads a plan, which may be larger than any file that people write.
    ///
    /// # Errors
    /// Why it can't be read, in a sentence.
    pub fn read_plan(path: &str) -> Result<String, String> {
        text(path, LARGEST_PLAN)
    }
}

/// Returns what a file holds, which must be text.
fn text(path: &str, largest: u64) -> Result<String, String> {
    let bytes = bytes(path, largest)?;
    // Tabs, ends of lines and pages, and the end mark of old systems are text; a terminal obeys some of the others.
    let is_control = |b: &u8| *b < b' ' && !matches!(b, b'\t'..=b'\r' | 0x1a);
    if let Some(at) = bytes.iter().position(is_control) {
        return Err(format!("it is not text: byte {at} is a control character"));
    }
    String::from_utf8(bytes).map_err(|e| format!("it is not text: byte {} is not UTF-8", e.utf8_error().valid_up_to()))
}

/// Returns what a file holds.
fn bytes(path: &str, largest: u64) -> Result<Vec<u8>, String> {
    let is_directory = std::fs::metadata(path).map_err(|e| why(&e))?.is_dir();
    if is_directory {
        return Err("it is a directory".into());
    }
    let file = std::fs::File::open(path).map_err(|e| why(&e))?;
    let mut bytes = Vec::new();
    file.take(largest + 1).read_to_end(&mut bytes).map_err(|e| why(&e))?;
    if bytes.len() as u64 > largest {
        return Err(format!("it is larger than {} MB", largest >> 20));
    }
    Ok(bytes)
}

/// Returns the folders of packages as ROS knows them: those of ROS_PACKAGE_PATH, then `share` of those of AMENT_PREFIX_PATH.
fn packages() -> Vec<String> {
    let folders = |variable: &str| -> Vec<PathBuf> {
        let value = std::env::var_os(variable).unwrap_or_default();
        std::env::split_paths(&value)
            .filter(|p| !p.as_os_str().is_empty())
            .collect()
    };
    let ament = folders("AMENT_PREFIX_PATH").into_iter().map(|p| p.join("share"));
    let all = folders("ROS_PACKAGE_PATH").into_iter().chain(ament);
    all.map(|p| p.to_string_lossy().into_owned()).collect()
}

/// Returns the folder of what is kept between runs: SGAP_CACHE, or `sgap` in the platform's; none when SGAP_CACHE is empty.
fn cache() -> Option<PathBuf> {
    let set = |variable: &str| std::env::var_os(variable).filter(|v| !v.is_empty()).map(PathBuf::from);
    if std::env::var_os("SGAP_CACHE").is_some() {
        return set("SGAP_CACHE");
    }
    let of_platform = if cfg!(target_os = "macos") {
        set("HOME")?.join("Library/Caches")
    } else if cfg!(windows) {
        set("LOCALAPPDATA")?
    } else {
        set("XDG_CACHE_HOME").or_else(|| Some(set("HOME")?.join(".cache")))?
    };
    Some(of_platform.join("sgap"))
}

/// Writes beside the target and renames: another run never reads half a file.
fn keep(folder: &Path, key: &str, bytes: &[u8]) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let beside = folder.join(format!("{key}.{}", std::process::id()));
    std::fs::write(&beside, bytes)?;
    std::fs::rename(&beside, folder.join(key))
}

/// Returns the names in a folder, sorted: the order of a file system says nothing.
fn names_in(folder: &str) -> Vec<String> {
    let folder = if folder.is_empty() { "." } else { folder };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    names
}

fn why(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::NotFound => "there is no such file".into(),
        std::io::ErrorKind::PermissionDenied => "no permission to read it".into(),
        _ => error.to_string(),
    }
}
