//! `sgap new NAME`: a folder with a domain, a world and a test that run.

use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Failure, note, write_file};

/// What to begin with.
#[derive(Debug, Args)]
pub(super) struct Options {
    /// Folder to make; its last part names the files: letters, digits, `_`, `-`
    name: PathBuf,
}

/// Files of the folder and their texts; `{{name}}` stands for the name.
const FILES: [(&str, &str); 7] = [
    ("{{name}}.hatp", include_str!("new/domain.hatp")),
    ("{{name}}.toml", include_str!("new/world.toml")),
    ("test.sh", include_str!("new/test.sh")),
    ("models/pr2.toml", include_str!("../../worlds/models/pr2.toml")),
    ("models/pr2.urdf", include_str!("../../worlds/models/pr2.urdf")),
    ("models/human.toml", include_str!("../../worlds/models/human.toml")),
    ("models/human.urdf", include_str!("../../worlds/models/human.urdf")),
];

pub(super) fn run(options: &Options) -> Result<(), Failure> {
    let folder = &options.name;
    let refuse = |why: &str| Failure::Output(format!("can't make `{}`: {why}", folder.display()));
    let name = folder.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if name.is_empty() || name.starts_with('-') || !name.chars().all(is_plain) {
        return Err(refuse("the name may have letters, digits, `_` and `-`"));
    }
    if std::fs::symlink_metadata(folder).is_ok() {
        return Err(refuse("it is there already"));
    }
    std::fs::create_dir_all(folder.join("models")).map_err(|e| refuse(&e.kind().to_string()))?;
    for (file, text) in FILES {
        let path = folder.join(file.replace("{{name}}", name));
        write_file(&path, &text.replace("{{name}}", name))?;
        if file == "test.sh" {
            make_executable(&path).map_err(|e| refuse(&e.kind().to_string()))?;
        }
    }
    let shown = folder.display();
    note(&format!(
        "{shown} is made; go on with:\n  sgap plan {shown}/{name}.hatp {shown}/{name}.toml\n  \
         sgap view {shown}/{name}.hatp {shown}/{name}.toml\n  sh {shown}/test.sh\n"
    ));
    Ok(())
}

#[cfg(unix)]
fn make_executable(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt;
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755))
}

#[cfg(not(unix))]
fn make_executable(_: &Path) -> std::io::Result<()> {
    Ok(())
}
