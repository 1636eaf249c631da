//! TypeScript modules. Each package is a module with the JSON types of its messages, its constants, enums and error
//! codes. The `index` module exports each package as a namespace.
//!
//! The names match those of [`super::python`]. Properties that TypeScript types can't express, such as ranges, units
//! and lengths, are in comments. The JSON Schemas check these properties.
//!
//! # Numbers
//!
//! 64-bit integers have the type `number`, as `JSON.parse` returns them. Values beyond 2^53 are rounded. Constants that
//! a `number` can't represent exactly have the type `bigint`. Floats may be `null`, which represents NaN.
//!
//! # Open sets
//!
//! Enums and sets of known values are open. The type lists the known values for completion, and accepts all other
//! values.
//!
//! # Labels
//!
//! If there are translations, the `labels` module provides the text of the definitions in all languages. Each language
//! is a module, such as `labels/uk`, that is loaded on demand.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::typescript;
//! use uavspec_schema::translation::Translations;
//!
//! let files = typescript::emit(&schema, &Translations::default(), &typescript::Options::default());
//! assert!(files.iter().any(|file| file.path == "px4.ts" && file.text.contains("export interface Wind")));
//! ```

mod comment;
mod error_code;
mod event;
mod item;
mod labels;
mod language;
mod types;

use uavspec_schema::Schema;
use uavspec_schema::failure::Failure;
use uavspec_schema::translation::Translations;

use self::comment::header;
use self::language::Language;
use super::binding::{Module, labels, modules};
use super::emitter::{Input, Output};
use super::file::OutputFile;

/// The form of the emitted modules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, schemars::JsonSchema, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// TypeScript source files, such as `px4.ts`, to compile together with other source files.
    #[default]
    Source,
    /// JavaScript with type declarations: `px4.js` and `px4.d.ts` for ECMAScript modules, `px4.cjs` and `px4.d.cts` for
    /// `CommonJS`.
    Compiled,
}

/// Options of the emitter.
#[derive(Clone, Debug, Default, PartialEq, Eq, schemars::JsonSchema, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// `source`, or `compiled` for JavaScript with type declarations.
    pub form: Form,
}

impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, input.translations, self))
    }
}

/// Creates a module for each package, the index, and labels if there are translations. Files are sorted by path.
pub fn emit(schema: &Schema, translations: &Translations, options: &Options) -> Vec<OutputFile> {
    let modules = modules(schema);
    let labels = labels(schema, translations);
    let languages: &[Language] = match options.form {
        Form::Source => &[Language::TypeScript],
        Form::Compiled => &[Language::JavaScript, Language::CommonJs, Language::Declarations],
    };
    let mut files = Vec::new();
    for language in languages {
        let path = |name: &str| format!("{name}.{}", language.extension());
        files.push(OutputFile { path: path("index"), text: index(&modules, *language) });
        files.extend(
            modules
                .iter()
                .map(|module| OutputFile { path: path(&module.name), text: package(module, *language) }),
        );
        if modules.iter().any(|module| module.events.is_some()) {
            files.push(event::module(*language));
        }
        files.extend(labels.iter().flat_map(|labels| labels::files(labels, *language)));
    }
    if options.form == Form::Compiled {
        let typed = files.iter().filter_map(|file| file.path.strip_suffix(".d.cts"));
        let re_exports: Vec<OutputFile> = typed.map(types_of_module).collect();
        files.extend(re_exports);
    }
    OutputFile::sort(&mut files);
    files
}

/// Type declarations of an ECMAScript module. The declarations re-export the `CommonJS` types to avoid duplicates.
fn types_of_module(path: &str) -> OutputFile {
    let name = path.rsplit('/').next().unwrap_or(path);
    let text = format!("{}export * from \"./{name}.cjs\";\n", header("the definitions"));
    OutputFile { path: format!("{path}.d.ts"), text }
}

fn index(modules: &[Module], language: Language) -> String {
    let mut text = header("the definitions");
    if language == Language::CommonJs {
        text.push_str("\"use strict\";\n\n");
    }
    text.extend(modules.iter().map(|module| {
        let (name, extension) = (&module.name, language.imported_extension());
        let documentation = comment::block(&module.text, "");
        if language == Language::CommonJs {
            format!("{documentation}exports.{name} = require(\"./{name}.{extension}\");\n")
        } else {
            format!("{documentation}export * as {name} from \"./{name}.{extension}\";\n")
        }
    }));
    if modules.is_empty() && language != Language::CommonJs {
        text.push_str("export {};\n");
    }
    text
}

fn package(module: &Module, language: Language) -> String {
    let mut text = header(&format!("the definitions of package {}", comment::line(&module.package)));
    if language == Language::CommonJs {
        text.push_str("\"use strict\";\n\n");
    }
    if language.has_types() && !module.imports.is_empty() {
        let extension = language.imported_extension();
        let imports = module.imports.iter();
        text.extend(imports.map(|name| format!("import type * as {name} from \"./{name}.{extension}\";\n")));
        text.push('\n');
    }
    if module.events.is_some() {
        text.push_str(&event::import(language));
    }
    let mut items: Vec<String> =
        module.declarations.iter().map(|declaration| item::declaration(declaration, language)).collect();
    if !module.error_codes.is_empty() {
        items.extend(error_code::items(&module.error_codes, language));
    }
    items.extend(module.events.iter().map(|events| event::item(events, language)));
    items.retain(|item| !item.is_empty());
    if items.is_empty() && language != Language::CommonJs {
        // Add an export, because a file without exports would not be a module.
        items.push("export {};\n".to_owned());
    }
    text + &items.join("\n")
}
