//! Properties that hold for any input: nothing panics, each location is within its source, and printed definitions are
//! read back unchanged.

use std::fmt::Write as _;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;
use serde_json::Value as Json;
use uavspec_emit::inspect;
use uavspec_schema::diagnostic::{Diagnostic, has_errors};
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::Span;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Element, ErrorTable, Form, Message, Schema, Shape, SourceMap, Type, read, render};
use uavspec_test_definitions as support;

/// Valid and invalid pieces of the language.
const PIECES: &[&str] = &[
    "uint8",
    "int64",
    "float32",
    "bool",
    "char",
    "byte",
    "string",
    "wstring",
    "time",
    "Header",
    "Other",
    "pkg/Other",
    "Glider",
    "a",
    "b_c",
    "A",
    "MODE_A",
    "MODE_B=1",
    "MESSAGE_VERSION",
    "ORB_QUEUE_LENGTH",
    "[",
    "]",
    "[3]",
    "[<=3]",
    "[]",
    "[0]",
    "<=",
    "=",
    "= 1",
    "=-1",
    "0x1F",
    "1_0",
    "1.5",
    "inf",
    "nan",
    "true",
    "'x'",
    "\"x\\n\"",
    "\"",
    "'",
    "\\",
    " ",
    "\t",
    "  ",
    "\n",
    "\n\n",
    "\r\n",
    "\r",
    "#",
    "# ",
    "# TOPICS ",
    "---",
    "---\n",
    "@",
    "[@",
    "(@",
    ")",
    "[m/s]",
    "[@enum MODE]",
    "[@flags MODE A]",
    "[@enum Other.MODE]",
    "[@range 0, 1]",
    "[@range -pi, inf]",
    "[@invalid NaN]",
    "[@invalid MODE_A]",
    "[@count a]",
    "[@frame NED]",
    "[enum MODE]",
    "[FRD]",
    "[0, 1]",
    "|",
    ",",
    "|1|2|3|4|5|6|7|",
    "é",
    "\u{feff}",
    "\u{2028}",
    "\u{202e}",
    "\0",
    "°C",
    "😀",
];

/// Valid and invalid pieces of pages.
const PAGE_PIECES: &[&str] = &[
    "\n\n## Mark\n\n",
    "\n\n## Wind\n\n",
    "\n\n## WIND-INF\n\n### Request\n\n",
    "\n\n### Response\n\n",
    "No fields besides `type`.",
    "Answer: WIND-INF, ",
    "An open set.",
    "Closed object.",
    "\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n",
    "\n\n|Index|Element|Required|Type|Description|\n|-|-|-|-|-|\n",
    "\n\n|Value|Description|\n|-|-|\n",
    "|name|yes|string|[@length 1, 8] x|\n",
    "|wind|no|Wind or null|[@range 0, 9] x|\n",
    "|0|mark|no|Mark|x|\n",
    "|1|",
    "|calm|none|\n",
    "string, ",
    "list of Mark",
    "map of (",
    " or null",
    "[@pattern `^[a-z]+$`]",
    "[@unique] ",
    "# ",
    "## Warnings (codes 64-127)",
    "== Errors (codes 128-191)",
    "Boats (codes 512-767)",
    "Code | Abbr | Description",
    "|Code|Abbr|Description|",
    "|---|---|---|",
    "---|---|---|",
    "|===",
    "[cols=\"1,1,3\"]",
    "[cols=3*]",
    ".Warnings",
    "|64|LEAK|Water|",
    "|65 |A |see code 64",
    "64 |",
    "LEAK |",
    "use it only if; otherwise use code 64",
    "codes 1, 2 or 3",
    "2+|",
    "a|",
    "|",
    "\\|",
    "\n",
    "\n\n",
    "\r\n",
    " ",
    "\t",
    "*",
    "_",
    "`",
    "<<",
    ">>",
    "link:a[",
    "]",
    "{vbar}",
    "&amp;",
    "&nGt;",
    "<br>",
    "----",
    "////",
    "// x",
    "```",
    " +",
    "é",
    "\0",
    "\u{2028}",
    "😀",
    "since 2.10",
    "0",
    "4294967296",
];

/// Any text, or a text composed of pieces.
fn text(pieces: &'static [&'static str]) -> impl Strategy<Value = String> {
    prop_oneof![
        1 => "(?s).{0,120}",
        4 => vec(select(pieces), 0..40).prop_map(|pieces| pieces.concat()),
        2 => vec(prop_oneof![select(pieces).prop_map(str::to_owned), "(?s).{1,3}"], 0..30).prop_map(|parts| parts.concat()),
    ]
}

fn check(form: Form, files: &[(&str, &str)]) -> Result<(), TestCaseError> {
    let (sources, schema, diagnostics) = support::texts(form, files);
    for Diagnostic { span, related, .. } in &diagnostics {
        prop_assert!(sources.contains(*span), "{span:?}");
        for (span, _) in related {
            prop_assert!(sources.contains(*span), "{span:?}");
        }
    }
    prop_assert_eq!(render::render(&diagnostics, &sources, false).is_empty(), diagnostics.is_empty());
    if !has_errors(&diagnostics) {
        check_output(&schema, &sources)?;
    }
    Ok(())
}

/// Checks that each emitter accepts any definition, and that the outputs are valid Rust and JSON.
fn check_output(schema: &Schema, sources: &SourceMap) -> Result<(), TestCaseError> {
    inspect::schema(schema);
    for file in uavspec_emit::vectors::emit(schema, &uavspec_emit::vectors::Options::default()) {
        let parsed: Result<Json, _> = serde_json::from_str(&file.text);
        prop_assert!(parsed.is_ok(), "{}: {}", file.path, file.text);
    }
    let docs = uavspec_emit::docs::emit(
        schema,
        &Translations::default(),
        sources,
        &uavspec_emit::docs::Options::default(),
    );
    for file in uavspec_emit::json_schema::emit(schema, &uavspec_emit::json_schema::Options::default()) {
        let parsed: Result<Json, _> = serde_json::from_str(&file.text);
        prop_assert!(parsed.is_ok(), "{}: {}", file.path, file.text);
    }
    let rust = uavspec_emit::rust::emit(schema, sources, &uavspec_emit::rust::Options::default());
    for file in docs.iter().chain(&rust) {
        prop_assert!(!file.text.contains("compile_error!"), "{}: {}", file.path, file.text);
        let stray = file.text.chars().find(|c| c.is_control() && *c != '\n');
        prop_assert!(stray.is_none(), "{}: {stray:?}", file.path);
    }
    Ok(())
}

proptest! {
    #![proptest_config(support::usual(4))]

    #[test]
    fn any_definition_is_accepted_or_rejected(text in text(PIECES), other in text(PIECES)) {
        for dialect in [Dialect::Px4, Dialect::Ros2] {
            for path in ["Glider.msg", "Glider.srv", "Glider.action"] {
                check(Form::Msg(dialect), &[(path, &text), ("Other.msg", &other)])?;
            }
        }
    }

    #[test]
    fn any_page_is_accepted_or_rejected(text in text(PAGE_PIECES)) {
        for path in ["page.md", "page.adoc", "page.txt"] {
            check(Form::Table, &[(path, &text)])?;
        }
    }
}

#[test]
fn places_are_between_characters() {
    for text in [
        // A code span of several lines.
        "## Mark\n\nstring, `[@length 1, 8] x\n\u{2028}[@pattern `^[a-z]+$`]",
        // A space before the full stop of an answer.
        "## WIND-INF\n\n### Request\n\nNo fields besides `type`.\n\nAnswer: WIND-INF\u{2028}.",
    ] {
        check(Form::Table, &[("page.md", text)]).expect("places between characters");
    }
}

/// A declaration as written in a definition, and as represented in the model.
#[derive(Clone, Debug)]
struct Declaration {
    is_constant: bool,
    ty: String,
    name: String,
    /// The written value.
    written: Option<String>,
    /// The parsed value.
    value: Json,
    comment: String,
}

/// Integers within the range of the type, in any base.
fn integer(bits: u32, is_signed: bool) -> impl Strategy<Value = (String, Json)> {
    let (min, max) = if is_signed {
        (-(1_i128 << (bits - 1)), (1_i128 << (bits - 1)) - 1)
    } else {
        (0, (1_i128 << bits) - 1)
    };
    let any = prop_oneof![Just(min), Just(max), min..=max, (min..=max).prop_map(|value| value % 100)];
    (any, 0..5_u8).prop_map(|(value, base)| {
        let (sign, size) = (if value < 0 { "-" } else { "" }, value.unsigned_abs());
        let written = match base {
            0 => format!("{sign}0x{size:X}"),
            1 => format!("{sign}0b{size:b}"),
            2 => format!("{sign}0o{size:o}"),
            3 if size > 999 => format!("{sign}{}_{:03}", size / 1000, size % 1000),
            _ => format!("{sign}{size}"),
        };
        let value = i64::try_from(value)
            .map_or_else(|_| Json::from(u64::try_from(value).expect("64 bits")), Json::from);
        (written, value)
    })
}

/// A scalar type with a value.
fn scalar(dialect: Dialect) -> BoxedStrategy<(String, String, Json)> {
    let of = |name: &str, value: BoxedStrategy<(String, Json)>| {
        let name = name.to_owned();
        value.prop_map(move |(written, value)| (name.clone(), written, value)).boxed()
    };
    let float = |max: f64| (-max..max).prop_map(|value| (format!("{value:e}"), Json::from(value))).boxed();
    let bool = any::<bool>()
        .prop_map(|value| (if value { "True" } else { "false" }.to_owned(), Json::from(value)))
        .boxed();
    let mut all = vec![
        of("bool", bool),
        of("char", integer(8, false).boxed()),
        of("float32", float(1e30)),
        of("float64", float(1e300)),
    ];
    for bits in [8, 16, 32, 64] {
        all.push(of(&format!("int{bits}"), integer(bits, true).boxed()));
        all.push(of(&format!("uint{bits}"), integer(bits, false).boxed()));
    }
    if dialect == Dialect::Ros2 {
        all.push(of("byte", integer(8, false).boxed()));
        all.push(of("string", string().boxed()));
        all.push(of("wstring", string().boxed()));
    }
    proptest::strategy::Union::new(all).boxed()
}

/// Strings in single or double quotes, on one line.
fn string() -> impl Strategy<Value = (String, Json)> {
    let character = prop_oneof![
        any::<char>().prop_filter("fits one line", |c| !c.is_control()),
        select(vec!['"', '\'', '\\', '#', '=', '\n', '\t', '\u{200c}'])
    ];
    let text = vec(character, 0..12).prop_filter("no hidden characters", |text| {
        !text.iter().any(|c| matches!(c, '\u{2028}' | '\u{2029}'))
    });
    (text, any::<bool>()).prop_map(|(text, is_double)| {
        let quote = if is_double { '"' } else { '\'' };
        let mut written = String::from(quote);
        for c in &text {
            match c {
                '\n' => written.push_str("\\n"),
                '\t' => written.push_str("\\t"),
                '\\' => written.push_str("\\\\"),
                _ if *c == quote => written.extend(['\\', quote]),
                _ => written.push(*c),
            }
        }
        written.push(quote);
        (written, Json::from(text.into_iter().collect::<String>()))
    })
}

/// A field of any type. In ROS 2, it may have a default.
fn field(dialect: Dialect) -> impl Strategy<Value = (String, Option<String>, Json)> {
    let lists = (scalar(dialect), 1..5_usize, 0..4_u8, any::<bool>());
    let field = lists.prop_map(move |((ty, written, value), count, shape, has_default)| {
        let (shape, is_list) = match shape {
            0 => (format!("[{count}]"), true),
            1 if dialect == Dialect::Ros2 => (format!("[<={count}]"), true),
            2 if dialect == Dialect::Ros2 => ("[]".to_owned(), true),
            _ => (String::new(), false),
        };
        if !has_default || dialect == Dialect::Px4 {
            return (ty + &shape, None, Json::Null);
        }
        if !is_list {
            return (ty, Some(written), value);
        }
        (ty + &shape, Some(format!("[{}]", vec![written; count].join(", "))), Json::from(vec![value; count]))
    });
    let other = prop_oneof![Just("Other"), Just("Other[2]")].prop_map(|ty| (ty.to_owned(), None, Json::Null));
    prop_oneof![9 => field, 1 => other]
}

fn declaration(dialect: Dialect) -> impl Strategy<Value = Declaration> {
    // Excludes characters that could start an annotation.
    let comment = "[a-zA-Z0-9.,;:!é°]{0,5}( [a-zA-Z0-9.,;:!#]{1,6}){0,3}";
    let field = (field(dialect), "[a-z][a-z0-9]{0,5}(_[a-z0-9]{1,3}){0,2}", comment).prop_map(
        |((ty, written, value), name, comment)| Declaration {
            is_constant: false,
            ty,
            name,
            written,
            value,
            comment,
        },
    );
    let constant = (scalar(dialect), "[A-Z][A-Z0-9]{0,3}(_[A-Z0-9]{1,3}){0,2}", comment).prop_map(
        |((ty, written, value), name, comment)| Declaration {
            is_constant: true,
            ty,
            name,
            written: Some(written),
            value,
            comment,
        },
    );
    prop_oneof![field, constant]
}

/// A message whose declarations have unique names and any allowed white space.
fn message(dialect: Dialect) -> impl Strategy<Value = (Vec<Declaration>, String)> {
    let blanks = || select(vec![" ", "  ", " \t", " "]);
    let line = (
        declaration(dialect),
        [blanks(), blanks(), blanks(), blanks()],
        select(vec!["\n", "\r\n", "\n\n", "\n# x\n\n"]),
    );
    vec(line, 0..12).prop_map(|lines| {
        let mut text = String::new();
        let mut declarations = Vec::new();
        for (index, (mut declaration, [a, b, c, d], end)) in lines.into_iter().enumerate() {
            write!(declaration.name, "{}{index}", if declaration.is_constant { "X" } else { "x" })
                .expect("a string");
            let Declaration { ty, name, written, .. } = &declaration;
            let value = match written {
                Some(value) if declaration.is_constant => format!("{b}={c}{value}"),
                Some(value) => format!("{b}{value}"),
                None => String::new(),
            };
            write!(text, "{ty}{a}{name}{value}{d}# {}{end}", declaration.comment).expect("a string");
            declarations.push(declaration);
        }
        (declarations, text)
    })
}

/// The type, name, value and comment of each field and constant.
fn declared(schema: &Schema, message: &Message) -> [Vec<(String, String, Json, String)>; 2] {
    let model = inspect::schema(schema);
    let model = &model["packages"]["demo"]["messages"][&message.name];
    let list = |key: &str, value: &str| -> Vec<(String, String, Json, String)> {
        let text = |entry: &Json| entry.as_str().expect("a text").to_owned();
        let entries = model[key].as_array().expect("a list").iter();
        entries
            .map(|entry| {
                (
                    text(&entry["type"]),
                    text(&entry["name"]),
                    entry[value].clone(),
                    text(&entry["description"]),
                )
            })
            .collect()
    };
    [list("fields", "default"), list("constants", "value")]
}

/// Prints the model as a definition.
fn print(schema: &Schema, message: &Message) -> String {
    let mut text = String::new();
    for field in &message.fields {
        let default = field.default.as_ref().map(|value| format!(" {value}")).unwrap_or_default();
        writeln!(
            text,
            "{} {}{default}  # {}",
            schema.type_text(message, field.ty),
            field.name,
            field.description
        )
        .expect("a string");
    }
    for constant in &message.constants {
        assert!(!matches!(constant.ty, Element::Message(_)));
        let ty = schema.type_text(message, Type { element: constant.ty, shape: Shape::Single });
        writeln!(text, "{ty} {}={}  # {}", constant.name, constant.value, constant.description)
            .expect("a string");
    }
    text
}

fn check_message(dialect: Dialect, declarations: &[Declaration], text: &str) -> Result<(), TestCaseError> {
    let parse =
        |text: &str| support::texts(Form::Msg(dialect), &[("Glider.msg", text), ("Other.msg", "uint8 a\n")]);
    let (sources, schema, diagnostics) = parse(text);
    prop_assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    let found = declared(&schema, &schema.messages[0]);
    let expected = [false, true].map(|is_constant| {
        let of_kind = declarations.iter().filter(|declaration| declaration.is_constant == is_constant);
        let entry = |found: &Declaration| {
            (found.ty.clone(), found.name.clone(), found.value.clone(), found.comment.trim().to_owned())
        };
        of_kind.map(entry).collect::<Vec<_>>()
    });
    prop_assert_eq!(&found, &expected);
    let printed = print(&schema, &schema.messages[0]);
    let (_, again, _) = parse(&printed);
    prop_assert_eq!(&declared(&again, &again.messages[0]), &found, "{}", printed);
    let (first, second) = (&schema.messages[0], &again.messages[0]);
    prop_assert_eq!((first.hash, &first.type_hash, first.cdr), (second.hash, &second.type_hash, second.cdr));
    check_output(&schema, &sources)
}

proptest! {
    #![proptest_config(support::usual(1))]

    #[test]
    fn printed_px4_messages_are_read_back((declarations, text) in message(Dialect::Px4)) {
        check_message(Dialect::Px4, &declarations, &text)?;
    }

    #[test]
    fn printed_ros2_messages_are_read_back((declarations, text) in message(Dialect::Ros2)) {
        check_message(Dialect::Ros2, &declarations, &text)?;
    }
}

/// The headings of error-code tables, each with its first code and the number of codes.
const HEADINGS: [(&str, u32, u32); 5] = [
    ("Informational messages (codes 1-63)", 1, 63),
    ("Warnings (codes 64-127)", 64, 64),
    ("Errors (codes 128-191)", 128, 64),
    ("Boats (codes 512-767)", 512, 256),
    ("User-defined error codes (codes 32768 and above)", 32_768, 1000),
];

/// A row: the difference from the previous code, the abbreviation, and the description.
type PageRow = (u32, String, String);

fn page() -> impl Strategy<Value = Vec<(usize, Vec<PageRow>)>> {
    let word = "[A-Za-z0-9é]{1,7}[.,;]?|RC_LOST|a\\|b|\\|";
    // Exclude words that refer to a code if a number follows.
    let word = word.prop_filter("a reference", |word| !word.to_lowercase().starts_with("code"));
    let description = prop_oneof![
        4 => vec(word, 1..9).prop_map(|words| words.join(" ")),
        1 => Just("Use this error code only if afloat; otherwise use code 999.".to_owned()),
        1 => Just("Since specification 2.10, see codes 998 and 999.".to_owned()),
    ];
    let row = (1..4_u32, prop_oneof![4 => "[A-Z]{1,6}", 1 => Just(String::new())], description);
    let tables = proptest::sample::subsequence((0..HEADINGS.len()).collect::<Vec<_>>(), 1..=HEADINGS.len());
    (tables, vec(vec(row, 1..8), HEADINGS.len()))
        .prop_map(|(tables, rows)| tables.into_iter().zip(rows).collect())
}

/// The page in Markdown, in `AsciiDoc` and as flattened text. In each format, the text ends with a table of the error
/// codes 998 and 999.
fn printed(page: &[(usize, Vec<PageRow>)]) -> [(&'static str, String); 3] {
    let mut forms = ["md", "adoc", "txt"].map(|extension| (extension, String::new()));
    let [(_, markdown), (_, asciidoc), (_, flattened)] = &mut forms;
    let mut table = |heading: &str, rows: &[(u32, String, String)]| {
        write!(markdown, "## {heading}\n\n| Code | Abbr | Description |\n|--:|:--|---|\n").expect("a string");
        write!(asciidoc, "== {heading}\n\n[cols=\"1,1,5\"]\n|===\n|Code |Abbr |Description\n\n")
            .expect("a string");
        write!(flattened, "{heading}\nCode | Abbr | Description |\n---|---|---|\n").expect("a string");
        for (code, abbreviation, description) in rows {
            let text = description.replace('|', "\\|");
            writeln!(markdown, "| {code} | {abbreviation} | {text} |").expect("a string");
            write!(asciidoc, "|{code}\n|{abbreviation}\n|{}\n\n", text.replace(' ', "\n")).expect("a string");
            write!(flattened, "{code} |\n{abbreviation} |\n{} |\n", text.replacen(' ', "\n", 1))
                .expect("a string");
        }
        markdown.push('\n');
        asciidoc.push_str("|===\n\n");
        flattened.push('\n');
    };
    for (heading, rows) in page {
        let (heading, first, count) = HEADINGS[*heading];
        let mut code = first;
        let mut numbered = Vec::new();
        for (index, (step, abbreviation, description)) in rows.iter().enumerate() {
            let abbreviation =
                if abbreviation.is_empty() { String::new() } else { format!("{abbreviation}{index}") };
            numbered.push((code, abbreviation, description.clone()));
            code = (code + step).min(first + count - 1);
        }
        table(heading, &numbered);
    }
    let last = [(998, "A"), (999, "B")].map(|(code, name)| (code, name.to_owned(), "The last.".to_owned()));
    table("Rafts (codes 990-999)", &last);
    forms
}

proptest! {
    #![proptest_config(support::usual(1))]

    #[test]
    fn all_forms_of_a_page_have_the_same_model(page in page()) {
        let mut models: Vec<(Vec<ErrorTable>, Vec<&str>)> = Vec::new();
        for (extension, text) in printed(&page) {
            let mut sources = SourceMap::default();
            let mut package = support::package("demo", Form::Table);
            package.sources = vec![sources.add(format!("page.{extension}"), text.clone().into_bytes()).expect("valid")];
            let (mut schema, diagnostics) = read(&sources, &[package]);
            prop_assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
            let mut tables = std::mem::take(&mut schema.packages[0].error_tables);
            for table in &mut tables {
                table.span = Span::default();
                table.codes.iter_mut().for_each(|code| code.span = Span::default());
            }
            models.push((tables, diagnostics.iter().map(|diagnostic| diagnostic.problem.code()).collect()));
        }
        let rows = page.iter().map(|(_, rows)| rows.len()).sum::<usize>() + 2;
        prop_assert_eq!(models[0].0.iter().map(|table| table.codes.len()).sum::<usize>(), rows);
        prop_assert_eq!(&models[0], &models[1]);
        prop_assert_eq!(&models[0], &models[2]);
    }
}
