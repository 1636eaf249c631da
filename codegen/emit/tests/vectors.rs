//! Tests of the vectors: the published schemas, the codecs and the rules agree with each case, and all important inputs
//! are covered.

use uavspec_test_definitions as support;

mod coverage;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;

use jsonschema::{Registry, Resource};
use serde_json::{Value as Json, json};
use support::extent;
use uavspec_dynamic::{DynamicMessage, MessageType, Reason, Types};
use uavspec_emit::{OutputFile, json_schema, vectors};
use uavspec_runtime::Fault;
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::SourceMap;
use uavspec_schema::{Diagnostic, Element, Form, Kind, Message, MessageId, Schema, read, render};

const PX4: Form = Form::Msg(Dialect::Px4);
const ROS2: Form = Form::Msg(Dialect::Ros2);

/// Features that no corpus contains: bounds of all kinds, wide strings, and rules in nested messages.
const CORNERS: [(&str, &str); 3] = [
    ("Inner.msg", "wstring<=3 label\nfloat64[2] pair\nint64 far\nbool flag\n"),
    ("Middle.msg", "Inner[<=2] inners\nstring<=5 name\nbool[<=3] flags\nbyte raw\nchar letter\n"),
    ("Outer.msg", "Middle[2] middles\nMiddle[] more\nstring[<=2] names\nuint16[<=20] numbers\nEmpty empty\n"),
];

/// Combinations of PX4 annotations: text, ranges with special values, counts, and masks with a signed type.
const ANNOTATED: [(&str, &str); 1] = [(
    "Annotated.msg",
    "uint8 MODE_A = 3\nuint8 MODE_B = 5\nint8 BIT_LOW = 1\nint8 BIT_HIGH = 64\nuint64 timestamp\n\
     uint8 mode # [@enum MODE] Starts at three\nint8 bits # [@flags BIT] Two bits\n\
     int32 level # [@range -5, 5] [@invalid -999] A level\nfloat32 angle # [rad] [@range -pi, pi] An angle\n\
     float64 share # [@range 0.1, 0.9] [@invalid NaN] A share\nuint8 count # [@count items] Entries\n\
     uint16[3] items # Entries\nchar[7] name # A name\nchar[1] mark # A mark\nchar single # A character\n\
     float32[2] pair # [@range 1,] Two\nuint8[2] modes # [@enum MODE] Two modes\nint64 far # Far\n",
)];

/// Pages with types and messages of all kinds, and error codes that they refer to.
const PAGES: [(&str, &str); 4] = [
    ("gliders.md", include_str!("../../schema/tests/fixtures/ok/type-tables/gliders.md")),
    ("odd.md", include_str!("../../schema/tests/fixtures/ok/type-tables-names/odd.md")),
    ("marks.md", LIMITS),
    ("codes.md", "# Warnings (codes 64-127)\n|Code|Abbr|Description|\n|-|-|-|\n|64|WIND|Strong wind|\n"),
];

const LIMITS: &str = "# Limits\n\n## Load\n\nnumber, [N] [@range 0, 9000] What pulls.\n\n## Loads\n\n\
    list of Load, [@length 2, 3] [@unique] Several.\n\n## Rope\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n\
    |load|no|Load or null|[@range 10, 20000] Now|\n|loads|yes|Loads|[@range , 50] Then|\n\
    |codes|no|ErrorList|[@length , 1] [@unique] Codes|\n|code|no|ErrorCode or string|A code|\n\
    |key|yes|string|[@length 4] [@pattern `^[a-z]+$`] A key|\n|keys|no|map of string|[@pattern `^\\d{2}$`] Keys|\n\
    |far|no|integer|[@range 9007199254740993, 9007199254740999] Beyond doubles|\n|log|no|string|[@format base64] [@length 4, 8] Bytes|\n\
    |next|no|Rope|The next|\n|ropes|no|list of list of Rope|Others|\n|ends|no|list of (one of a, b)|[@unique] Ends|\n";

/// Definitions and the files emitted from them.
struct Emitted {
    schema: Schema,
    schemas: Vec<OutputFile>,
    vectors: Vec<OutputFile>,
}

impl Emitted {
    fn of((sources, schema, diagnostics): (SourceMap, Schema, Vec<Diagnostic>)) -> Self {
        assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
        let schemas = json_schema::emit(&schema, &json_schema::Options::default());
        let vectors = vectors::emit(&schema, &vectors::Options::default());
        Self { schema, schemas, vectors }
    }

    /// The files with this extension, parsed as JSON.
    fn files(&self, ending: &str) -> impl Iterator<Item = (&str, Json)> {
        let files = self.vectors.iter().filter(move |file| file.path.ends_with(ending));
        files.map(|file| (file.path.as_str(), serde_json::from_str(&file.text).expect("JSON")))
    }

    fn suites(&self) -> impl Iterator<Item = (&str, Json)> {
        self.files(".json").filter(|(path, _)| path.starts_with("json-schema-test-suite/"))
    }

    /// Like `of`. In a quick run, only every `step`-th message is emitted, with the messages that it contains and with
    /// all services.
    fn sampled(
        step: usize,
        (sources, mut schema, diagnostics): (SourceMap, Schema, Vec<Diagnostic>),
    ) -> Self {
        let step = extent(1, step);
        let messages = schema.packages.iter().flat_map(|package| package.messages.iter().step_by(step));
        let interfaces = schema.packages.iter().flat_map(|package| &package.interfaces);
        let parts = interfaces.flat_map(|interface| &interface.parts);
        let mut open: Vec<MessageId> = messages.chain(parts).copied().collect();
        let mut emitted = BTreeSet::new();
        while let Some(id) = open.pop() {
            if emitted.insert(id) {
                open.extend(schema.message(id).fields.iter().filter_map(|field| match field.ty.element {
                    Element::Message(nested) => Some(nested),
                    _ => None,
                }));
            }
        }
        for package in &mut schema.packages {
            package.messages.retain(|id| emitted.contains(id));
            package.json_messages = package.json_messages.iter().step_by(step).copied().collect();
        }
        Self::of((sources, schema, diagnostics))
    }

    /// Each message with its cases.
    fn messages(&self) -> impl Iterator<Item = (&Message, MessageType<'_>, Vec<Json>)> + use<'_> {
        let types: &Types = Box::leak(Box::new(Types::new(&self.schema)));
        let files: BTreeMap<&str, &str> =
            self.vectors.iter().map(|file| (file.path.as_str(), file.text.as_str())).collect();
        self.schema.messages.iter().enumerate().filter_map(move |(index, message)| {
            let package = &self.schema.package_of(message).name;
            let folder = match message.kind {
                Kind::Message => String::new(),
                kind => format!("{}/", kind.name()),
            };
            let file = files.get(format!("{package}/{folder}{}.vectors.json", message.name).as_str())?;
            let mut file: Json = serde_json::from_str(file).expect("JSON");
            let Json::Array(cases) = file["cases"].take() else { return None };
            let id = MessageId(u32::try_from(index).expect("few"));
            Some((message, types.get(id), cases))
        })
    }
}

/// Our own definitions.
static DEFINITIONS: LazyLock<Emitted> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions");
    let mut sources = SourceMap::default();
    let mut px4 = support::package("px4", PX4);
    support::add_folder(&mut sources, &mut px4, &folder.join("px4"));
    let mut flockwave = support::package("flockwave", Form::Table);
    for path in support::files_below(&folder.join("flockwave"), &["md"]) {
        let text = std::fs::read(&path).expect("a page");
        flockwave.sources.push(sources.add(path.to_string_lossy(), text).expect("a page"));
    }
    let (schema, diagnostics) = read(&sources, &[px4, flockwave]);
    Emitted::sampled(2, (sources, schema, diagnostics))
});

static OF_PAGES: LazyLock<Emitted> = LazyLock::new(|| Emitted::of(support::texts(Form::Table, &PAGES)));

static OTHERS: LazyLock<Vec<Emitted>> = LazyLock::new(|| {
    let corners = CORNERS.iter().chain([&("Empty.msg", "")]).copied().collect::<Vec<_>>();
    let mut others =
        vec![Emitted::of(support::texts(ROS2, &corners)), Emitted::of(support::texts(PX4, &ANNOTATED))];
    for release in extent(&["main", "1.16", "1.15"][..], &["main"]) {
        let folder = support::shared(&format!("corpus/px4/{release}/msg"));
        others.extend(folder.map(|folder| Emitted::sampled(8, support::px4(&folder))));
    }
    let ros2 = support::shared("corpus/ros2");
    others.extend(ros2.map(|folder| Emitted::sampled(4, support::ros2(&folder))));
    others
});

/// All definitions for which the tests emit vectors. A quick run omits the older releases of PX4.
fn all() -> impl Iterator<Item = &'static Emitted> {
    [&*DEFINITIONS, &*OF_PAGES].into_iter().chain(&*OTHERS)
}

#[test]
fn published_schemas_agree_with_the_suite() {
    for emitted in all() {
        let resources = emitted.schemas.iter().map(|file| {
            let schema: Json = serde_json::from_str(&file.text).expect("JSON");
            (schema["$id"].as_str().expect("an address").to_owned(), Resource::from_contents(schema))
        });
        let registry = Registry::new().extend(resources).expect("addresses").prepare().expect("references");
        let mut count = 0;
        for (path, suite) in emitted.suites() {
            for group in suite.as_array().expect("a list of groups") {
                assert_eq!(names(group), ["description", "comment", "schema", "tests"], "{path}");
                let options = jsonschema::options().with_registry(&registry);
                let validator = options.build(&group["schema"]).expect("a schema");
                for test in group["tests"].as_array().expect("tests") {
                    assert_eq!(names(test), ["description", "data", "valid"], "{path}");
                    let verdict = validator.is_valid(&test["data"]);
                    assert_eq!(json!(verdict), test["valid"], "{path}: {}", test["description"]);
                    count += 1;
                }
            }
        }
        assert!(count > 0);
    }
}

/// The names of the members of an object.
fn names(object: &Json) -> Vec<&str> {
    object.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn codecs_and_rules_agree_with_the_vectors() {
    for emitted in all() {
        for (message, ty, cases) in emitted.messages() {
            for case in cases {
                let name = format!("{} {}", message.name, case["id"]);
                let expected: BTreeSet<String> =
                    case["rule"].as_str().map(str::to_owned).into_iter().collect();
                assert_eq!(case["valid"], json!(expected.is_empty()), "{name}");
                check_case(ty, &case, &expected, &name);
            }
        }
    }
}

fn check_case(ty: MessageType<'_>, case: &Json, expected: &BTreeSet<String>, name: &str) {
    let expected_value = case.get("json").or(case.get("decoded"));
    let from_json = expected_value.map(|json| ty.from_json(json));
    if let Some(read) = &from_json {
        assert_eq!(&violated(read), expected, "{name}: JSON");
    }
    let expected_value = from_json.and_then(Result::ok);
    let uorb = hex(&case["uorb"]).map(|bytes| (ty.decode_uorb_strict(&bytes), bytes));
    let cdr = hex(&case["cdr"]).map(|bytes| (ty.decode_cdr_strict(&bytes), bytes));
    for (decoded, _) in [&uorb, &cdr].into_iter().flatten() {
        assert_eq!(&violated(decoded), expected, "{name}: bytes");
        if let (Ok(decoded), Some(expected_value)) = (decoded, &expected_value) {
            assert!(
                is_same(&decoded.to_json().expect("JSON"), &expected_value.to_json().expect("JSON")),
                "{name}"
            );
        }
    }
    if let (Some(expected_value), Some(json)) = (&expected_value, case.get("json")) {
        assert!(is_same(&expected_value.to_json().expect("JSON"), json), "{name}: JSON round trip");
        let encoded = expected_value.to_cdr(ByteOrder::LittleEndian).ok();
        assert_eq!(cdr.as_ref().map(|(_, bytes)| bytes), encoded.as_ref(), "{name}: CDR");
        if let Some((_, bytes)) = &uorb {
            assert_eq!(bytes, &expected_value.to_uorb().expect("a memory form"), "{name}: uORB");
        }
    }
}

/// The rules that a message violates, or the rule that a decoding error corresponds to.
fn violated(read: &Result<DynamicMessage<'_>, uavspec_dynamic::Error>) -> BTreeSet<String> {
    let rule = match read {
        Ok(message) => {
            return message.validate().iter().map(|violation| violation.kind.id().to_owned()).collect();
        }
        Err(error) => match &error.reason {
            Reason::Fault(Fault::Size { .. }) => "PX-DATA-01",
            Reason::Fault(Fault::Encapsulation(_)) => "PX-CDR-01",
            Reason::Fault(Fault::Bool(_)) => "PX-BOOL-01",
            Reason::Fault(Fault::Truncated { .. } | Fault::Trailing(_) | Fault::TooLong { .. }) => {
                "PX-CDR-02"
            }
            Reason::Json(text) if text.contains("missing field") || text.contains("unknown field") => {
                "PX-JSON-01"
            }
            Reason::Json(text) if text.contains("invalid length") || text.contains("more than") => {
                "PX-ARR-01"
            }
            Reason::Json(_) => "PX-JSON-02",
            other => panic!("{other}"),
        },
    };
    [rule.to_owned()].into()
}

fn hex(text: &Json) -> Option<Vec<u8>> {
    let text = text.as_str()?;
    assert!(text.len() % 2 == 0 && !text.is_empty());
    let byte = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).expect("hexadecimal");
    Some((0..text.len()).step_by(2).map(byte).collect())
}

/// True if two values are equal after conversion to the types of their fields.
#[allow(clippy::cast_possible_truncation, clippy::float_cmp)] // exact equality as float32 is intended
fn is_same(left: &Json, right: &Json) -> bool {
    match (left, right) {
        (Json::Number(a), Json::Number(b)) if a.is_f64() && b.is_f64() => {
            let (a, b) = (a.as_f64().expect("a float"), b.as_f64().expect("a float"));
            a.to_bits() == b.to_bits() || (a as f32).to_bits() == (b as f32).to_bits() && a.abs() < 3.5e38
        }
        (Json::Array(a), Json::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b)),
        (Json::Object(a), Json::Object(b)) => {
            a.len() == b.len()
                && a.iter().zip(b).all(|((name, a), (other, b))| name == other && is_same(a, b))
        }
        _ => left == right,
    }
}

#[test]
fn creates_unique_ids_and_valid_files() {
    for emitted in all() {
        let (_, form) = emitted.files("vectors.schema.json").next().expect("the schema of the form");
        let form = jsonschema::validator_for(&form).expect("a schema");
        for (path, file) in emitted.files(".vectors.json") {
            if let Err(error) = form.validate(&file) {
                panic!("{path}: {error}");
            }
            let cases = file["cases"].as_array().expect("cases");
            let ids: BTreeSet<&str> = cases.iter().map(|case| case["id"].as_str().expect("an id")).collect();
            assert_eq!(ids.len(), cases.len(), "{path}");
            assert!(!cases.is_empty(), "{path}");
        }
    }
}

#[test]
fn output_is_deterministic() {
    for emitted in all().step_by(extent(1, 2)) {
        assert!(vectors::emit(&emitted.schema, &vectors::Options::default()) == emitted.vectors);
    }
}

#[test]
fn refers_to_the_schemas_by_their_ids() {
    let (_, schema, _) = support::texts(PX4, &[("A.msg", "uint64 timestamp\n")]);
    let schemas = json_schema::Options { base: "https://example.org/x/".to_owned() };
    let files = vectors::emit(&schema, &vectors::Options { base: Some(schemas.base.clone()) });
    let address = "https://example.org/x/demo/A.schema.json";
    assert!(json_schema::emit(&schema, &schemas).iter().any(|file| file.text.contains(address)));
    assert_eq!(files.iter().filter(|file| file.text.contains(address)).count(), 2);
}

#[test]
fn additions_do_not_change_existing_ids() {
    let ids = |text: &str| -> BTreeSet<String> {
        let emitted = Emitted::of(support::texts(PX4, &[("A.msg", text)]));
        let (_, file) = emitted.files(".vectors.json").next().expect("vectors");
        let cases = file["cases"].as_array().expect("cases");
        cases.iter().map(|case| case["id"].as_str().expect("an id").to_owned()).collect()
    };
    let before = ids("uint64 timestamp\nuint8 A_B = 0\nuint8 mode # [@enum A]\nfloat32[2] speed\n");
    let after = ids(
        "uint64 timestamp\nuint8 A_B = 0\nuint8 A_C = 1\nuint8 mode # [@enum A]\nbool uorb\nfloat32[2] speed\nchar[2] cdr\n",
    );
    assert!(before.is_subset(&after), "{:?}", before.difference(&after).collect::<Vec<_>>());
}

/// In the `typical` case, adjacent bytes of a number differ, so shifted bytes are detected.
#[test]
fn adjacent_typical_bytes_differ() {
    let text = "uint64 a\nint32 b\nfloat32 c\nuint16 d\nuint8 e\nint8[300] f\nfloat64[2] g\n";
    let emitted = Emitted::of(support::texts(PX4, &[("A.msg", text)]));
    let (_, _, cases) = emitted.messages().next().expect("a message");
    let bytes = hex(&cases[1]["uorb"]).expect("bytes");
    let size = emitted.schema.messages[0].uorb.as_ref().expect("a layout").size_no_padding;
    assert!(bytes[..size].windows(2).all(|pair| pair[0] != pair[1] && pair[0] != 0), "{bytes:?}");
}

/// ROS 2 counts the bytes of a `string` and the UTF-16 code units of a `wstring`. Our codecs and some others count
/// characters.
#[test]
fn all_ways_to_count_agree_about_bounds_of_strings() {
    let bounds: [u32; 6] = [1, 2, 3, 4, 6, 7];
    let declared = |ty: &str| bounds.map(|bound| format!("{ty}<={bound} {ty}_{bound}\n")).concat();
    let text = declared("string") + &declared("wstring");
    let emitted = Emitted::of(support::texts(ROS2, &[("Bounded.msg", &text)]));
    let (_, _, cases) = emitted.messages().next().expect("a message");
    let mut multibyte = BTreeSet::new();
    for case in &cases {
        for (name, value) in case["json"].as_object().into_iter().flatten() {
            let (Some(text), Some((ty, bound))) = (value.as_str(), name.split_once('_')) else { continue };
            let bound: usize = bound.parse().expect("a number");
            let length = if ty == "string" { text.len() } else { text.encode_utf16().count() };
            assert_eq!(length > bound, text.chars().count() > bound, "{}: {name}: {text}", case["id"]);
            if !text.is_ascii() {
                multibyte.insert(format!("{} {name}", case["id"].as_str().expect("an id")));
            }
        }
    }
    for (field, has_sample) in
        [("string_6", false), ("string_7", true), ("wstring_3", false), ("wstring_4", true)]
    {
        assert_eq!(multibyte.contains(&format!("{field}-multibyte {field}")), has_sample, "{field}");
    }
}

#[test]
fn takes_the_severity_of_error_codes_from_their_bits() {
    let (_, file) = DEFINITIONS.files("ErrorCode.vectors.json").next().expect("vectors");
    let cases = file["cases"].as_array().expect("cases");
    let names = ["informational", "warning", "error", "fatal"];
    let mut known = 0;
    for case in cases.iter().filter(|case| case["valid"] == true) {
        let code = case["json"].as_u64().expect("a code");
        assert_eq!(case["severity"], names[usize::try_from((code & 0xff) >> 6).expect("two bits")], "{code}");
        known += 1;
    }
    assert!(known >= 63 && cases.iter().any(|case| case["json"] == json!(4_294_967_296_u64)));
}

/// Oversized definitions have no vectors, and the emitter skips them quickly.
#[test]
fn creates_no_cases_for_oversized_definitions() {
    let cases = |form, files: &[(String, String)], name: &str| {
        let files: Vec<(&str, &str)> =
            files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
        let (_, schema, _) = support::texts(form, &files);
        let files = vectors::emit(&schema, &vectors::Options::default());
        let file =
            files.iter().find(|file| file.path == format!("demo/{name}.vectors.json")).expect("a file");
        let file: Json = serde_json::from_str(&file.text).expect("JSON");
        file["cases"].as_array().expect("cases").len()
    };
    let named = |name: &str, text: &str| (format!("{name}.msg"), text.to_owned());
    assert_eq!(cases(PX4, &[named("Long", "uint8[1000000] a\n")], "Long"), 0);
    let chain: Vec<(String, String)> = (0..100)
        .map(|link: u32| {
            let ty = link.checked_sub(1).map_or("bool".to_owned(), |inner| format!("Link{inner}"));
            named(&format!("Link{link}"), &format!("{ty} part\n"))
        })
        .collect();
    assert_eq!(cases(PX4, &chain, "Link99"), 0);
    assert!(cases(PX4, &chain, "Link20") > 0);
    let doubling: Vec<(String, String)> = (0..30)
        .map(|level: u32| {
            let text = level
                .checked_sub(1)
                .map_or("bool a\n".to_owned(), |below| format!("Level{below}[] a\nLevel{below}[] b\n"));
            named(&format!("Level{level}"), &text)
        })
        .collect();
    assert!(cases(ROS2, &doubling, "Level29") > 0);
    let wide: String = (0..3_000).map(|number| format!("uint64 field_{number}\n")).collect();
    let wide = cases(PX4, &[named("Wide", &wide)], "Wide");
    assert!((1..20).contains(&wide), "{wide} cases, but expected none for single fields");
}

/// The cases for pages cover every rule about body schemas. For each field, one case omits the field.
#[test]
fn cases_of_pages_cover_every_rule_about_body_schemas() {
    let mut rules = BTreeSet::new();
    for (path, file) in OF_PAGES.files(".vectors.json").filter(|(path, _)| !path.contains("/Error")) {
        let cases = file["cases"].as_array().expect("cases");
        let valid = cases.iter().filter(|case| case["valid"] == true).count();
        assert!(valid > 0 && (valid < cases.len() || path.ends_with("/Result.vectors.json")), "{path}");
        rules.extend(cases.iter().filter_map(|case| case["rule"].as_str().map(str::to_owned)));
    }
    let expected = ["FURTHER", "LENGTH", "PATTERN", "RANGE", "REQUIRED", "TYPE", "UNIQUE", "VALUE"];
    assert_eq!(rules.into_iter().collect::<Vec<_>>(), expected.map(|rule| format!("SHAPE-{rule}")));
    let (_, rope) = OF_PAGES.files("/Rope.vectors.json").next().expect("the vectors of a type");
    let ids: BTreeSet<&str> = rope["cases"]
        .as_array()
        .expect("cases")
        .iter()
        .map(|case| case["id"].as_str().expect("an id"))
        .collect();
    let expected = [
        "typical",
        "minimal",
        "load-absent",
        "load-null",
        "load-least",
        "load-below-range",
        "loads-absent",
        "codes-too-long",
        "key-longest-wide",
        "keys-value-text-1",
        "log-text-5",
        "next-null",
        "ropes-item-null",
    ];
    let missing: Vec<_> = expected.into_iter().filter(|id| !ids.contains(id)).collect();
    assert_eq!(missing, ["log-text-5"], "a value that violates two rules is not a case: {ids:?}");
}
