//! The documents that accompany the program on each platform. They depend only on its command line.

use std::env::consts::ARCH;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::build::Built;
use crate::archive::File;
use crate::command::{cargo, output};

/// The documents of the program.
pub(super) struct Documents {
    /// A script for each shell, with the usual file name.
    pub(super) completions: Vec<File>,
    /// The man pages of all commands, sorted by name.
    pub(super) man_pages: Vec<File>,
    pub(super) changes: File,
}

/// The shells, and the names of the files in which they expect completions.
const SHELLS: [(&str, &str); 5] =
    [("bash", BASH), ("elvish", "uavspec.elv"), ("fish", FISH), ("powershell", "_uavspec.ps1"), ("zsh", ZSH)];
pub(super) const BASH: &str = "uavspec.bash";
pub(super) const FISH: &str = "uavspec.fish";
pub(super) const ZSH: &str = "_uavspec";

impl Documents {
    /// Runs the program to get its documents. If all programs are for other processors, runs a development build.
    pub(super) fn of(root: &Path, programs: &[Built]) -> Result<Self, String> {
        let native =
            programs.iter().find(|built| built.platform.machine == ARCH && cfg!(target_os = "linux"));
        let uavspec = || native.map_or_else(|| development_build(root), |built| Command::new(&built.path));
        let mut completions = Vec::new();
        for (shell, name) in SHELLS {
            completions.push(File::new(name, &(output(uavspec().args(["completions", shell]))? + "\n")));
        }
        let folder = root.join("target/man");
        let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
        if folder.exists() {
            fs::remove_dir_all(&folder).map_err(failed)?;
        }
        output(uavspec().args(["man", "--out"]).arg(&folder))?;
        let mut man_pages = Vec::new();
        for entry in fs::read_dir(&folder).map_err(failed)? {
            let entry = entry.map_err(failed)?;
            let text = fs::read_to_string(entry.path()).map_err(failed)?;
            man_pages.push(File::new(entry.file_name().to_string_lossy(), &text));
        }
        man_pages.sort_by(|left, right| left.path.cmp(&right.path));
        let changes = File::new("CHANGELOG.md", include_str!("../../../CHANGELOG.md"));
        Ok(Self { completions, man_pages, changes })
    }

    /// The completions in the file `name`.
    pub(super) fn completion(&self, name: &str) -> impl Iterator<Item = &File> {
        self.completions.iter().filter(move |file| file.path == name)
    }
}

fn development_build(root: &Path) -> Command {
    let mut command = Command::new(cargo());
    command.args(["run", "--quiet", "--locked", "--package", "uavspec", "--manifest-path"]);
    command.arg(root.join("Cargo.toml")).arg("--");
    command
}
