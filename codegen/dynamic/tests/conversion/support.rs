//! Packages and hints for the tests of conversions.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;
use uavspec_dynamic::conversion::{Conversion, Conversions, Converter, Hints, read_hints};
use uavspec_dynamic::{DynamicMessage, Types};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, MessageId, PackageInput, Schema, SourceMap, diagnostic, read};

use super::reference::convert_json;

/// The hints that the project publishes.
pub(super) const PX4_HINTS: &str = include_str!("../../../../definitions/hints/px4.toml");

/// The definitions of a package: names of messages and texts.
pub(super) type Definitions<'d> = &'d [(&'d str, &'d str)];

/// Two packages, `old` and `new`, and their conversions.
pub(super) struct Converted {
    pub(super) sources: SourceMap,
    pub(super) schema: Schema,
    pub(super) hints: Hints,
    pub(super) conversions: Conversions,
}

pub(super) fn convert(old: Definitions<'_>, new: Definitions<'_>, hints: &str) -> Converted {
    convert_dialect(Dialect::Px4, old, new, hints)
}

pub(super) fn convert_dialect(
    dialect: Dialect,
    old: Definitions<'_>,
    new: Definitions<'_>,
    hints: &str,
) -> Converted {
    let mut sources = SourceMap::default();
    let packages = [("old", old), ("new", new)].map(|(package, definitions)| {
        let ids = definitions.iter().map(|(name, text)| {
            sources.add(format!("{package}/{name}.msg"), text.as_bytes().to_vec()).expect("a source")
        });
        PackageInput::new(package, Form::Msg(dialect), ids.collect())
    });
    let (schema, diagnostics) = read(&sources, &packages);
    assert!(!diagnostic::has_errors(&diagnostics), "{diagnostics:?}");
    let source = sources.add("hints.toml", hints.as_bytes().to_vec()).expect("a source");
    let hints = read_hints(&sources, source);
    let conversions = Conversions::within(&schema, "old", "new", &hints).expect("both packages");
    Converted { sources, schema, hints, conversions }
}

impl Converted {
    /// The conversion between the messages with these names.
    pub(super) fn find(&self, is_forward: bool, from: &str, to: &str) -> &Conversion {
        let all = if is_forward { &self.conversions.forward } else { &self.conversions.backward };
        let name = |id: MessageId| self.schema.message(id).name.as_str();
        let mut found = all.iter().filter(|found| name(found.from) == from && name(found.to) == to);
        found.next().unwrap_or_else(|| panic!("no conversion of {from} to {to}"))
    }

    pub(super) fn forward(&self, name: &str) -> &Conversion {
        self.find(true, name, name)
    }

    pub(super) fn backward(&self, name: &str) -> &Conversion {
        self.find(false, name, name)
    }

    /// The initial message of a type, with `fields` set.
    pub(super) fn message(&self, id: MessageId, fields: &str) -> Value {
        let types = Types::new(&self.schema);
        let mut message = types.get(id).default().to_json().expect("JSON");
        let fields: BTreeMap<String, Value> = serde_json::from_str(fields).expect("JSON");
        for (name, value) in fields {
            assert!(message.get(&name).is_some(), "no field {name}");
            message[name] = value;
        }
        types.get(id).from_json(&message).expect("a message").to_json().expect("JSON")
    }

    pub(super) fn run(&self, conversion: &Conversion, message: &Value) -> Value {
        let initial = self.message(conversion.to, "{}");
        let converted = convert_json(&self.schema, conversion, message, &initial);
        self.check_memory(conversion, message, &converted);
        converted
    }

    /// Compares the conversion in memory with the reference.
    fn check_memory(&self, conversion: &Conversion, message: &Value, expected: &Value) {
        let types = Types::new(&self.schema);
        let [source, target] = [conversion.from, conversion.to].map(|id| types.get(id));
        let message = source.from_json(message).expect("a message");
        let converter = Converter::new(conversion, source, target);
        let actual = converter.convert(&message).expect("a message");
        assert_eq!(actual.to_json().expect("JSON"), *expected, "{message:?}");
        if converter.keeps_cdr() {
            let cdr = |message: &DynamicMessage<'_>| message.to_cdr(ByteOrder::LittleEndian);
            assert_eq!(cdr(&actual), cdr(&message));
        }
    }

    /// Converts a message with these fields.
    pub(super) fn converted(&self, conversion: &Conversion, fields: &str) -> Value {
        assert!(conversion.is_decided(), "{:?}", conversion.undecided);
        self.run(conversion, &self.message(conversion.from, fields))
    }

    /// All undecided parts and mistakes, as text.
    pub(super) fn problems(&self) -> String {
        let mut text = String::new();
        for found in self.conversions.undecided() {
            writeln!(text, "{}", found.message).expect("a string");
        }
        for found in self.hints.mistakes.iter().chain(&self.conversions.mistakes) {
            let position = self.sources.position(found.span);
            writeln!(text, "{}:{}: {}", position.line, position.column, found.message).expect("a string");
        }
        text
    }
}
