//! Builds the npm package: ECMAScript and `CommonJS` modules with their types. Data is in separate files, so bundlers
//! include only the required data.

use serde_json::{Map, Value, json};

use super::Package;
use super::archive::tar_gz;
use super::content::{Content, File, pretty};
use super::metadata::{DESCRIPTION, KEYWORDS, LICENSE, NAME, REPOSITORY, VERSION};

/// The root folder of npm archives.
const FOLDER: &str = "package";

/// The entry point of the package.
const INDEX: &str = "index";

/// Builds the package.
pub(super) fn package(content: &Content) -> Result<Package, String> {
    let mut files = content.javascript.clone();
    files.extend([
        File::new("data.js", include_str!("npm/data.js")),
        File::new("data.cjs", include_str!("npm/data.cjs")),
        File::new("data.d.ts", include_str!("npm/data.d.ts")),
        File::new("data.d.cts", include_str!("npm/data.d.cts")),
        File::new("README.md", include_str!("npm/README.md")),
    ]);
    files.extend(content.data.iter().chain(&content.licences).cloned());
    files.push(File::new("package.json", &pretty(&package_json(&files))?));
    files.sort_by(|left, right| left.path.cmp(&right.path));
    for file in &mut files {
        file.path = format!("{FOLDER}/{}", file.path);
    }
    Ok(Package { file_name: format!("{NAME}-{VERSION}.tgz"), count: files.len(), bytes: tar_gz(&files)? })
}

fn package_json(files: &[File]) -> Value {
    // Modules without types are internal.
    let modules = files.iter().filter_map(|file| file.path.strip_suffix(".d.cts"));
    let mut entries: Vec<(String, Value)> = modules.map(|name| (entry(name), conditions(name))).collect();
    entries.sort_by(|(left, _), (right, _)| left.cmp(right));
    let mut exports: Map<String, Value> = entries.into_iter().collect();
    for data in ["schemas/*", "vectors/*", "manifest.json", "package.json"] {
        exports.insert(format!("./{data}"), format!("./{data}").into());
    }
    let mut manifest = json!({
        "name": NAME,
        "version": VERSION,
        "description": DESCRIPTION,
        "keywords": KEYWORDS,
        "license": LICENSE,
    });
    if !REPOSITORY.is_empty() {
        manifest["repository"] = json!({ "type": "git", "url": format!("git+{REPOSITORY}") });
    }
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
