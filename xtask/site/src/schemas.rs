//! Pages that show JSON Schemas as tables, next to the schema files.

mod describe;
mod markdown;

use std::path::Path;

use serde_json::Value;
use walkdir::WalkDir;

use self::describe::{Part, parts};
use self::markdown::{code, table, text};

/// The end of the name of a schema file.
const ENDING: &str = ".schema.json";

/// Files larger than this are linked from the page, but not part of it.
const MAX_SHOWN: usize = 100_000;

/// The pages of all schemas.
pub(crate) struct Schemas {
    /// The paths and texts of the pages.
    pub(crate) pages: Vec<(String, String)>,
    /// The entries of the pages in the table of contents.
    pub(crate) contents: String,
}

/// Creates the pages of all schemas below `generated/schemas`.
pub(crate) fn pages(generated: &Path) -> Result<Schemas, String> {
    let mut contents = vec!["- [JSON Schemas by name]()\n".to_owned()];
    let mut pages = Vec::new();
    let mut folder = String::new();
    for entry in WalkDir::new(generated.join("schemas")).sort_by_file_name() {
        let entry = entry.map_err(|error| error.to_string())?;
        let relative = entry.path().strip_prefix(generated).unwrap_or(entry.path());
        let path = relative.display().to_string().replace('\\', "/");
        let Some(stem) = path.strip_suffix(ENDING) else { continue };
        let page = page(generated, stem, entry.path())?;
        let (above, name) = stem.rsplit_once('/').unwrap_or(("", stem));
        if above != folder && above.contains('/') {
            above.clone_into(&mut folder);
            let package = above.rsplit('/').next().unwrap_or(above);
            contents.push(format!("  - [Schemas of {package}]()\n"));
        }
        let indent = if above.contains('/') { "    " } else { "  " };
        contents.push(format!("{indent}- [{name} (schema)]({stem}.schema.md)\n"));
        pages.push((format!("{stem}.schema.md"), page));
    }
    Ok(Schemas { pages, contents: contents.concat() })
}

/// Returns the page of one schema. `stem` is its path in `generated` without the ending.
fn page(generated: &Path, stem: &str, path: &Path) -> Result<String, String> {
    let of_file = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let raw = std::fs::read_to_string(path).map_err(|error| of_file(&error))?;
    let schema: Value = serde_json::from_str(&raw).map_err(|error| of_file(&error))?;
    let name = stem.rsplit('/').next().unwrap_or(stem);
    let file = format!("{name}{ENDING}");
    let description = schema["description"].as_str().unwrap_or_default();
    let mut page = vec![format!("# {} (JSON Schema)\n\n", text(name))];
    page.extend(description.lines().map(|line| format!("{}\n", text(line))));
    page.push(format!("\n{}\n", facts(generated, stem, &file, &schema)));
    match name.strip_suffix(".bundle") {
        Some(package) => page.push(members(package, &schema)),
        None => page.extend(parts(&schema).iter().map(section)),
    }
    page.extend(example(generated, stem).map(|example| listing("Example", &example)));
    if raw.len() <= MAX_SHOWN {
        page.push(listing("Schema file", &raw));
    }
    Ok(page.concat())
}

fn listing(title: &str, json: &str) -> String {
    format!("## {title}\n\n```json\n{}\n```\n\n", json.trim_end())
}

/// A table with the file, the address, and the page of the definition.
fn facts(generated: &Path, stem: &str, file: &str, schema: &Value) -> String {
    let mut rows = vec![["File".to_owned(), format!("[`{file}`]({file})")]];
    if let Some(id) = schema["$id"].as_str() {
        rows.push(["Address".to_owned(), code(id)]);
    }
    if let Some(page) = definition(generated, stem) {
        let up = "../".repeat(stem.matches('/').count());
        let name = page.rsplit('/').next().unwrap_or(&page).trim_end_matches(".md");
        rows.push(["Definition".to_owned(), format!("[{}]({up}{page})", text(name))]);
    }
    table(&["", ""], &rows)
}

/// The documentation page of the message or type that the schema describes.
fn definition(generated: &Path, stem: &str) -> Option<String> {
    let (package, name) = stem.strip_prefix("schemas/")?.split_once('/')?;
    let message = name.split('.').next().unwrap_or(name);
    let pages = [
        format!("docs/{package}/{name}.md"),
        format!("docs/{package}/types/{name}.md"),
        format!("docs/{package}/messages/{message}.md"),
    ];
    pages.into_iter().find(|page| generated.join(page).is_file())
}

/// A list of the schemas in a bundle. Each schema has a page.
fn members(package: &str, bundle: &Value) -> String {
    let names = bundle["$defs"].as_object().into_iter().flatten().map(|(name, _)| name);
    let items: String =
        names.map(|name| format!("- [{}]({package}/{name}.schema.md)\n", text(name))).collect();
    format!("## Schemas in this bundle\n\n{items}\n")
}

fn section(part: &Part<'_>) -> String {
    let title = format!("## {}\n\n", text(&part.title));
    let description = format!("{}\n\n", text(part.description));
    [title, description, table(&part.columns, &part.rows), "\n".to_owned()].concat()
}

/// The typical test case of the schema, or the first valid test case, formatted.
fn example(generated: &Path, stem: &str) -> Option<String> {
    let vectors = stem.replacen("schemas/", "vectors/", 1);
    let vectors = std::fs::read_to_string(generated.join(format!("{vectors}.vectors.json"))).ok()?;
    let vectors: Value = serde_json::from_str(&vectors).ok()?;
    let cases =
        vectors["cases"].as_array()?.iter().filter(|case| case["valid"] == true && !case["json"].is_null());
    let case = cases.min_by_key(|case| case["id"] != "typical")?;
    serde_json::to_string_pretty(&case["json"]).ok()
}
