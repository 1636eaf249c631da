//! Python: a module for each package, with the types of its messages as JSON (`TypedDict`), its constants, enums and
//! error codes. For Python 3.9 and later; before 3.11 it takes `typing_extensions`.
//!
//! Names are those of [`super::typescript`]. Whatever else is known of a value – its range, its unit, its length –
//! stands in the text below it: types of Python can't say it, the JSON Schemas do.
//!
//! # Values
//!
//! The types are those of what `json.loads` gives: integers of any size are `int`, arrays are `list`, also where each
//! position has a meaning of its own; floats may be `None`, which stands for NaN.
//!
//! Annotations are evaluated when a module is imported: the classes know at run time, too, which keys may be left out.
//!
//! # Open sets
//!
//! A field that holds an enum is an `int`; the class of the enum names the values that are known, and keeps all others:
//! `FlightMode(message["mode"])` never fails.
//!
//! # Labels
//!
//! Where definitions are translated, `labels` gives what they say in a language of the user, and each language is a
//! module of its own, which is imported when a program asks for it.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_codegen::{emit::python, translation::Translations};
//!
//! let files = python::emit(&schema, &Translations::default());
//! assert!(files.iter().any(|file| file.path == "px4.py" && file.text.contains("class Wind(")));
//! ```

mod error_code;
mod item;
mod labels;
mod text;
mod types;
mod uses;

use std::collections::BTreeSet;

use self::text::header;
use self::uses::Uses;
use super::binding::{ERROR_CODE, Kind, Module, SEVERITY, labels, modules};
#[cfg(feature = "files")]
use super::emitter::{Input, Output};
use super::file::OutputFile;
#[cfg(feature = "files")]
use crate::failure::Failure;
use crate::schema::Schema;
use crate::translation::Translations;

/// The module of the class that enums derive from.
const OPEN_ENUM: &str = "_open_enum";

/// Options of the emitter: none.
#[cfg(feature = "files")]
#[derive(Debug, Default, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Options {}

#[cfg(feature = "files")]
impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, input.translations))
    }
}

/// Emits a module for each package, what they share and, where there are translations, the labels; sorted by path.
pub fn emit(schema: &Schema, translations: &Translations) -> Vec<OutputFile> {
    let modules = modules(schema);
    let mut files = vec![
        OutputFile { path: "__init__.py".to_owned(), text: init(&modules) },
        OutputFile { path: "py.typed".to_owned(), text: String::new() },
    ];
    let mut is_open_enum_used = false;
    for module in &modules {
        let mut uses = Uses::default();
        let body = body(module, &mut uses);
        is_open_enum_used |= uses.is_open_enum_used;
        let text = head(module, &uses) + &body;
        files.push(OutputFile { path: format!("{}.py", module.name), text });
    }
    if is_open_enum_used {
        files.push(OutputFile { path: format!("{OPEN_ENUM}.py"), text: open_enum() });
    }
    files.extend(labels(schema, translations).iter().flat_map(labels::files));
    files.sort_by(|left, right| left.path.cmp(&right.path));
    files
}

fn init(modules: &[Module]) -> String {
    let imports = modules.iter().map(|module| format!("from . import {}\n", module.name));
    let names = modules.iter().map(|module| format!("\"{}\"", module.name)).collect::<Vec<_>>().join(", ");
    format!(
        "{}\"\"\"Types of drone interface definitions, one module a package.\"\"\"\n\n{}\n__all__ = [{names}]\n",
        header("the definitions"),
        imports.collect::<String>()
    )
}

fn head(module: &Module, uses: &Uses) -> String {
    let mut text = header(&format!("the definitions of package {}", text::line(&module.package)));
    text.push_str(&text::docstring(&module.text, ""));
    let mut imports = Vec::new();
    imports.extend((!uses.recent.is_empty()).then(|| "import sys\n".to_owned()));
    imports.extend(uses.is_flags_used.then(|| "from enum import IntFlag\n".to_owned()));
    let list = |names: &BTreeSet<&str>| names.iter().copied().collect::<Vec<_>>().join(", ");
    imports.extend((!uses.typing.is_empty()).then(|| format!("from typing import {}\n", list(&uses.typing))));
    if !imports.is_empty() {
        text.push('\n');
        text.push_str(&imports.concat());
    }
    let mut own: Vec<String> = module.imports.iter().map(|name| format!("from . import {name}\n")).collect();
    own.extend(uses.is_open_enum_used.then(|| format!("from .{OPEN_ENUM} import OpenIntEnum\n")));
    if !own.is_empty() {
        text.push('\n');
        text.push_str(&own.concat());
    }
    if !uses.recent.is_empty() {
        let names = list(&uses.recent);
        text.push_str("\nif sys.version_info >= (3, 11):\n");
        text.extend(["    from typing import ", &names, "\n"]);
        text.extend(["else:\n    from typing_extensions import ", &names, "\n"]);
    }
    text
}

fn body(module: &Module, uses: &mut Uses) -> String {
    let is_declared = |kind: &Kind| !matches!(kind, Kind::Messages(_));
    let declarations = module.declarations.iter().filter(|declaration| is_declared(&declaration.kind));
    let mut names: Vec<&str> = declarations.clone().map(|declaration| declaration.name.as_str()).collect();
    let mut items: Vec<String> =
        declarations.map(|declaration| item::declaration(declaration, uses)).collect();
    if !module.error_codes.is_empty() {
        names.extend([ERROR_CODE, SEVERITY]);
        items.push(error_code::item(&module.error_codes, uses));
    }
    let names: String = names.into_iter().map(|name| format!("    \"{name}\",\n")).collect();
    let all = if names.is_empty() {
        "\n__all__: list[str] = []\n".to_owned()
    } else {
        format!("\n__all__ = [\n{names}]\n")
    };
    items.into_iter().fold(all, |text, item| text + "\n\n" + &item)
}

fn open_enum() -> String {
    header("the definitions")
        + r#""""Enums that keep values which they have no name for."""

from enum import IntEnum
from typing import Any


class OpenIntEnum(IntEnum):
    """Integers, some of which have names. Any other integer is a value too, called `UNKNOWN_` and the number."""

    @classmethod
    def _missing_(cls, value: object) -> Any:
        if not isinstance(value, int):
            return None
        found = int.__new__(cls, value)
        found._name_ = f"UNKNOWN_{value}"
        found._value_ = value
        return found
"#
}
