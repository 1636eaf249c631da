//! Tests of the emitted JSON Schemas with valid and invalid instances.

use std::collections::BTreeMap;
use std::fs;

use jsonschema::error::ValidationErrorKind;
use jsonschema::{Registry, Resource, Validator};
use serde_json::{Value as Json, json};
use uavspec_emit::OutputFile;
use uavspec_emit::json_schema::{DEFAULT_BASE, Options, emit};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Diagnostic, Form, Schema, SourceMap, read, render};
use uavspec_test_definitions as support;

const PX4: Form = Form::Msg(Dialect::Px4);
const ROS2: Form = Form::Msg(Dialect::Ros2);

/// Keywords with the same meaning in draft 7 and in all drafts since 2019-09. There are two exceptions. Older drafts
/// ignore `prefixItems`. Draft 7 has `definitions` instead of `$defs`, but allows references to `$defs`. A strict
/// validator rejects all other keywords.
const KEYWORDS: [&str; 27] = [
    "$schema",
    "$id",
    "$comment",
    "$ref",
    "$defs",
    "title",
    "description",
    "default",
    "type",
    "const",
    "anyOf",
    "oneOf",
    "allOf",
    "properties",
    "required",
    "additionalProperties",
    "items",
    "minItems",
    "maxItems",
    "minimum",
    "maximum",
    "minLength",
    "maxLength",
    "pattern",
    "uniqueItems",
    "contentEncoding",
    "prefixItems",
];

/// All emitted documents by path.
struct Documents {
    by_path: BTreeMap<String, Json>,
    registry: Registry<'static>,
}

impl Documents {
    fn of(files: &[OutputFile]) -> Self {
        let by_path: BTreeMap<String, Json> = files
            .iter()
            .map(|file| (file.path.clone(), serde_json::from_str(&file.text).expect("a schema is JSON")))
            .collect();
        assert_eq!(by_path.len(), files.len(), "two files have the same path");
        let resources = by_path.values().map(|document| {
            let id = document["$id"].as_str().expect("an absolute address").to_owned();
            (id, Resource::from_contents(document.clone()))
        });
        let registry =
            Registry::new().extend(resources).expect("addresses").prepare().expect("valid references");
        Self { by_path, registry }
    }

    fn read(sources: &SourceMap, schema: &Schema, diagnostics: &[Diagnostic]) -> Self {
        assert!(!has_errors(diagnostics), "{}", render::render(diagnostics, sources, false));
        Self::of(&emit(schema, &Options::default()))
    }

    fn texts(form: Form, files: &[(&str, &str)]) -> Self {
        let (sources, schema, diagnostics) = support::texts(form, files);
        Self::read(&sources, &schema, &diagnostics)
    }

    /// A validator for the schema at `address`, relative to the base URL.
    fn validator(&self, address: &str) -> Validator {
        let schema = json!({ "$ref": format!("{DEFAULT_BASE}{address}") });
        jsonschema::options().with_registry(&self.registry).build(&schema).expect("a valid schema")
    }

    /// True if the schema of `demo/name` accepts `instance`. The schema file and its copy in the bundle must agree.
    fn accepts(&self, name: &str, instance: &Json) -> bool {
        let file = self.validator(&format!("demo/{name}.schema.json")).is_valid(instance);
        let definition = name.replace('/', ".");
        let bundle =
            self.validator(&format!("demo.bundle.schema.json#/$defs/{definition}")).is_valid(instance);
        assert_eq!(file, bundle, "file and bundle disagree on {instance}");
        file
    }

    fn expect(&self, name: &str, field: &str, good: &[Json], bad: &[Json]) {
        for value in good {
            assert!(self.accepts(name, &json!({ field: value })), "{name}.{field} should accept {value}");
        }
        for value in bad {
            assert!(!self.accepts(name, &json!({ field: value })), "{name}.{field} should reject {value}");
        }
    }

    fn field(&self, name: &str, field: &str) -> &Json {
        &self.by_path[&format!("demo/{name}.schema.json")]["properties"][field]
    }
}

/// A px4 message `A` with one field, and additional declarations.
fn px4_field(text: &str) -> Documents {
    Documents::texts(PX4, &[("A.msg", text)])
}

fn number(text: &str) -> Json {
    serde_json::from_str(text).expect("a number")
}

#[test]
fn bounds_integers_by_their_type() {
    for (ty, min, below, max, above) in [
        ("int8", "-128", "-129", "127", "128"),
        ("uint8", "0", "-1", "255", "256"),
        ("int32", "-2147483648", "-2147483649", "2147483647", "2147483648"),
        ("uint32", "0", "-1", "4294967295", "4294967296"),
        (
            "int64",
            "-9223372036854775808",
            "-9223372036854777856",
            "9223372036854775807",
            "9223372036854775808",
        ),
        ("uint64", "0", "-1", "18446744073709551615", "18446744073709551616"),
    ] {
        let good = [number(min), number(max), json!(0)];
        let bad =
            [number(below), number(above), json!(1.5), json!("1"), json!(null), json!(true), json!([1])];
        px4_field(&format!("{ty} a\n")).expect("A", "a", &good, &bad);
    }
    let documents = px4_field("uint64 a\n");
    assert_eq!(
        documents.field("A", "a")["maximum"].to_string(),
        "18446744073709551615",
        "all digits are preserved"
    );
}

#[test]
fn accepts_null_as_nan_for_floats() {
    let bad = [json!("NaN"), json!(false), json!(3.5e38), json!(-1e39)];
    let forms_of_the_greatest = ["3.4028235e38", "3.40282347e38", "3.4028234663852886e38"];
    let good: Vec<Json> =
        forms_of_the_greatest.into_iter().map(number).chain([json!(null), json!(-0.1)]).collect();
    px4_field("float32 a\n").expect("A", "a", &good, &bad);
    px4_field("float64 a\n").expect(
        "A",
        "a",
        &[json!(f64::MAX), json!(f64::MIN), json!(null)],
        &[json!("1")],
    );
}

#[test]
fn rejects_numbers_and_null_for_bools() {
    px4_field("bool a  # [@range 0, 1]\n").expect(
        "A",
        "a",
        &[json!(true), json!(false)],
        &[json!(1), json!(null)],
    );
}

#[test]
fn requires_all_fields_and_no_others() {
    let documents = px4_field("uint8 a\nuint8 b\n");
    assert!(documents.accepts("A", &json!({ "b": 1, "a": 2 })));
    for bad in [json!({ "a": 1 }), json!({ "a": 1, "b": 2, "c": 3 }), json!({}), json!([1, 2]), json!(null)] {
        assert!(!documents.accepts("A", &bad), "{bad}");
    }
    let empty = px4_field("");
    assert!(empty.accepts("A", &json!({})) && !empty.accepts("A", &json!({ "a": 1 })));
}

#[test]
fn enforces_ranges_except_for_special_values() {
    let documents = px4_field("float32 a  # [@range 0, 1] [@invalid -1 unknown] [@uncontrolled 7]\n");
    let good = [json!(0), json!(1.0), json!(0.5), json!(-1), json!(-1.0), json!(7), json!(null)];
    documents.expect("A", "a", &good, &[json!(-0.5), json!(-2), json!(1.1), json!(8), json!("x")]);
    let one_sided = px4_field("float32 a  # [@range 1,] [@invalid -1]\n");
    one_sided.expect("A", "a", &[json!(1), json!(3e38), json!(-1)], &[json!(0), json!(-2), json!(4e38)]);
    let within = px4_field("uint8 a  # [@range 1, 100] [@invalid 50]\n");
    within.expect("A", "a", &[json!(1), json!(100)], &[json!(0), json!(101)]);
    let max = px4_field("uint16 a  # [@range 0, 10] [@invalid UINT16_MAX]\n");
    max.expect("A", "a", &[json!(10), json!(65535)], &[json!(11), json!(65534), json!(65536), json!(null)]);
    let constant = px4_field("uint8 NONE = 9\nuint8 a  # [@range 0, 3] [@invalid NONE]\n");
    constant.expect("A", "a", &[json!(9)], &[json!(8)]);
}

#[test]
fn enforces_ranges_for_array_elements() {
    let documents = px4_field("float32[2] a  # [@range -1, 1] [@invalid 9]\n");
    documents.expect(
        "A",
        "a",
        &[json!([0, null]), json!([9, 1])],
        &[json!([0, 2]), json!([0]), json!([0, 0, 0])],
    );
}

#[test]
fn a_float32_nearest_to_a_bound_is_within() {
    let pi =
        [json!(f64::from(std::f32::consts::PI)), json!(std::f32::consts::PI), json!(std::f64::consts::PI)];
    px4_field("float32 a  # [@range -pi, pi]\n").expect("A", "a", &pi, &[json!(3.15), json!(-3.15)]);
    let tenth = [json!(0.1), json!(f64::from(0.1_f32))];
    px4_field("float32 a  # [@range 1, 2] [@invalid 0.1]\n").expect(
        "A",
        "a",
        &tenth,
        &[json!(0.11), json!(0.09)],
    );
}

#[test]
fn limits_counts_to_the_length_of_the_array() {
    let text = "uint8 n  # [@count list]\nuint8[3] list\n";
    let documents = px4_field(text);
    let message = |count: u8| json!({ "n": count, "list": [1, 2, 3] });
    assert!(documents.accepts("A", &message(3)) && !documents.accepts("A", &message(4)));
    assert_eq!(documents.field("A", "n")["$defs"]["annotations"]["x-count-of"], "list");
    let inferred = Documents::texts(ROS2, &[("A.msg", "uint8 num_list\nuint8[<=3] list\n")]);
    assert!(!inferred.accepts("A", &json!({ "num_list": 4, "list": [] })));
    let unbounded = Documents::texts(ROS2, &[("A.msg", "uint8 num_list\nuint8[] list\n")]);
    assert!(unbounded.accepts("A", &json!({ "num_list": 200, "list": [] })));
}

#[test]
fn names_enum_values_and_accepts_others() {
    let text = "uint8 MODE_OFF = 0  # All off\nuint8 MODE_ON = 1\nuint8 MODE_RUN = 1  # The same\nuint8 a  # [@enum MODE]\n";
    let documents = px4_field(text);
    documents.expect(
        "A",
        "a",
        &[json!(0), json!(1), json!(200)],
        &[json!(256), json!(-1), json!("OFF"), json!(null)],
    );
    let expected = json!([
        { "const": 0, "title": "OFF", "description": "All off" },
        { "const": 1, "title": "ON" },
        { "const": 1, "title": "RUN", "description": "The same" },
        { "type": "integer" }
    ]);
    assert_eq!(documents.field("A", "a")["anyOf"], expected);
    let array = px4_field("uint8 M_X = 4\nuint8[2] a  # [@enum M]\n");
    array.expect("A", "a", &[json!([4, 5])], &[json!([4, 300]), json!([4])]);
    let both = px4_field("uint8 M_X = 4\nuint8 a  # [@enum M] [@range 0, 5] [@invalid 255]\n");
    both.expect("A", "a", &[json!(4), json!(255)], &[json!(6), json!(254)]);
}

#[test]
fn uses_one_of_only_for_alternatives_that_are_disjoint_as_doubles() {
    let keyword = |text: &str| {
        let documents = px4_field(text);
        let field = documents.field("A", "a");
        ["oneOf", "anyOf"].into_iter().find(|keyword| field.get(*keyword).is_some())
    };
    let text = "float32 a  # [@range 0, 1] [@invalid -1] [@uncontrolled 2]\n";
    assert_eq!(keyword(text), Some("oneOf"));
    px4_field(text).expect(
        "A",
        "a",
        &[json!(0.5), json!(-1), json!(2), json!(null)],
        &[json!(1.5), json!("0")],
    );
    assert_eq!(keyword("float32 a  # [@range 0, 1] [@invalid -1] [@uncontrolled -1]\n"), Some("anyOf"));
    // NaN is null in JSON, so it is not one of the alternatives.
    let text = "float32 a  # [@range 0, 1] [@invalid NaN] [@uncontrolled -1]\n";
    assert_eq!(keyword(text), Some("oneOf"));
    px4_field(text).expect("A", "a", &[json!(0.5), json!(-1), json!(null)], &[json!(-0.5), json!("NaN")]);
    // As 64-bit floats, the special value and the upper bound of the range are equal.
    let text = "uint64 a  # [@range 0, 18446744073709551614] [@invalid 18446744073709551615]\n";
    assert_eq!(keyword(text), Some("anyOf"));
    assert_eq!(keyword("uint64 a  # [@range 0, 7] [@invalid 18446744073709551615]\n"), Some("oneOf"));
}

#[test]
fn accepts_any_combination_of_flags() {
    let text = "uint8 F_LOW = 1\nuint8 F_HOT = 4  # Too hot\nuint8 a  # [@flags F]\n";
    let documents = px4_field(text);
    documents.expect("A", "a", &[json!(0), json!(5), json!(255)], &[json!(256)]);
    let flags = json!([{ "name": "LOW", "mask": 1 }, { "name": "HOT", "mask": 4, "description": "Too hot" }]);
    assert_eq!(documents.field("A", "a")["$defs"]["annotations"]["x-flags"], flags);
    assert_eq!(documents.field("A", "a").get("anyOf"), None);
}

#[test]
fn char_arrays_are_text_in_px4_and_numbers_in_ros() {
    let text = [json!(""), json!("abcd"), json!("µéàê")];
    px4_field("char[4] a  # [@invalid empty]\n").expect(
        "A",
        "a",
        &text,
        &[json!("abcde"), json!([1, 2, 3, 4]), json!(null)],
    );
    let numbers = Documents::texts(ROS2, &[("A.msg", "char[2] a\n")]);
    numbers.expect("A", "a", &[json!([0, 255])], &[json!("ab"), json!([0, 256]), json!([0])]);
}

#[test]
fn enforces_bounds_of_strings_and_arrays() {
    let text = "string s\nstring<=2 t\nwstring<=1 w\nbool[] u\nint8[<=2] v\nstring<=1[2] x\nbyte y\n";
    let documents = Documents::texts(ROS2, &[("A.msg", text)]);
    let whole = json!({ "s": "any", "t": "\u{1f681}é", "w": "\u{1f681}", "u": [], "v": [], "x": ["", "a"], "y": 255 });
    assert!(documents.accepts("A", &whole));
    for (field, bad) in [
        ("t", json!("abc")),
        ("w", json!("ab")),
        ("s", json!(1)),
        ("u", json!([1])),
        ("v", json!([1, 2, 3])),
        ("x", json!(["a"])),
        ("x", json!(["a", "bc"])),
        ("y", json!(-1)),
    ] {
        let mut invalid = whole.clone();
        invalid[field] = bad;
        assert!(!documents.accepts("A", &invalid), "{invalid}");
    }
}

#[test]
fn writes_defaults_as_instances() {
    let text = "float64 a 1.5\nint8[] b [1, -2]\nstring c 'x'\nbool d true\nfloat32 e nan\n";
    let documents = Documents::texts(ROS2, &[("A.msg", text)]);
    let default = |field| documents.field("A", field)["default"].clone();
    assert_eq!(default("a"), 1.5);
    assert_eq!(default("b"), json!([1, -2]));
    assert_eq!((default("c"), default("d")), (json!("x"), json!(true)));
    assert_eq!(documents.field("A", "e").get("default"), Some(&Json::Null));
}

#[test]
fn validates_nested_messages_across_files_and_in_the_bundle() {
    let mut sources = SourceMap::default();
    let mut add = |name: &str, files: &[(&str, &str)]| {
        let mut package = support::package(name, ROS2);
        package.sources =
            files.iter().map(|(path, text)| sources.add(*path, (*text).into()).expect("text")).collect();
        package
    };
    let packages = [
        add(
            "demo",
            &[
                ("Outer.msg", "Inner[<=2] list\nother/Far far\n"),
                ("Inner.msg", "int8 a\n"),
                ("Inner.srv", "Inner inner\n---\nother/Far far\n"),
            ],
        ),
        add("other", &[("Far.msg", "Near near\n"), ("Near.msg", "bool b\n"), ("Unused.msg", "bool b\n")]),
    ];
    let (schema, diagnostics) = read(&sources, &packages);
    let documents = Documents::read(&sources, &schema, &diagnostics);
    let far = |b: Json| json!({ "near": { "b": b } });
    let outer = |a: i32, b: Json| json!({ "list": [{ "a": 0 }, { "a": a }], "far": far(b) });
    assert!(documents.accepts("Outer", &outer(1, json!(true))));
    assert!(!documents.accepts("Outer", &outer(128, json!(true))));
    assert!(!documents.accepts("Outer", &outer(1, json!(0))));
    assert!(documents.accepts("srv/Inner_Request", &json!({ "inner": { "a": 1 } })));
    assert!(!documents.accepts("srv/Inner_Response", &json!({ "far": far(json!(1)) })));
    assert!(
        documents.accepts("Inner", &json!({ "a": 1 })),
        "a service must not replace a message with the same name"
    );
    let bundle = &documents.by_path["demo.bundle.schema.json"];
    let definitions: Vec<&String> = bundle["$defs"].as_object().expect("definitions").keys().collect();
    let expected =
        ["Inner", "Outer", "srv.Inner_Request", "srv.Inner_Response", "other.msg.Far", "other.msg.Near"];
    assert_eq!(definitions, expected);
    let references = bundle.to_string().matches("\"$ref\":\"#/$defs/").count();
    assert_eq!(
        references,
        bundle.to_string().matches("\"$ref\"").count(),
        "a bundle contains only internal references"
    );
}

#[test]
fn bundle_accepts_exactly_the_messages_of_its_package() {
    let documents = Documents::texts(PX4, &[("A.msg", "uint8 a\n"), ("B.msg", "uint8 b\n")]);
    let bundle = documents.validator("demo.bundle.schema.json");
    assert!(bundle.is_valid(&json!({ "a": 1 })) && bundle.is_valid(&json!({ "b": 1 })));
    assert!(!bundle.is_valid(&json!({ "c": 1 })) && !bundle.is_valid(&json!({ "a": 1, "b": 1 })));
}

const CODES: &str = "\
# Codes

## Warnings (codes 64-127)

| Code | Abbr | Description |
|-----:|------|-------------|
| 66 | LOWBAT | Low. Use it only if there is time; otherwise use code 134. |

## Errors (codes 128-191)

| Code | Abbr | Description |
|-----:|------|-------------|
| 134 | LOWBAT | Lower. |
";

#[test]
fn accepts_unlisted_error_codes_and_annotates_severities() {
    let documents = Documents::texts(Form::Table, &[("codes.md", CODES)]);
    for good in [json!(0), json!(66), json!(67), json!(300), json!(40_000)] {
        assert!(documents.accepts("ErrorCode", &good), "{good}");
    }
    for bad in [json!(-1), json!(1.5), json!("66"), json!(null), json!(4_294_967_296_u64)] {
        assert!(!documents.accepts("ErrorCode", &bad), "{bad}");
    }
    assert!(documents.accepts("ErrorList", &json!([])) && documents.accepts("ErrorList", &json!([66, 999])));
    assert!(!documents.accepts("ErrorList", &json!([66, -1])) && !documents.accepts("ErrorList", &json!(66)));
    let code = &documents.by_path["demo/ErrorCode.schema.json"]["anyOf"][0];
    assert_eq!((&code["const"], &code["title"]), (&json!(66), &json!("LOWBAT")));
    let annotations = &code["$defs"]["annotations"];
    assert_eq!(
        (&annotations["x-severity"], &annotations["x-abbreviation"]),
        (&json!("warning"), &json!("LOWBAT"))
    );
    assert_eq!(annotations["x-alternatives"], json!([134]));
}

/// A page with all features of type tables, and error codes.
fn gliders() -> Documents {
    Documents::texts(
        Form::Table,
        &[
            ("gliders.md", include_str!("../../schema/tests/fixtures/ok/type-tables/gliders.md")),
            ("codes.md", CODES),
        ],
    )
}

fn check_values(documents: &Documents, name: &str, good: &[Json], bad: &[Json]) {
    for value in good {
        assert!(documents.accepts(name, value), "{name} should accept {value}");
    }
    for value in bad {
        assert!(!documents.accepts(name, value), "{name} should reject {value}");
    }
}

#[test]
fn validates_named_types_and_sets() {
    let documents = gliders();
    let none = json!(null);
    check_values(
        &documents,
        "Instant",
        &[json!(0), json!(4_102_444_800_000_u64)],
        &[json!(-1), json!(0.5), none.clone()],
    );
    check_values(
        &documents,
        "Callsign",
        &[json!("D1")],
        &[json!(""), json!("d"), json!("ABCDEFGHI"), json!(1)],
    );
    check_values(&documents, "Phase", &[json!("towed"), json!("else")], &[json!(0), none.clone()]);
    check_values(&documents, "Fix", &[json!(0), json!(3)], &[json!(1), json!("0"), none.clone()]);
    check_values(
        &documents,
        "Marks",
        &[json!([]), json!(["D1", [1, 2]])],
        &[json!(["d"]), json!([[1]]), none],
    );
}

#[test]
fn tuples_may_omit_optional_elements_at_the_end() {
    let full = json!([1, 2, null, 3000.5]);
    let good = [json!([1, 2]), json!([1, 2, 3]), json!([1, 2, null]), full];
    let bad = [
        json!([1]),
        json!([]),
        json!([1, null]),
        json!([1, 2, 3, null]),
        json!([1, 2, 3, 3001]),
        json!([1, 2, 3, 4, 5]),
        json!([900_000_001, 2]),
        json!({ "lat": 1 }),
    ];
    check_values(&gliders(), "Mark", &good, &bad);
}

#[test]
fn closes_objects_only_if_the_page_does() {
    let documents = gliders();
    let glider = |name: &str, value: Json| json!({ "id": "D1", "time": 1, name: value });
    let good = [
        glider("fix", json!(null)),
        glider("climb", json!([-20, 20.0])),
        glider("crew", json!(["a", "b"])),
        glider("winch", json!("the middle")),
        glider("log", json!("YQ==")),
        glider("towed_by", json!({ "id": "D2", "time": 2 })),
        glider("note", json!([null])),
    ];
    let bad = [
        json!({ "id": "D1" }),
        glider("phase", json!(null)),
        glider("climb", json!([])),
        glider("climb", json!([20.5])),
        glider("crew", json!(["a", "a"])),
        glider("winch", json!("middle")),
        glider("log", json!("YQ")),
        glider("towed_by", json!({ "id": "D2" })),
        glider("else", json!(1)),
    ];
    check_values(&documents, "Glider", &good, &bad);
    let known = json!({ "type": "GLIDER-INF", "status": { "D1": { "id": "D1", "time": 1 } }, "else": 1 });
    check_values(
        &documents,
        "GLIDER-INF.notification",
        std::slice::from_ref(&known),
        &[json!({ "type": "GLIDER-INF" })],
    );
    let response = [json!({ "type": "GLIDER-INF" }), known];
    check_values(&documents, "GLIDER-INF.response", &response, &[json!({}), json!({ "type": "GLIDER" })]);
    let bundle = documents.validator("demo.bundle.schema.json");
    assert!(
        bundle.is_valid(&json!({ "type": "FIELD-CLOSE" })) && !bundle.is_valid(&json!("D1")),
        "the bundle accepts only messages"
    );
    let ack = json!({ "type": "TOWER-ACK" });
    check_values(&documents, "TOWER-ACK.response", &[ack], &[json!({ "type": "TOWER-ACK", "else": 1 })]);
}

#[test]
fn combines_restrictions_of_a_type_and_its_use() {
    let text = "# Winch\n\n## Load\n\nnumber, [N] [@range 0, 9000] What pulls.\n\n## Rope\n\n\
        |Field|Required|Type|Description|\n|-|-|-|-|\n\
        |load|no|Load or null|[@range 10, 20000] Now|\n|loads|no|list of Load|[@length 2] [@range , 50] Then|\n\
        |codes|no|ErrorList|[@length , 1] [@unique] Codes|\n";
    let documents = Documents::texts(Form::Table, &[("winch.md", text), ("codes.md", CODES)]);
    let good = [
        json!({ "load": null }),
        json!({ "load": 10 }),
        json!({ "loads": [0, 50] }),
        json!({ "codes": [66] }),
    ];
    let bad = [
        json!({ "load": 9 }),
        json!({ "load": 9001 }),
        json!({ "loads": [0] }),
        json!({ "loads": [0, 51] }),
        json!({ "codes": [66, 67] }),
        json!({ "codes": [-1] }),
    ];
    check_values(&documents, "Rope", &good, &bad);
    let annotations = &documents.by_path["demo/Load.schema.json"]["$defs"]["annotations"];
    assert_eq!((&annotations["x-unit"], &annotations["x-range"]), (&json!("N"), &json!([0, 9000])));
    assert_eq!(documents.field("Rope", "loads")["$defs"]["annotations"]["x-type"], "list of Load");
}

#[test]
fn nullable_strings_with_a_format_and_a_pattern_accept_null() {
    let text = "# Log\n\n## Entry\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n\
        |data|no|string or null|[@format base64] [@pattern `^Y`] Both|\n\
        |other|no|null or string|[@format base64] One|\n";
    let documents = Documents::texts(Form::Table, &[("log.md", text)]);
    let good = [json!({ "data": null, "other": null }), json!({ "data": "YQ==", "other": "ZQ==" })];
    let bad =
        [json!({ "data": "ZQ==" }), json!({ "data": "YQ" }), json!({ "data": 1 }), json!({ "other": "YQ" })];
    check_values(&documents, "Entry", &good, &bad);
    check_documents(&documents);
    assert!(documents.field("Entry", "data").get("anyOf").is_some());
    assert_eq!(documents.field("Entry", "other")["type"], json!(["string", "null"]));
}

const ANNOTATED: &str = "\
# Wind as measured
#
# In the air.

uint32 MESSAGE_VERSION = 3
uint8 ORB_QUEUE_LENGTH = 4
uint64 timestamp  # [us] Since start

# Air
float32 speed  # [m/s] [@frame NED] [@range 0, inf] [@invalid NaN if still] How \"fast\"
float32 ratio  # [-] No unit

# TOPICS wind wind_raw
";

#[test]
fn annotates_what_validators_do_not_check() {
    let documents = Documents::texts(PX4, &[("Wind.msg", ANNOTATED)]);
    let document = &documents.by_path["demo/Wind.schema.json"];
    assert_eq!(document["title"], "Wind");
    assert_eq!(document["description"], "Wind as measured\n\nIn the air.");
    assert_eq!(document["$id"], "https://schemas.invalid/demo/Wind.schema.json");
    let speed = documents.field("Wind", "speed");
    assert_eq!(speed["description"], "How \"fast\"");
    let expected = json!({
        "x-type": "float32", "x-unit": "m/s", "x-frame": "NED", "x-range": [0, null],
        "x-invalid": null, "x-invalid-when": "if still", "x-group": "Air"
    });
    assert_eq!(speed["$defs"]["annotations"], expected);
    assert_eq!(documents.field("Wind", "ratio")["$defs"]["annotations"].get("x-unit"), None);
    let message = &document["$defs"]["annotations"];
    assert_eq!(message["x-topics"], json!(["wind", "wind_raw"]));
    assert_eq!((&message["x-version"], &message["x-queue-length"]), (&json!(3), &json!(4)));
    assert_eq!((&message["x-uorb-size"], &message["x-uorb-size-no-padding"]), (&json!(16), &json!(16)));
    assert_eq!(message["x-ros-type"], "demo/msg/Wind");
    assert!(
        message["x-hash"].is_u64() && message["x-rihs01"].as_str().expect("a hash").starts_with("RIHS01_")
    );
    let field_names: Vec<&String> = document["properties"].as_object().expect("fields").keys().collect();
    assert_eq!(field_names, ["timestamp", "speed", "ratio"], "declared order");
}

#[test]
fn annotates_parameters_of_commands() {
    let text = "uint16 VEHICLE_CMD_GO = 16  # Go |[m] Radius|[@range 0, 1] Share|Unused|Unused|Unused|Unused|Unused|\n";
    let documents = Documents::texts(PX4, &[("VehicleCommand.msg", text)]);
    let annotations = &documents.by_path["demo/VehicleCommand.schema.json"]["$defs"]["annotations"];
    let parameters = annotations["x-parameters"]["VEHICLE_CMD_GO"].as_array().expect("parameters");
    assert_eq!(parameters.len(), 7);
    assert_eq!(parameters[0], json!({ "description": "Radius", "unit": "m" }));
    assert_eq!(parameters[1]["range"], json!([0, 1]));
}

#[test]
fn ids_start_with_the_configured_base() {
    let (_, schema, _) = support::texts(PX4, &[("A.msg", "uint8 a\n"), ("B.msg", "A a\n")]);
    for base in ["https://example.org/s", "https://example.org/s/"] {
        let files = emit(&schema, &Options { base: base.to_owned() });
        let id =
            |index: usize| serde_json::from_str::<Json>(&files[index].text).expect("JSON")["$id"].clone();
        assert_eq!(id(0), "https://example.org/s/demo.bundle.schema.json");
        assert_eq!(id(1), "https://example.org/s/demo/A.schema.json");
        assert!(files[2].text.contains("\"$ref\": \"A.schema.json\""), "references are relative");
    }
}

#[test]
fn does_not_depend_on_the_order_of_the_input() {
    let mut files = vec![("B.msg", "A a\nuint8 b\n"), ("A.msg", ANNOTATED), ("C.srv", "B b\n---\nuint8 x\n")];
    let emitted = |files: &[(&str, &str)]| emit(&support::texts(PX4, files).1, &Options::default());
    let first = emitted(&files);
    files.reverse();
    assert_eq!(first, emitted(&files));
    assert!(first.is_sorted_by_key(|file| &file.path));
    for file in &first {
        assert!(
            file.text[..1000.min(file.text.len())].contains("Generated by uavspec-codegen"),
            "{}",
            file.path
        );
        assert!(file.text.ends_with("}\n"));
    }
}

/// Checks that each document satisfies the meta-schema, and contains no keyword that a strict validator rejects.
fn check_documents(documents: &Documents) {
    for (path, document) in &documents.by_path {
        if let Err(error) = jsonschema::meta::validate(document) {
            panic!("{path}: {error} at {}", error.instance_path());
        }
        check_keywords(path, document);
        let id = document["$id"].as_str().expect("an address");
        assert_eq!(id, format!("{DEFAULT_BASE}{path}"));
        assert!(document["title"].is_string() && document["description"].is_string(), "{path}");
    }
}

fn check_keywords(place: &str, schema: &Json) {
    let Some(members) = schema.as_object() else {
        assert!(schema.is_boolean(), "{place} is not a schema");
        return;
    };
    for (keyword, value) in members {
        let place = format!("{place}/{keyword}");
        assert!(KEYWORDS.contains(&keyword.as_str()), "{place} is not an allowed keyword");
        match keyword.as_str() {
            "items" | "additionalProperties" => check_keywords(&place, value),
            "anyOf" | "oneOf" | "allOf" | "prefixItems" => {
                value.as_array().expect("a list").iter().for_each(|part| check_keywords(&place, part));
            }
            "properties" => {
                value.as_object().expect("an object").values().for_each(|part| check_keywords(&place, part));
            }
            "$defs" => {
                for (name, part) in value.as_object().expect("an object") {
                    if name == "annotations" {
                        let mut names = part.as_object().expect("an object").keys();
                        assert!(names.all(|name| name.starts_with("x-")), "{place}");
                    } else {
                        check_keywords(&place, part);
                    }
                }
            }
            _ => {}
        }
    }
}

#[test]
fn documents_satisfy_the_meta_schema_and_strict_validators() {
    check_documents(&Documents::texts(
        PX4,
        &[("Wind.msg", ANNOTATED), ("B.msg", "Wind[2] a\n"), ("C.srv", "Wind w\n---\n")],
    ));
    check_documents(&Documents::texts(Form::Table, &[("codes.md", CODES)]));
    check_documents(&gliders());
    let every = "uint8 M_X = 1\nuint8 a  # [@enum M] [@range 0, 5] [@invalid 9]\nfloat32[3] b  # [@range 0, 1] [@invalid -1]\n\
                 string<=3 c 'x'\nbool[<=2] d [true]\nfloat64[] e\nuint16 f  # [@flags M]\n";
    check_documents(&Documents::texts(ROS2, &[("A.msg", every), ("B.action", "A a\n---\n---\nbool c\n")]));
}

#[test]
fn escapes_malicious_texts() {
    let text = "# \"}], \\u0000 <b> \u{202e}\n\nuint8 a  # \\ \" \u{1f681} \u{feff}\n";
    let (_, schema, _) = support::texts(PX4, &[("A.msg", text)]);
    let files = emit(&schema, &Options::default());
    assert!(
        files.iter().all(|file| !file.text.contains(['\u{202e}', '\u{feff}'])),
        "files must not contain invisible characters"
    );
    let documents = Documents::of(&files);
    check_documents(&documents);
    assert!(documents.field("A", "a")["description"].as_str().expect("text").contains("\\ \" \u{1f681}"));
}

/// Validates the instances of `oracle`. Each error must satisfy `is_expected`.
fn check_instances(documents: &Documents, oracle: &str, is_expected: fn(&ValidationErrorKind) -> bool) {
    let Some(path) = support::shared(oracle) else { return };
    let cases: Vec<Json> = serde_json::from_str(&fs::read_to_string(path).expect("an oracle")).expect("JSON");
    let mut validators = BTreeMap::new();
    for case in cases.iter().step_by(support::extent(1, 4)) {
        let name = case["type"].as_str().expect("a type").replace("px4_msgs/", "px4/").replace("/msg/", "/");
        let validator = validators
            .entry(name.clone())
            .or_insert_with(|| documents.validator(&format!("{name}.schema.json")));
        let instance = &case["json"];
        for error in validator.iter_errors(instance) {
            assert!(
                is_expected(error.kind()),
                "{name} {}: {error} at {}",
                case["case"],
                error.instance_path()
            );
        }
        let mut extra = instance.clone();
        extra["no_such_field"] = json!(0);
        assert!(!validator.is_valid(&extra), "{name} accepts an additional field");
        if let Some(field) = instance.as_object().and_then(|fields| fields.keys().next()) {
            let mut missing = instance.clone();
            missing.as_object_mut().expect("an object").remove(field);
            assert!(!validator.is_valid(&missing), "{name} accepts a missing {field}");
            let mut wrong = instance.clone();
            wrong[field] = json!({ "no": "such" });
            assert!(!validator.is_valid(&wrong), "{name}.{field} accepts a value of the wrong type");
        }
    }
}

#[test]
fn px4_of_the_corpus() {
    for release in support::extent(&["main", "1.16", "1.15"][..], &["main"]) {
        let Some(folder) = support::shared(&format!("corpus/px4/{release}")) else { return };
        let (sources, schema, diagnostics) = support::px4(&folder);
        let documents = Documents::read(&sources, &schema, &diagnostics);
        check_documents(&documents);
        if *release == "main" {
            // The instances are random. Types and lengths are valid, but ranges and counts may be violated.
            check_instances(&documents, "oracle/cdr/px4-main.json", |kind| {
                use ValidationErrorKind::{AnyOf, Maximum, Minimum, OneOfNotValid};
                matches!(kind, AnyOf { .. } | OneOfNotValid { .. } | Maximum { .. } | Minimum { .. })
            });
        }
    }
}

#[test]
fn ros2_of_the_corpus() {
    let Some(folder) = support::shared("corpus/ros2") else { return };
    let (sources, schema, diagnostics) = support::ros2(&folder);
    let documents = Documents::read(&sources, &schema, &diagnostics);
    check_documents(&documents);
    check_instances(&documents, "oracle/cdr/ros2.json", |_| false);
}
