//! The content of the npm package of the types: generated files and a manifest.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use uavspec_codegen::load::read_definitions_translated;
use uavspec_emit::{OutputFile, json_schema, typescript, vectors};

use crate::archive::File;
use crate::message_of;

/// File name endings. The manifest lists names without these endings.
const BUNDLE: &str = ".bundle.schema.json";
const SCHEMA: &str = ".schema.json";
const VECTORS: &str = ".vectors.json";

/// The schema of vector files, in the same folder.
const VECTORS_SCHEMA: &str = "vectors.schema.json";

/// The content.
pub(crate) struct Content {
    /// JavaScript modules and their types.
    pub(super) javascript: Vec<File>,
    /// Schemas, vectors and the manifest.
    pub(super) data: Vec<File>,
}

impl Content {
    /// Generates the content from the definitions in the repository at `root`.
    pub(crate) fn of(root: &Path) -> Result<Self, String> {
        let config = root.join("definitions/uavspec.toml");
        let (_, schema, translations) =
            read_definitions_translated(&config).map_err(|failure| message_of(&failure))?;
        let base = schema_base(&config)?;
        let options = base.clone().map_or_else(Default::default, |base| json_schema::Options { base });
        let schemas = json_schema::emit(&schema, &options);
        let vectors = vectors::emit(&schema, &vectors::Options { base });
        // Omit the files in the format of the JSON Schema Test Suite, which contain the same cases.
        let is_own = |file: &&OutputFile| file.path.ends_with(VECTORS) || file.path == VECTORS_SCHEMA;
        let vectors: Vec<&OutputFile> = vectors.iter().filter(is_own).collect();
        let mut data = vec![File::new("manifest.json", &manifest(&schemas, &vectors)?)];
        data.extend(schemas.iter().map(|file| File::new(format!("schemas/{}", file.path), &file.text)));
        data.extend(vectors.iter().map(|file| File::new(format!("vectors/{}", file.path), &file.text)));
        let options = typescript::Options { form: typescript::Form::Compiled };
        Ok(Self { javascript: files(&typescript::emit(&schema, &translations, &options)), data })
    }
}

/// The URL prefix of the schemas in the configuration, or `None` for the default.
fn schema_base(config: &Path) -> Result<Option<String>, String> {
    let at = |message: String| format!("{}: {message}", config.display());
    let text = fs::read_to_string(config).map_err(|error| at(error.to_string()))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| at(error.to_string()))?;
    let base = table.get("output").and_then(|output| output.get("json_schema")?.get("base")?.as_str());
    Ok(base.map(str::to_owned))
}

fn files(emitted: &[OutputFile]) -> Vec<File> {
    emitted.iter().map(|file| File::new(file.path.clone(), &file.text)).collect()
}

/// Lists the names of all schemas, bundles and vectors.
fn manifest(schemas: &[OutputFile], vectors: &[&OutputFile]) -> Result<String, String> {
    let names = |files: &mut dyn Iterator<Item = &OutputFile>, ending: &str| -> Vec<Value> {
        files.filter_map(|file| file.path.strip_suffix(ending)).map(Value::from).collect()
    };
    let is_bundle = |file: &&OutputFile| file.path.ends_with(BUNDLE);
    let manifest = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "bundles": names(&mut schemas.iter(), BUNDLE),
        "schemas": names(&mut schemas.iter().filter(|file| !is_bundle(file)), SCHEMA),
        "vectors": names(&mut vectors.iter().copied(), VECTORS),
    });
    pretty(&manifest)
}

/// Formats JSON with indentation and a newline at the end.
pub(super) fn pretty(value: &Value) -> Result<String, String> {
    serde_json::to_string_pretty(value).map(|text| text + "\n").map_err(|error| error.to_string())
}
