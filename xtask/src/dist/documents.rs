//! The documents that accompany the program on each platform. The documents depend only on the command line of the
//! program.

use std::env::consts::ARCH;
use std::fs;
use std::path::Path;
use std::process::Command;

use super::build::Built;
use crate::archive::File;
use crate::command::{cargo, output};

/// The shells, and the names of the files in which they expect completions.
const SHELLS: [(&str, &str); 5] = [
    ("bash", "uavspec.bash"),
    ("elvish", "uavspec.elv"),
    ("fish", "uavspec.fish"),
    ("powershell", "_uavspec.ps1"),
    ("zsh", "_uavspec"),
];

/// Runs the program to write its completions and man pages to a folder. If all programs are for other processors, runs
/// a development build instead.
pub(super) fn write(root: &Path, programs: &[Built], folder: &Path) -> Result<(), String> {
    let is_native = |built: &&Built| {
        built.platform.machine == ARCH && built.platform.target.contains("linux") == cfg!(target_os = "linux")
    };
    let native = programs.iter().find(is_native);
    let uavspec = || native.map_or_else(|| development_build(root), |built| Command::new(&built.path));
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    for (shell, name) in SHELLS {
        let script = output(uavspec().args(["completions", shell]))? + "\n";
        File::new(format!("completions/{name}"), &script).write(folder)?;
    }
    output(uavspec().args(["man", "--out"]).arg(folder.join("man/man1"))).map(|_| ())
}

fn development_build(root: &Path) -> Command {
    let mut command = Command::new(cargo());
    command.args(["run", "--quiet", "--locked", "--package", "uavspec", "--manifest-path"]);
    command.arg(root.join("Cargo.toml")).arg("--");
    command
}
