//! An empty Debian system in a folder, with Python and Node.

use std::env::consts::ARCH;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::command::{found, output};
use crate::paths::repository;
use crate::platform::Platform;

/// The release of Debian.
const RELEASE: &str = "bookworm";

/// The packages in addition to the minimal system.
const PACKAGES: &str = "ca-certificates,nodejs,python3-venv";

/// The version of npm, which must support the release's Node. Debian's package of npm has hundreds of dependencies.
const NPM: &str = "npm@10.9.2";

/// The folders with programs. No folder contains a program from outside the system.
const PATH: &str = "/usr/sbin:/usr/bin:/sbin:/bin";

/// A system.
pub(super) struct System {
    root: PathBuf,
}

impl System {
    /// Copies the system for a platform. The first call downloads it to `target/dist-test`.
    pub(super) fn new(platform: &Platform) -> Result<Self, String> {
        obstacle(platform)?;
        let folder = repository().join("target/dist-test");
        fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let base = folder.join(format!("{}-{RELEASE}", platform.debian));
        if !base.exists() {
            eprintln!("dist: installing {RELEASE} for {} in {}", platform.debian, base.display());
            // Install in a folder with another name, so that an interrupted installation is never used.
            let part = folder.join(format!("{}-{RELEASE}.part", platform.debian));
            remove(&part)?;
            install(platform, &part)?;
            fs::rename(&part, &base).map_err(|error| format!("{}: {error}", base.display()))?;
        }
        let root = folder.join(format!("{}-test", platform.debian));
        remove(&root)?;
        output(Command::new("cp").arg("--archive").arg(&base).arg(&root))?;
        Ok(Self { root })
    }

    /// Copies a folder into the system.
    pub(super) fn copy(&self, from: &Path, name: &str) -> Result<(), String> {
        output(Command::new("cp").arg("--recursive").arg(from).arg(self.root.join(name))).map(|_| ())
    }

    /// Writes a file in the system.
    pub(super) fn write(&self, path: &str, bytes: &[u8]) -> Result<(), String> {
        let path = self.root.join(path);
        let failed = |error: std::io::Error| format!("{}: {error}", path.display());
        path.parent().map_or(Ok(()), fs::create_dir_all).map_err(failed)?;
        fs::write(&path, bytes).map_err(failed)
    }

    /// Runs a shell script in the system, without a network.
    pub(super) fn run(&self, script: &str) -> Result<(), String> {
        run(&self.root, script)
    }
}

impl Drop for System {
    fn drop(&mut self) {
        // If the folder can't be removed, the next test removes it.
        let _ = remove(&self.root);
    }
}

/// Fails if this machine doesn't meet a requirement. The error describes the requirement.
fn obstacle(platform: &Platform) -> Result<(), String> {
    if output(Command::new("id").arg("-u"))? != "0" {
        return Err("requires root privileges, for chroot".to_owned());
    }
    for program in ["debootstrap", "npm", "unshare"] {
        if !found(program) {
            return Err(format!("requires {program}"));
        }
    }
    let emulator = Path::new("/proc/sys/fs/binfmt_misc").join(format!("qemu-{}", platform.machine));
    if platform.machine != ARCH && !emulator.exists() {
        return Err(format!(
            "requires {}: apt-get install qemu-user-static binfmt-support. In a container, also mount binfmt_misc",
            emulator.display()
        ));
    }
    Ok(())
}

/// Installs the system in a folder.
fn install(platform: &Platform, root: &Path) -> Result<(), String> {
    let mut debootstrap = Command::new("debootstrap");
    debootstrap.args(["--variant=minbase", &format!("--arch={}", platform.debian)]);
    output(debootstrap.arg(format!("--include={PACKAGES}")).arg(RELEASE).arg(root))?;
    let modules = root.join("usr/lib/node_modules");
    fs::create_dir_all(&modules).map_err(|error| format!("{}: {error}", modules.display()))?;
    let archive = output(Command::new("npm").args(["pack", "--silent", NPM]).current_dir(&modules))?;
    let script = format!(
        "cd /usr/lib/node_modules && tar -xzf {archive} && mv package npm && rm {archive} && ln -s ../lib/node_modules/npm/bin/npm-cli.js /usr/bin/npm"
    );
    run(root, &script)
}

/// Runs a shell script with another root folder, without a network.
fn run(root: &Path, script: &str) -> Result<(), String> {
    let mut command = Command::new("unshare");
    command.args(["--net", "chroot"]).arg(root).args(["/bin/sh", "-c", script]);
    command.env_clear().env("PATH", PATH).env("HOME", "/root").env("LANG", "C.UTF-8");
    output(&mut command).map(|_| ())
}

fn remove(folder: &Path) -> Result<(), String> {
    if !folder.exists() {
        return Ok(());
    }
    fs::remove_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))
}
