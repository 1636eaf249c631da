//! Runs Node, Python and type checkers.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Runs a program and returns its standard output. Panics with all output if it fails.
#[track_caller]
pub(crate) fn run(program: impl AsRef<OsStr>, arguments: &[&str], folder: &Path) -> String {
    let program = program.as_ref();
    let output = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap_or_else(|error| panic!("{}: {error}", program.display()));
    let printed = String::from_utf8_lossy(&output.stdout).replace("\r\n", "\n");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{} {arguments:?}\n{printed}{errors}", program.display());
    printed
}

/// Runs `cargo xtask` with `arguments`.
#[track_caller]
pub(crate) fn xtask(arguments: &[&str]) -> String {
    run(env!("CARGO_BIN_EXE_xtask"), arguments, &repository())
}

pub(crate) fn repository() -> PathBuf {
    fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).expect("the repository")
}

/// Writes a file and creates its folders.
pub(crate) fn write(path: &Path, text: &str) {
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, text).expect("a file");
}

/// The path of the npm package with the types, which is built once for all tests.
pub(crate) fn package() -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("packages");
        xtask(&["package", "--out", &folder.display().to_string()]);
        folder
    });
    folder.join(format!("uavspec-types-{}.tgz", env!("CARGO_PKG_VERSION")))
}

/// The folder with the type checkers from npm.
pub(crate) fn node_tools() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = installed("node", &["package.json", "package-lock.json"], |folder| {
            run("npm", &["ci", "--no-audit", "--no-fund"], folder);
        });
        folder.join("node_modules")
    })
}

/// The path of a type checker's script from npm.
pub(crate) fn node_tool(path: &str) -> String {
    node_tools().join(path).display().to_string()
}

/// The Python interpreter with the type checkers from `PyPI`.
pub(crate) fn python_with_tools() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = installed("python", &["requirements.txt"], |folder| {
            run("python3", &["-m", "venv", "environment"], folder);
            let python = program_of(folder);
            run(&python, &["-m", "pip", "install", "--quiet", "--requirement", "requirements.txt"], folder);
        });
        program_of(&folder)
    })
}

fn program_of(folder: &Path) -> PathBuf {
    folder.join(if cfg!(windows) { "environment/Scripts/python.exe" } else { "environment/bin/python" })
}

/// A folder below `target/` in which `install` ran once for the current content of these files.
fn installed(name: &str, files: &[&str], install: impl FnOnce(&Path)) -> PathBuf {
    let pins = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/packages");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("type-checkers").join(name);
    let versions: String =
        files.iter().map(|file| fs::read_to_string(pins.join(file)).expect("a list of versions")).collect();
    let mark = folder.join("installed");
    if fs::read_to_string(&mark).is_ok_and(|found| found == versions) {
        return folder;
    }
    if folder.exists() {
        fs::remove_dir_all(&folder).expect("an old folder is removed");
    }
    for file in files {
        write(&folder.join(file), &fs::read_to_string(pins.join(file)).expect("a list of versions"));
    }
    install(&folder);
    fs::write(mark, versions).expect("a file");
    folder
}
