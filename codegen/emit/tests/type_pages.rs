//! Random pages of types and messages. The model, the schemas, the vectors and `fmt` must agree on each page.

use std::fmt::Write as _;

use jsonschema::{Registry, Resource};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::{Value as Json, json};
use uavspec_emit::{inspect, json_schema, vectors};
use uavspec_schema::{Form, Schema, SourceMap, render};
use uavspec_test_definitions as support;

/// A field or an element.
#[derive(Clone, Debug)]
struct Member {
    is_required: bool,
    ty: String,
    annotations: &'static str,
}

/// A type, as written on a page.
#[derive(Clone, Debug)]
enum Type {
    Object(Vec<Member>, bool),
    Tuple(Vec<Member>),
    Set(Vec<&'static str>, bool),
    Named(String, &'static str),
}

const BUILT_IN: [&str; 7] = ["string", "integer", "number", "boolean", "null", "any", "one of a, b, \"c d\""];

/// Annotations for numbers, strings and lists.
const OF_NUMBERS: [&str; 4] = ["[m/s]", "[@range -5, 9]", "[@range 1,]", "[@range , 0.5]"];
const OF_STRINGS: [&str; 4] =
    ["[@length 1, 4]", "[@pattern `^[a-z]{2}$`]", "[@length 2,]", "[@format base64]"];
const OF_LISTS: [&str; 3] = ["[@length 1, 3]", "[@unique]", "[@length , 2] [@unique]"];

/// An expression without type names, with suitable annotations.
fn plain() -> impl Strategy<Value = (String, &'static str)> {
    prop_oneof![
        select(&BUILT_IN[..]).prop_map(|ty| (ty.to_owned(), "")),
        (
            select(&["integer", "number", "list of integer", "number or null", "map of number"][..]),
            select(&OF_NUMBERS[..])
        )
            .prop_map(|(ty, annotations)| (ty.to_owned(), annotations)),
        (select(&["string", "string or null"][..]), select(&OF_STRINGS[..]))
            .prop_map(|(ty, annotations)| (ty.to_owned(), annotations)),
        (
            select(&["list of string", "list of list of integer", "list of any or null"][..]),
            select(&OF_LISTS[..])
        )
            .prop_map(|(ty, annotations)| (ty.to_owned(), annotations)),
    ]
}

/// An expression for the type with the number `own`. The expression may refer to earlier types.
fn member(own: usize) -> impl Strategy<Value = Member> {
    let named = (0..own.max(1), select(&["", "list of ", "map of ", "list of list of "][..]), any::<bool>());
    let named = named.prop_map(move |(index, around, is_nullable)| {
        let name = if own == 0 { "string".to_owned() } else { format!("Type{index}") };
        (format!("{around}{name}{}", if is_nullable { " or null" } else { "" }), "")
    });
    let ty = prop_oneof![2 => plain(), 1 => named];
    (any::<bool>(), ty).prop_map(|(is_required, (ty, annotations))| Member { is_required, ty, annotations })
}

fn type_strategy(own: usize) -> impl Strategy<Value = Type> {
    let values = prop_oneof![Just(vec!["0", "7", "-3"]), Just(vec!["calm", "\"1\"", "two words"])];
    prop_oneof![
        3 => (vec(member(own), 0..5), any::<bool>()).prop_map(|(fields, is_closed)| Type::Object(fields, is_closed)),
        2 => vec(member(own), 1..5).prop_map(|mut elements| {
            // Required elements come first.
            elements.sort_by_key(|element| !element.is_required);
            Type::Tuple(elements)
        }),
        1 => (values, any::<bool>()).prop_map(|(values, is_open)| Type::Set(values, is_open)),
        1 => plain().prop_filter("a named type starts with a built-in type", |(ty, _)| !ty.starts_with("one of"))
            .prop_map(|(ty, annotations)| Type::Named(ty, annotations)),
    ]
}

fn types() -> impl Strategy<Value = Vec<Type>> {
    (type_strategy(0), type_strategy(1), type_strategy(2), type_strategy(3))
        .prop_map(|(first, second, third, fourth)| vec![first, second, third, fourth])
}

/// A page that defines the types, and a message with a field of the last type in each direction.
fn page(types: &[Type]) -> String {
    let yes = |is_required: bool| if is_required { "yes" } else { "no" };
    let mut page = String::from("# Winds\n");
    let objects = "|Field|Required|Type|Description|\n|-|-|-|-|\n";
    for (index, ty) in types.iter().enumerate() {
        write!(page, "\n## Type{index}\n\n").expect("a string");
        match ty {
            Type::Object(fields, is_closed) => {
                let closed = if *is_closed { "Closed object." } else { "Further fields are allowed." };
                write!(page, "{closed}\n\n{objects}").expect("a string");
                for (index, Member { is_required, ty, annotations }) in fields.iter().enumerate() {
                    let required = yes(*is_required);
                    writeln!(page, "|field{index}|{required}|{ty}|{annotations} Field|").expect("a string");
                }
            }
            Type::Tuple(elements) => {
                page.push_str("|Index|Element|Required|Type|Description|\n|-|-|-|-|-|\n");
                for (index, Member { is_required, ty, annotations }) in elements.iter().enumerate() {
                    let required = yes(*is_required);
                    writeln!(page, "|{index}|part{index}|{required}|{ty}|{annotations} Part|")
                        .expect("a string");
                }
            }
            Type::Set(values, is_open) => {
                let openness = if *is_open { "An open set." } else { "A closed set." };
                write!(page, "{openness}\n\n|Value|Description|\n|-|-|\n").expect("a string");
                for value in values {
                    writeln!(page, "|{value}|x|").expect("a string");
                }
            }
            Type::Named(ty, annotations) => writeln!(page, "{ty}, {annotations} by name").expect("a string"),
        }
    }
    let last = types.len() - 1;
    for direction in ["Request", "Response", "Notification"] {
        let start = if direction == "Request" { "\n## WIND-INF\n" } else { "" };
        write!(page, "{start}\n### {direction}\n\n{objects}|value|yes|Type{last}|x|\n").expect("a string");
    }
    page
}

fn read_page(text: &str) -> (SourceMap, Schema) {
    let (sources, schema, diagnostics) = support::texts(Form::Table, &[("page.md", text)]);
    assert!(diagnostics.is_empty(), "{}\n{text}", render::render(&diagnostics, &sources, false));
    (sources, schema)
}

proptest! {
    #![proptest_config(support::config(64))]

    #[test]
    fn types_are_read_as_written(types in types()) {
        let (_, schema) = read_page(&page(&types));
        let model = inspect::schema(&schema)["packages"]["demo"].clone();
        for (index, ty) in types.iter().enumerate() {
            let found = &model["types"][format!("Type{index}")];
            let same = |found: &Json, members: &[Member]| -> bool {
                let found = found.as_array().expect("members");
                found.len() == members.len() && found.iter().zip(members).all(|(found, member)| {
                    found["type"] == json!(member.ty) && found["required"] == json!(member.is_required)
                })
            };
            let is_same = match ty {
                Type::Object(fields, is_closed) => same(&found["fields"], fields) && found["closed"] == json!(is_closed),
                Type::Tuple(elements) => same(&found["elements"], elements),
                Type::Set(values, is_open) => {
                    found["open"] == json!(is_open) && found["values"].as_array().expect("values").len() == values.len()
                }
                Type::Named(ty, _) => found["type"] == json!(ty),
            };
            prop_assert!(is_same, "{ty:?}: {found}");
        }
        prop_assert_eq!(&model["json_messages"]["WIND-INF"]["request"]["answers"], &json!(["WIND-INF"]));
    }

    /// Compares the verdicts in vectors, which come from the model, with the verdicts of an independent JSON Schema
    /// validator.
    #[test]
    fn schemas_and_vectors_agree(types in types()) {
        let (_, schema) = read_page(&page(&types));
        let resources = json_schema::emit(&schema, &json_schema::Options::default()).into_iter().map(|file| {
            let schema: Json = serde_json::from_str(&file.text).expect("JSON");
            jsonschema::meta::validate(&schema).expect("a schema");
            (schema["$id"].as_str().expect("an address").to_owned(), Resource::from_contents(schema))
        });
        let registry = Registry::new().extend(resources).expect("addresses").prepare().expect("references");
        let mut count = 0;
        for file in vectors::emit(&schema, &vectors::Options::default()) {
            if !file.path.ends_with(".vectors.json") {
                continue;
            }
            let file: Json = serde_json::from_str(&file.text).expect("JSON");
            let reference = json!({ "$ref": file["schema"] });
            let validator = jsonschema::options().with_registry(&registry).build(&reference).expect("a schema");
            for case in file["cases"].as_array().expect("cases") {
                prop_assert_eq!(json!(validator.is_valid(&case["json"])), case["valid"].clone(), "{} {}", file["type"], case);
                count += 1;
            }
        }
        prop_assert!(count > 20);
    }

    /// `fmt` formats only error codes: it must preserve types, and a second run must change nothing.
    #[test]
    fn fmt_preserves_types_of_pages(types in types()) {
        let (sources, schema) = read_page(&page(&types));
        let id = sources.source_of(uavspec_schema::source::Span::default());
        let laid_out = uavspec_lint::format::format(&sources, id, Form::Table).expect("no errors");
        let (_, again) = read_page(&laid_out.text);
        prop_assert_eq!(inspect::schema(&schema), inspect::schema(&again));
    }
}
