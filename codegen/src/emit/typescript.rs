//! TypeScript: a module for each package, with the types of its messages as JSON, its constants, enums and error
//! codes; and `index`, which has each package as a namespace.
//!
//! Names are those of [`super::python`]. Whatever else is known of a value – its range, its unit, its length –
//! stands in the comment above it: types of TypeScript can't say it, the JSON Schemas do.
//!
//! # Numbers
//!
//! Integers of 64 bits are `number`, since that is what `JSON.parse` makes of them: beyond 2^53 it gives their neighbour.
//! Constants of which no `number` is exact are of type `bigint`. Floats may be `null`, which stands for NaN.
//!
//! # Open sets
//!
//! Enums and sets of known values are open: the type names the values that are known, for completion, and takes all
//! others.
//!
//! # Labels
//!
//! Where definitions are translated, `labels` gives what they say in a language of the user, and each language is a
//! module of its own, `labels/uk`, which a program loads when it asks for it.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_codegen::{emit::typescript, translation::Translations};
//!
//! let files = typescript::emit(&schema, &Translations::default(), &typescript::Options::default());
//! assert!(files.iter().any(|file| file.path == "px4.ts" && file.text.contains("export interface Wind")));
//! ```

mod comment;
mod error_code;
mod item;
mod labels;
mod language;
mod types;

use self::comment::header;
use self::language::Language;
use super::binding::{Module, labels, modules};
#[cfg(feature = "files")]
use super::emitter::{Input, Output};
use super::file::OutputFile;
#[cfg(feature = "files")]
use crate::failure::Failure;
use crate::schema::Schema;
use crate::translation::Translations;

/// How modules are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Deserialize), serde(rename_all = "snake_case"))]
pub enum Form {
    /// As TypeScript, to stand among other source files: `px4.ts`.
    #[default]
    Source,
    /// As a package ships it: `px4.js` and `px4.cjs`, for ECMAScript modules and `CommonJS`, with `px4.d.ts` and
    /// `px4.d.cts`, their types.
    Compiled,
}

/// How TypeScript is emitted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "files", derive(serde::Deserialize), serde(default, deny_unknown_fields))]
pub struct Options {
    /// How modules are written.
    pub form: Form,
}

#[cfg(feature = "files")]
impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, input.translations, self))
    }
}

/// Emits a module for each package, the index and, where there are translations, the labels; sorted by path.
pub fn emit(schema: &Schema, translations: &Translations, options: &Options) -> Vec<OutputFile> {
    let modules = modules(schema);
    let labels = labels(schema, translations);
    let languages: &[Language] = match options.form {
        Form::Source => &[Language::TypeScript],
        Form::Compiled => &[Language::JavaScript, Language::CommonJs, Language::Declarations],
    };
    let mut files = Vec::new();
    for language in languages {
        let path = |name: &str| format!("{name}.{}", language.ending());
        files.push(OutputFile { path: path("index"), text: index(&modules, *language) });
        let of_packages = modules.iter();
        files.extend(
            of_packages
                .map(|module| OutputFile { path: path(&module.name), text: package(module, *language) }),
        );
        files.extend(labels.iter().flat_map(|labels| labels::files(labels, *language)));
    }
    if options.form == Form::Compiled {
        let typed = files.iter().filter_map(|file| file.path.strip_suffix(".d.cts"));
        let twins: Vec<OutputFile> = typed.map(types_of_module).collect();
        files.extend(twins);
    }
    files.sort_by(|left, right| left.path.cmp(&right.path));
    files
}

/// The types of an ECMAScript module: those of its twin, so that they stand in the package once.
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
        let (name, ending) = (&module.name, language.imported_ending());
        let documentation = comment::block(&module.text, "");
        if language == Language::CommonJs {
            format!("{documentation}exports.{name} = require(\"./{name}.{ending}\");\n")
        } else {
            format!("{documentation}export * as {name} from \"./{name}.{ending}\";\n")
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
        let ending = language.imported_ending();
        let imports = module.imports.iter();
        text.extend(imports.map(|name| format!("import type * as {name} from \"./{name}.{ending}\";\n")));
        text.push('\n');
    }
    let mut items: Vec<String> =
        module.declarations.iter().map(|declaration| item::declaration(declaration, language)).collect();
    if !module.error_codes.is_empty() {
        items.extend(error_code::items(&module.error_codes, language));
    }
    items.retain(|item| !item.is_empty());
    if items.is_empty() && language != Language::CommonJs {
        // Without an export it would be no module.
        items.push("export {};\n".to_owned());
    }
    text + &items.join("\n")
}
