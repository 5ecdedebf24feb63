//! Reads files. All other rooms see texts alone, through [`Files`].

use std::io::Read;

use crate::source::Files;

/// The file system. A path is relative to the working directory of the program.
#[derive(Debug, Clone, Copy)]
pub struct Disk;

/// A domain, world or model file is never larger [bytes].
const LARGEST: u64 = 64 << 20;

/// Nor is a plan: ten million actions, at 800 bytes each.
const LARGEST_PLAN: u64 = 8 << 30;

impl Files for Disk {
    fn read(&self, path: &str) -> Result<String, String> {
        read_up_to(path, LARGEST)
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
        read_up_to(path, LARGEST_PLAN)
    }
}

fn read_up_to(path: &str, largest: u64) -> Result<String, String> {
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
    // Tabs, ends of lines and pages, and the end mark of old systems are text; a terminal obeys some of the others.
    let is_control = |b: &u8| *b < b' ' && !matches!(b, b'\t'..=b'\r' | 0x1a);
    if let Some(at) = bytes.iter().position(is_control) {
        return Err(format!("it is not text: byte {at} is a control character"));
    }
    String::from_utf8(bytes).map_err(|e| format!("it is not text: byte {} is not UTF-8", e.utf8_error().valid_up_to()))
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
