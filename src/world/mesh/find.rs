//! Where the name of a mesh leads: paths to try, in order.
//!
//! A package is a folder of its name. It is looked for in the folders that the model file names, in those of the environment, and
//! then from the folder of the URDF upwards, since packages mostly hold their URDF themselves.

/// Returns the paths at which the mesh that `file` names may be.
pub fn candidates(file: &str, name: &str, packages: &[String]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut add = |path: String| {
        if !found.contains(&path) {
            found.push(path);
        }
    };
    if let Some(rest) = name
        .strip_prefix("package://")
        .or_else(|| name.strip_prefix("model://"))
    {
        // Three slashes occur in vendors' files.
        let (package, path) = rest.trim_start_matches('/').split_once('/').unwrap_or((rest, ""));
        for folder in packages.iter().map(|f| f.trim_end_matches('/')) {
            add(format!("{folder}/{package}/{path}"));
            if last(folder) == package {
                add(format!("{folder}/{path}"));
            }
        }
        for folder in upwards(file) {
            if last(&folder) == package {
                add(joined(&folder, path));
            }
            add(joined(&folder, &format!("{package}/{path}")));
        }
        return found;
    }
    let path = name.strip_prefix("file://").unwrap_or(name);
    add(crate::world::model::beside(file, path));
    found
}

/// Returns the folder of a file and those above it.
fn upwards(file: &str) -> Vec<String> {
    let mut folders = Vec::new();
    let mut rest = file;
    while let Some((folder, _)) = rest.rsplit_once('/') {
        folders.push(folder.to_string());
        rest = folder;
    }
    if !file.starts_with('/') {
        folders.push(String::new());
    }
    folders
}

fn last(folder: &str) -> &str {
    folder.rsplit('/').next().unwrap_or(folder)
}

fn joined(folder: &str, path: &str) -> String {
    if folder.is_empty() {
        path.to_string()
    } else {
        format!("{folder}/{path}")
    }
}
