//! Python modules. Each package is a module with the JSON types of its messages (`TypedDict`), its constants, enums and
//! error codes. The modules require Python 3.9 or later, and `typing_extensions` before Python 3.11.
//!
//! The names match those of [`super::typescript`]. No class or module has the name of a Python builtin, and no field hides
//! a name that its class uses. Properties that Python types can't express, such as ranges, units and lengths, are in
//! docstrings. The JSON Schemas check these properties.
//!
//! # Values
//!
//! The types match the results of `json.loads`. All integers are `int`. All arrays are `list`, even tuples, whose
//! positions have different meanings. Floats may be `None`, which represents NaN.
//!
//! Annotations are evaluated on import, so each class has its set of optional keys at run time.
//!
//! # Open sets
//!
//! A field with an enum has the type `Union["FlightMode", int]`. A message may contain the members of the enum or any
//! other integer. The result of `json.loads` contains an `int`, which compares equal to its member. The enum class
//! names the known values and accepts all others: `FlightMode(message["mode"])` never fails.
//!
//! # Labels
//!
//! If there are translations, the `labels` package provides the text of the definitions in all languages. Each language
//! is a module that is imported on demand.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::python;
//! use uavspec_schema::translation::Translations;
//!
//! let files = python::emit(&schema, &Translations::default());
//! assert!(files.iter().any(|file| file.path == "px4.py" && file.text.contains("class Wind(")));
//! ```

mod error_code;
mod event;
mod item;
mod labels;
mod text;
mod types;
mod uses;

use std::collections::BTreeSet;

use uavspec_schema::Schema;
use uavspec_schema::failure::Failure;
use uavspec_schema::translation::Translations;

use self::text::header;
use self::uses::Uses;
use super::binding::{ERROR_CODE, Kind, Module, SEVERITY, labels, modules};
use super::emitter::{Input, Output};
use super::file::OutputFile;

/// Name of the module that contains the base class for enums.
const OPEN_ENUM: &str = "_open_enum";

/// The emitter has no options.
#[derive(Debug, Default, schemars::JsonSchema, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Options {}

impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, input.translations))
    }
}

/// Creates a module for each package, shared modules, and labels if there are translations. Files are sorted by path.
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
    if modules.iter().any(|module| module.events.is_some()) {
        files.push(event::module());
    }
    files.extend(labels(schema, translations).iter().flat_map(labels::files));
    OutputFile::sort(&mut files);
    files
}

fn init(modules: &[Module]) -> String {
    let imports = modules.iter().map(|module| format!("from . import {}\n", module.name));
    let names = modules.iter().map(|module| format!("\"{}\"", module.name)).collect::<Vec<_>>().join(", ");
    format!(
        "{}\"\"\"Types of drone interface definitions. Each package is a module.\"\"\"\n\n{}\n__all__ = [{names}]\n",
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
    let mut local: Vec<String> =
        module.imports.iter().map(|name| format!("from . import {name}\n")).collect();
    local.extend(module.events.is_some().then(event::import));
    local.extend(uses.is_open_enum_used.then(|| format!("from .{OPEN_ENUM} import OpenIntEnum\n")));
    if !local.is_empty() {
        text.push('\n');
        text.push_str(&local.concat());
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
    if let Some(events) = &module.events {
        uses.typing.insert("Optional");
        names.extend(event::NAMES);
        items.push(event::item(events));
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
        + r#""""Enums that accept unnamed values."""

from enum import IntEnum
from typing import Any


class OpenIntEnum(IntEnum):
    """Named integers. Unnamed integers are valid too; their name is `UNKNOWN_` followed by the number."""

    @classmethod
    def _missing_(cls, value: object) -> Any:
        if not isinstance(value, int):
            return None
        number = int(value)
        found = int.__new__(cls, number)
        found._name_ = f"UNKNOWN_{number}"
        found._value_ = number
        return found
"#
}
