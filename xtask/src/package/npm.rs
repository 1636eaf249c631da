//! Builds the npm packages. `uavspec-types` contains ECMAScript and `CommonJS` modules with their types. `uavspec` starts
//! the program, which is in one package for each platform.

use serde_json::{Map, Value, json};

use super::content::{Content, pretty};
use super::licences;
use crate::archive::{File, tar_gz};
use crate::platform::{Platform, Program};

/// The root folder of npm archives.
const FOLDER: &str = "package";

/// The version of the workspace.
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The URL of the repository; empty if the workspace has none.
const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// The modification time of all files: 26 October 1985, 08:15, as in npm's archives. Archives with times after 1980 can be
/// converted to formats that don't support earlier times.
const TIME: u64 = 499_162_500;

/// The description of the package of the types.
const DESCRIPTION: &str =
    "Types, JSON Schemas, test vectors and error codes of PX4 messages and the Flockwave protocol";

const KEYWORDS: [&str; 9] =
    ["drone", "uav", "px4", "uorb", "ros2", "flockwave", "skybrush", "json-schema", "test-vectors"];

/// The entry point of the package of the types.
const INDEX: &str = "index";

/// The script that runs the program of the package for the current platform.
const LAUNCHER: &str = "bin/uavspec.cjs";

/// The path of the program in the packages for platforms. The launcher contains the same path.
const PROGRAM: &str = "bin/uavspec";

/// Builds the package of the types. Data is in separate files, so bundlers include only the required data.
pub(super) fn types(content: &Content) -> Result<File, String> {
    let mut files = content.javascript.clone();
    files.extend([
        File::new("data.js", include_str!("npm/data.js")),
        File::new("data.cjs", include_str!("npm/data.cjs")),
        File::new("data.d.ts", include_str!("npm/data.d.ts")),
        File::new("data.d.cts", include_str!("npm/data.d.cts")),
        File::new("README.md", include_str!("npm/README.md")),
    ]);
    files.extend(content.data.iter().cloned().chain(licences()));
    files.push(File::new("package.json", &pretty(&types_json(&files))?));
    archive("uavspec-types", &files)
}

/// Builds the package that starts the program for the current platform. npm installs the package of this platform.
pub(super) fn launcher(platforms: &[&Platform]) -> Result<File, String> {
    let mut manifest = manifest("uavspec", "Checks drone software against its interface specifications");
    manifest["keywords"] = json!(KEYWORDS);
    manifest["engines"] = json!({ "node": ">=18" });
    manifest["bin"] = json!({ "uavspec": LAUNCHER });
    let platforms = platforms.iter().map(|platform| (platform.npm_package(), VERSION.into()));
    manifest["optionalDependencies"] = Value::Object(platforms.collect());
    let mut files = licences();
    files.extend([
        File::new(LAUNCHER, include_str!("npm/launcher.cjs")).executable(),
        File::new("README.md", include_str!("npm/launcher.md")),
        File::new("package.json", &pretty(&manifest)?),
    ]);
    archive("uavspec", &files)
}

/// Builds the package of a program. npm installs it only on its platform.
pub(super) fn program(program: &Program) -> Result<File, String> {
    let name = program.platform.npm_package();
    let mut files = [licences(), program.third_party.clone()].concat();
    files.push(program.file(PROGRAM));
    files.push(File::new("README.md", include_str!("npm/program.md")));
    let (system, processor) = program.platform.node;
    let mut manifest = manifest(&name, &format!("The uavspec program for {system}-{processor}"));
    manifest["os"] = json!([system]);
    manifest["cpu"] = json!([processor]);
    files.push(File::new("package.json", &pretty(&manifest)?));
    archive(&name.trim_start_matches('@').replace('/', "-"), &files)
}

fn archive(name: &str, files: &[File]) -> Result<File, String> {
    let mut files: Vec<File> = files.iter().map(|file| file.below(FOLDER)).collect();
    files.sort_by(|left, right| left.path.cmp(&right.path));
    Ok(File::binary(format!("{name}-{VERSION}.tgz"), tar_gz(&files, TIME)?))
}

/// The common part of all manifests.
fn manifest(name: &str, description: &str) -> Value {
    let mut manifest = json!({ "name": name, "version": VERSION, "description": description, "license": env!("CARGO_PKG_LICENSE") });
    if !REPOSITORY.is_empty() {
        manifest["repository"] = json!({ "type": "git", "url": format!("git+{REPOSITORY}") });
    }
    manifest
}

fn types_json(files: &[File]) -> Value {
    // Export only modules with types. The other modules are internal.
    let modules = files.iter().filter_map(|file| file.path.strip_suffix(".d.cts"));
    let mut entries: Vec<(String, Value)> = modules.map(|name| (entry(name), conditions(name))).collect();
    entries.sort_by(|(left, _), (right, _)| left.cmp(right));
    let mut exports: Map<String, Value> = entries.into_iter().collect();
    for data in ["schemas/*", "vectors/*", "manifest.json", "package.json"] {
        exports.insert(format!("./{data}"), format!("./{data}").into());
    }
    let mut manifest = manifest("uavspec-types", DESCRIPTION);
    manifest["keywords"] = json!(KEYWORDS);
    manifest["type"] = "module".into();
    manifest["sideEffects"] = false.into();
    manifest["engines"] = json!({ "node": ">=18" });
    // For tools that ignore `exports`.
    manifest["main"] = format!("./{INDEX}.cjs").into();
    manifest["types"] = format!("./{INDEX}.d.cts").into();
    manifest["exports"] = Value::Object(exports);
    manifest
}

fn entry(name: &str) -> String {
    if name == INDEX { ".".to_owned() } else { format!("./{name}") }
}

/// The exports of a module. ECMAScript and `CommonJS` modules require separate type declarations.
fn conditions(name: &str) -> Value {
    json!({
        "import": { "types": format!("./{name}.d.ts"), "default": format!("./{name}.js") },
        "require": { "types": format!("./{name}.d.cts"), "default": format!("./{name}.cjs") },
    })
}
