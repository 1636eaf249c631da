//! Installs the adapters' requirements without root, in folders below the target folder. Creates the commands that run
//! the adapters.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::tool::{Environment, Tool};
use crate::command::cargo;

/// The installed environments.
#[derive(Debug)]
pub(super) struct Installation {
    /// The folder of the adapters.
    source: PathBuf,
    /// The folder of the installation.
    target: PathBuf,
    may_install: bool,
    /// The result for each environment.
    outcomes: BTreeMap<Environment, Result<(), String>>,
}

impl Installation {
    pub(super) fn new(source: PathBuf, target: PathBuf, may_install: bool) -> Self {
        Self { source, target, may_install, outcomes: BTreeMap::new() }
    }

    /// The command that runs the adapter of `tool`, or the reason why it can't run.
    pub(super) fn command(&mut self, tool: &Tool) -> Result<Command, String> {
        if !self.outcomes.contains_key(&tool.environment) {
            self.outcomes.insert(tool.environment, self.prepare(tool.environment));
        }
        self.outcomes.get(&tool.environment).cloned().unwrap_or(Ok(()))?;
        let adapter = |folder: &str| self.source.join(folder).join(&tool.adapter);
        match tool.environment {
            Environment::Node => Ok(command("node", [self.target.join("node").join(&tool.adapter)])),
            Environment::Python => {
                let mut found = command(self.target.join("python/venv/bin/python"), [adapter("python")]);
                found.env("PYTHONPATH", self.source.join("python")).env("PYTHONDONTWRITEBYTECODE", "1");
                // Adapters have the same names as the packages that they import.
                found.env("PYTHONSAFEPATH", "1");
                Ok(found)
            }
            Environment::Rust => self.rust(tool),
            Environment::Cpp => self.cpp(tool),
            Environment::Perl => Ok(command("perl", [adapter("perl")])),
        }
    }

    fn prepare(&self, environment: Environment) -> Result<(), String> {
        match environment {
            Environment::Node => self.node(),
            Environment::Python => self.python(),
            Environment::Rust => Ok(()),
            Environment::Cpp => {
                let check = [
                    "-fsyntax-only",
                    "-x",
                    "c++",
                    "-include",
                    "valijson/schema.hpp",
                    "-include",
                    "nlohmann/json.hpp",
                    "/dev/null",
                ];
                probe("g++", &check)
                    .map_err(|_| "requires g++, libvalijson-dev and nlohmann-json3-dev".to_owned())
            }
            Environment::Perl => probe("perl", &["-MJSON::Validator", "-e", "1"])
                .map_err(|_| "requires libjson-validator-perl".to_owned()),
        }
    }

    /// Installs the packages next to a copy of the adapters, because Node looks for packages there.
    fn node(&self) -> Result<(), String> {
        probe("node", &["--version"]).map_err(|error| format!("requires Node 20 or later: {error}"))?;
        let target = self.target.join("node");
        copy(&self.source.join("node"), &target)?;
        self.once(&target.join("package-lock.json"), &target.join("node_modules/installed"), || {
            probe("npm", &["--version"]).map_err(|error| format!("requires npm: {error}"))?;
            let arguments = ["ci", "--no-audit", "--no-fund", "--ignore-scripts", "--omit=optional"];
            execute(command("npm", arguments).current_dir(&target))
        })
    }

    fn python(&self) -> Result<(), String> {
        let requirements = self.source.join("python/requirements.txt");
        let venv = self.target.join("python/venv");
        self.once(&requirements, &venv.join("installed"), || {
            execute(command("python3", ["-m", "venv", "--clear"]).arg(&venv))?;
            let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--requirement"];
            execute(command(venv.join("bin/python"), pip).arg(&requirements))
        })
    }

    /// Installs an environment, unless an installation with the same lock file exists. A copy of the lock file marks
    /// the installation.
    fn once(
        &self,
        lock: &Path,
        installed: &Path,
        install: impl FnOnce() -> Result<(), String>,
    ) -> Result<(), String> {
        let text = fs::read(lock).map_err(|error| format!("{}: {error}", lock.display()))?;
        if fs::read(installed).is_ok_and(|found| found == text) {
            return Ok(());
        }
        if !self.may_install {
            return Err(format!("the packages for {} are not installed", lock.display()));
        }
        eprintln!("interop: installing packages for {}", lock.display());
        install()?;
        fs::write(installed, text).map_err(|error| format!("{}: {error}", installed.display()))
    }

    fn rust(&self, tool: &Tool) -> Result<Command, String> {
        let target = self.target.join("rust");
        let program = target.join("debug").join(&tool.adapter);
        if self.may_install {
            eprintln!("interop: compiling {}", tool.adapter);
            let mut build = command(cargo(), ["build", "--quiet", "--locked", "--package", &tool.adapter]);
            build.arg("--manifest-path").arg(self.source.join("rust/Cargo.toml"));
            execute(build.arg("--target-dir").arg(&target))?;
        }
        if program.exists() { Ok(Command::new(program)) } else { Err("not compiled".to_owned()) }
    }

    fn cpp(&self, tool: &Tool) -> Result<Command, String> {
        let program = self.target.join("cpp").join(&tool.name);
        let adapter = self.source.join("cpp").join(&tool.adapter);
        fs::create_dir_all(self.target.join("cpp")).map_err(|error| error.to_string())?;
        self.once(&adapter, &program.with_extension("source"), || {
            let version = output("dpkg-query", &["--show", "--showformat", "${Version}", "libvalijson-dev"]);
            let version = version.unwrap_or_else(|_| "unknown".to_owned());
            let mut compile = command("g++", ["-O1", "-std=c++17"]);
            compile.arg("-DVALIJSON_USE_EXCEPTIONS=1").arg(format!("-DVALIJSON_VERSION=\"{version}\""));
            execute(compile.arg("-o").arg(&program).arg(&adapter))
        })?;
        Ok(Command::new(program))
    }
}

fn command(program: impl AsRef<OsStr>, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
    let mut command = Command::new(program);
    command.args(arguments);
    command
}

/// Runs a command and ignores its output.
fn probe(program: &str, arguments: &[&str]) -> Result<(), String> {
    output(program, arguments).map(|_| ())
}

fn output(program: &str, arguments: &[&str]) -> Result<String, String> {
    let found = command(program, arguments).stdin(Stdio::null()).output();
    let found = found.map_err(|error| format!("{program}: {error}"))?;
    if found.status.success() {
        Ok(String::from_utf8_lossy(&found.stdout).into_owned())
    } else {
        Err(format!("{program}: {}", found.status))
    }
}

/// Runs an installation command. Prints its output only if it fails.
fn execute(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let done = command.stdin(Stdio::null()).output().map_err(|error| format!("{name}: {error}"))?;
    if done.status.success() {
        return Ok(());
    }
    eprint!("{}{}", String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
    Err(format!("{name}: {}", done.status))
}

/// Copies the files of a folder, except installed packages.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let at = |error: std::io::Error| format!("{}: {error}", from.display());
    fs::create_dir_all(to).map_err(at)?;
    for entry in fs::read_dir(from).map_err(at)? {
        let entry = entry.map_err(at)?;
        let (path, name) = (entry.path(), entry.file_name());
        if name == "node_modules" {
            continue;
        }
        if path.is_dir() {
            copy(&path, &to.join(name))?;
        } else {
            fs::copy(&path, to.join(name)).map_err(at)?;
        }
    }
    Ok(())
}
