//! Builds the npm packages: ECMAScript and `CommonJS` modules with their types, and one package with the program for each
//! platform. Data is in separate files, so bundlers include only the required data.

use serde_json::{Map, Value, json};

use super::Package;
use super::content::{Content, pretty};
use super::metadata::{DESCRIPTION, KEYWORDS, LICENSE, NAME, REPOSITORY, TIME, VERSION};
use crate::archive::{File, tar_gz};
use crate::platform::{Platform, Program};

/// The root folder of npm archives.
const FOLDER: &str = "package";

/// The entry point of the package.
const INDEX: &str = "index";

/// The script that runs the program of the package for the current platform.
const LAUNCHER: &str = "bin/uavspec.cjs";

/// The program in the packages for platforms. The launcher has the same path.
const PROGRAM: &str = "bin/uavspec";

/// Builds the package of the modules. It contains the launcher only if there are packages with the program.
pub(super) fn package(content: &Content, platforms: &[&Platform]) -> Result<Package, String> {
    let mut files = content.javascript.clone();
    files.extend([
        File::new("data.js", include_str!("npm/data.js")),
        File::new("data.cjs", include_str!("npm/data.cjs")),
        File::new("data.d.ts", include_str!("npm/data.d.ts")),
        File::new("data.d.cts", include_str!("npm/data.d.cts")),
        File::new("README.md", &readme(platforms)),
    ]);
    if !platforms.is_empty() {
        files.push(File::new(LAUNCHER, include_str!("npm/launcher.cjs")).executable());
    }
    files.extend(content.data.iter().chain(&content.licences).cloned());
    files.push(File::new("package.json", &pretty(&package_json(&files, platforms))?));
    archive(NAME, &files)
}

/// Builds the package of a program. npm installs it only on its platform.
pub(super) fn platform_package(program: &Program) -> Result<Package, String> {
    let name = program.platform.npm_package();
    let mut files = program.licences.clone();
    files.push(program.file(PROGRAM));
    files.push(File::new("README.md", include_str!("npm/program.md")));
    let (system, processor) = program.platform.node;
    let mut manifest = manifest(&name, &format!("The uavspec program for {system}-{processor}"));
    manifest["os"] = json!([system]);
    manifest["cpu"] = json!([processor]);
    files.push(File::new("package.json", &pretty(&manifest)?));
    archive(&name.trim_start_matches('@').replace('/', "-"), &files)
}

fn archive(name: &str, files: &[File]) -> Result<Package, String> {
    let mut files: Vec<File> = files.iter().map(|file| file.below(FOLDER)).collect();
    files.sort_by(|left, right| left.path.cmp(&right.path));
    Ok(Package {
        file_name: format!("{name}-{VERSION}.tgz"),
        count: files.len(),
        bytes: tar_gz(&files, TIME)?,
    })
}

/// The common part of all manifests.
fn manifest(name: &str, description: &str) -> Value {
    let mut manifest =
        json!({ "name": name, "version": VERSION, "description": description, "license": LICENSE });
    if !REPOSITORY.is_empty() {
        manifest["repository"] = json!({ "type": "git", "url": format!("git+{REPOSITORY}") });
    }
    manifest
}

/// The README. Its section about the program is omitted if there is no launcher.
fn readme(platforms: &[&Platform]) -> String {
    let sections = include_str!("npm/README.md").split("\n## ");
    let is_kept = |section: &&str| !platforms.is_empty() || section.lines().next() != Some("Program");
    let sections = sections.filter(is_kept);
    sections.collect::<Vec<_>>().join("\n## ")
}

fn package_json(files: &[File], platforms: &[&Platform]) -> Value {
    // Modules without types are internal.
    let modules = files.iter().filter_map(|file| file.path.strip_suffix(".d.cts"));
    let mut entries: Vec<(String, Value)> = modules.map(|name| (entry(name), conditions(name))).collect();
    entries.sort_by(|(left, _), (right, _)| left.cmp(right));
    let mut exports: Map<String, Value> = entries.into_iter().collect();
    for data in ["schemas/*", "vectors/*", "manifest.json", "package.json"] {
        exports.insert(format!("./{data}"), format!("./{data}").into());
    }
    let mut manifest = manifest(NAME, DESCRIPTION);
    manifest["keywords"] = json!(KEYWORDS);
    manifest["type"] = "module".into();
    manifest["sideEffects"] = false.into();
    manifest["engines"] = json!({ "node": ">=18" });
    // For tools that ignore `exports`.
    manifest["main"] = format!("./{INDEX}.cjs").into();
    manifest["types"] = format!("./{INDEX}.d.cts").into();
    manifest["exports"] = Value::Object(exports);
    if !platforms.is_empty() {
        manifest["bin"] = json!({ NAME: LAUNCHER });
        let platforms = platforms.iter().map(|platform| (platform.npm_package(), VERSION.into()));
        manifest["optionalDependencies"] = Value::Object(platforms.collect());
    }
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
