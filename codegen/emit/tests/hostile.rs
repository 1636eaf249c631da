//! Malicious input produces diagnostics or a model, in bounded time and memory. The tests don't measure time, but
//! quadratic algorithms would not finish with the sizes of a thorough run.

use std::fmt::Write as _;

use support::extent;
use uavspec_emit::{docs, inspect, json_schema, vectors};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Diagnostic, Form, PackageInput, Schema, SourceMap, read, read_formats, render};
use uavspec_test_definitions as support;

const PX4: Form = Form::Msg(Dialect::Px4);
const ROS2: Form = Form::Msg(Dialect::Ros2);

/// A function that reads packages.
type Read = fn(&SourceMap, &[PackageInput]) -> (Schema, Vec<Diagnostic>);

/// Reads a package, renders the diagnostics, and emits the model unless there are errors.
fn read_with(read: Read, form: Form, files: &[(String, Vec<u8>)]) -> (SourceMap, Schema, Vec<Diagnostic>) {
    let mut sources = SourceMap::default();
    let mut package = support::package("demo", form);
    let mut diagnostics = Vec::new();
    for (path, bytes) in files {
        match sources.add(path.as_str(), bytes.clone()) {
            Ok(id) => package.sources.push(id),
            Err(diagnostic) => diagnostics.push(diagnostic),
        }
    }
    let (schema, mut found) = read(&sources, &[package]);
    diagnostics.append(&mut found);
    render::render(&diagnostics, &sources, false);
    if !has_errors(&diagnostics) {
        inspect::schema(&schema);
    }
    (sources, schema, diagnostics)
}

fn read_all(form: Form, files: &[(String, Vec<u8>)]) -> (Schema, Vec<Diagnostic>) {
    let (_, schema, diagnostics) = read_with(read, form, files);
    (schema, diagnostics)
}

/// The diagnostic codes for a single message.
fn codes(form: Form, text: impl Into<Vec<u8>>) -> Vec<&'static str> {
    codes_of(form, &[("Glider.msg".to_owned(), text.into())])
}

fn codes_of(form: Form, files: &[(String, Vec<u8>)]) -> Vec<&'static str> {
    read_all(form, files).1.iter().map(|diagnostic| diagnostic.problem.code()).collect()
}

fn file(name: &str, text: impl Into<Vec<u8>>) -> (String, Vec<u8>) {
    (format!("{name}.msg"), text.into())
}

#[test]
fn rejects_deceptive_characters() {
    for (text, expected) in [
        (&b"uint8 a\r\nuint8 b\r\n"[..], &[][..]),
        (b"\xef\xbb\xbfuint8 a\n", &["byte-order-mark"]),
        (b"\xff\xfeu\0i\0n\0t\08\0", &["invalid-utf8"]),
        (b"uint8 a # \xc3\x28\n", &["invalid-utf8"]),
        (b"uint8 a\0b\n", &["control-character"]),
        (b"uint8 a # \0\n", &["control-character"]),
        (b"uint8 a # x\x0cuint8 b\n", &["line-separator"]),
        ("uint8 a # x\u{2028}uint8 b\n".as_bytes(), &["line-separator"]),
        ("uint8 a # x\u{85}uint8 b\n".as_bytes(), &["line-separator"]),
        (b"uint8 a\ruint8 b\n", &["line-separator"]),
    ] {
        for form in [PX4, ROS2] {
            assert_eq!(codes(form, text), expected, "{text:?}");
        }
    }
}

#[test]
fn rejects_excessive_sizes() {
    assert_eq!(codes(PX4, "uint8[4294967296] a\n"), ["too-large"]);
    assert_eq!(codes(PX4, "uint8[99999999999999999999999] a\n"), ["too-large"]);
    assert_eq!(codes(ROS2, "string<=4294967295[<=4294967295] a\n"), ["too-large"]);
    assert_eq!(codes(PX4, format!("uint64 A={}\n", "9".repeat(100_000))), ["constant-out-of-range"]);
    assert_eq!(codes(PX4, format!("float64 A=1{}\n", "0".repeat(100_000))), ["constant-out-of-range"]);
    // No multiplication may overflow.
    let arrays = ["A", "B", "C", "D"].map(|name| {
        let below = char::from(name.as_bytes()[0] - 1);
        let ty = if name == "A" { "uint64".to_owned() } else { below.to_string() };
        file(name, format!("uint8 start\n{ty}[16777216] part\n"))
    });
    for form in [PX4, ROS2] {
        assert_eq!(codes_of(form, &arrays), ["too-large"], "reported once, not for each containing message");
    }
}

#[test]
fn keywords_of_other_languages_are_valid_names() {
    let names =
        ["self", "type", "crate", "super", "match", "gen", "async", "r#type", "box", "union", "static"];
    let fields: String =
        names.iter().filter(|name| !name.contains('#')).map(|name| format!("uint8 {name}\n")).collect();
    let files =
        [file("Self", fields), file("Option", "Self some\nString none\n"), file("String", "uint8 SELF=1\n")];
    assert_eq!(codes_of(PX4, &files), [""; 0]);
    assert_eq!(codes(PX4, "uint8 r#type\n"), [""; 0], "a field `r` and a comment");
    {
        let mut sources = SourceMap::default();
        let mut package = support::package("crate", PX4);
        package.sources = files.map(|(path, text)| sources.add(path, text).expect("valid")).to_vec();
        let (schema, _) = read(&sources, &[package]);
        for file in uavspec_emit::rust::emit(&schema, &sources, &uavspec_emit::rust::Options::default()) {
            assert!(!file.text.contains("compile_error!"), "{}", file.text);
        }
    }
}

#[test]
fn reads_a_file_of_100_000_lines() {
    let count = extent(20_000, 3_000);
    let mut text = String::new();
    for line in 0..count {
        // Each line requires a lookup among all other lines.
        writeln!(text, "uint8 num_list{line}\nuint8[2] list{line}  # [@count num_list{line}]")
            .expect("a string");
        writeln!(text, "uint32 MODE_{line}={line}\nuint32 mode{line}  # [@enum MODE] x\n  # and more")
            .expect("a string");
    }
    let (schema, diagnostics) = read_all(PX4, &[file("Glider", text)]);
    assert_eq!(diagnostics.len(), count, "each list is rejected as a count");
    assert_eq!(schema.messages[0].fields.len(), 3 * count);
    assert_eq!(schema.messages[0].enums.len(), 1, "all fields share one enum");
    let lines = 5 * count;
    let comments = "uint8 a  # x\n".to_owned() + &"  # y\n".repeat(lines);
    let (schema, _) = read_all(PX4, &[file("Glider", comments)]);
    assert_eq!(schema.messages[0].fields[0].description.len(), 2 * lines + 1);
    let topics: String = (0..lines).map(|topic| format!("# TOPICS topic{topic}\n")).collect();
    assert_eq!(read_all(PX4, &[file("Glider", topics)]).0.messages[0].topics.len(), lines);
    let bad = codes(PX4, "uint8\n".repeat(lines));
    assert!(bad.iter().all(|code| *code == "missing-name"));
    assert!(bad.len() < 2_000, "reading stops after too many invalid lines");
}

/// Repeats `text` up to one megabyte, or up to 16 kB in a quick run.
fn megabyte(text: &str) -> String {
    text.repeat(extent(1_000_000, 16_000) / text.len())
}

#[test]
fn reads_a_line_of_a_megabyte() {
    let starts = [
        (PX4, ""),
        (PX4, "uint8 a  # "),
        (PX4, "uint8 A=1  # x "),
        (PX4, "uint8 A="),
        (PX4, "uint8["),
        (ROS2, "string a \""),
        (ROS2, "uint8[] a ["),
        (ROS2, "string A="),
    ];
    let bodies = [
        "[", "|", "(@", "[@", "[@range ", "(@x)", "[m]", "#", "\\\"", "=", "_", "a", "a ", "9", "-",
        "\u{feff}",
    ];
    for (number, body) in bodies.map(megabyte).into_iter().enumerate() {
        // A quick run reads each line with every other start.
        for (form, start) in starts.into_iter().skip(extent(0, number % 2)).step_by(extent(1, 2)) {
            read_all(form, &[file("Glider", format!("{start}{body}"))]);
        }
    }
    for body in ["[", "|", "(@", "64|A|"].map(megabyte) {
        for path in ["page.md", "page.adoc", "page.txt"] {
            let page = format!("# Warnings\nCode|Abbr|Description\n-|-|-\n64|A|{body}\n");
            read_all(Form::Table, &[(path.to_owned(), page.into_bytes())]);
        }
    }
}

#[test]
fn deep_nesting_does_not_overflow_the_stack() {
    let chain = |count: usize| -> Vec<(String, Vec<u8>)> {
        (0..count)
            .map(|link| {
                let ty = if link == 0 { "bool".to_owned() } else { format!("Link{}", link - 1) };
                file(&format!("Link{link}"), format!("{ty} part\n"))
            })
            .collect()
    };
    // The hash of a message covers all messages below it. A quick run reads the deepest messages without hashes, and
    // emits fewer levels.
    let (_, schema, diagnostics) = read_with(extent::<Read>(read, read_formats), PX4, &chain(1_001));
    assert_eq!((schema.messages.len(), diagnostics.len()), (1_001, 0));
    assert_eq!(codes_of(PX4, &chain(1_002)), ["too-much-nesting"], "only the first message is reported");
    let many = extent(20_000, 1_500);
    assert_eq!(codes_of(PX4, &chain(many)), ["too-much-nesting"]);
    let (sources, schema, diagnostics) = read_with(read, PX4, &chain(extent(1_001, 150)));
    assert!(diagnostics.is_empty(), "{:?}", diagnostics.first());
    emit_all(&schema, &sources);
    let mut ring = chain(many);
    ring[0] = file("Link0", format!("Link{} part\n", many - 1));
    let (_, diagnostics) = read_all(PX4, &ring);
    assert_eq!(diagnostics.iter().map(|diagnostic| diagnostic.problem.code()).collect::<Vec<_>>(), ["cycle"]);
    assert!(
        diagnostics[0].problem.to_string().len() < 1_000,
        "the middle of a path of thousands of messages is omitted"
    );
}

#[test]
fn rejects_exponential_nesting() {
    for first in ["", "bool a\n"] {
        let levels: Vec<(String, Vec<u8>)> = (0..64)
            .map(|level: u32| {
                let text = level
                    .checked_sub(1)
                    .map_or(first.to_owned(), |below| format!("Level{below} a\nLevel{below} b\n"));
                file(&format!("Level{level}"), text)
            })
            .collect();
        for form in [PX4, ROS2] {
            assert_eq!(codes_of(form, &levels), ["too-many-fields"]);
        }
    }
}

/// The limit is needed, because hashing visits each nested field of each message.
#[test]
fn limits_the_number_of_nested_fields_in_all_messages() {
    let levels = (0..18_u32).map(|level| match level.checked_sub(1) {
        None => file("Level0", "bool a\nbool b\n"),
        Some(below) => file(&format!("Level{level}"), format!("Level{below} a\nLevel{below} b\n")),
    });
    // The last level has 2^19 - 2 nested fields, and all levels together have 2^20 - 40 nested fields.
    let copies = |name: &str, count: u32| -> Vec<(String, Vec<u8>)> {
        (0..count).map(|copy| file(&format!("{name}{copy}"), "Level17 a\n")).collect()
    };
    let rest: String = (0..46).map(|field| format!("bool x{field}\n")).collect();
    let max = [levels.collect(), copies("Copy", 6), vec![file("Rest", rest)]].concat();
    // A quick run reads the definitions without hashes.
    let (_, _, diagnostics) = read_with(extent::<Read>(read, read_formats), PX4, &max);
    assert!(diagnostics.is_empty(), "2^22 fields: {:?}", diagnostics.first());
    assert_eq!(codes_of(PX4, &[max, copies("More", 3)].concat()), ["too-much-nesting"]);
}

/// A page of objects, each given by its name and its field rows.
fn objects(types: impl Iterator<Item = (String, String)>) -> Vec<(String, Vec<u8>)> {
    let mut page = String::from("# Gliders\n");
    for (name, rows) in types {
        writeln!(page, "\n## {name}\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n{rows}")
            .expect("a string");
    }
    vec![("gliders.md".to_owned(), page.into_bytes())]
}

/// Emits all outputs.
fn emit_all(schema: &Schema, sources: &SourceMap) {
    vectors::emit(schema, &vectors::Options::default());
    json_schema::emit(schema, &json_schema::Options::default());
    docs::emit(schema, &Translations::default(), sources, &docs::Options::default());
    uavspec_emit::rust::emit(schema, sources, &uavspec_emit::rust::Options::default());
}

/// Reads a page and emits all outputs, in bounded time and memory.
fn emit_page(files: &[(String, Vec<u8>)]) -> Vec<&'static str> {
    let (sources, schema, diagnostics) = read_with(read, Form::Table, files);
    if !has_errors(&diagnostics) {
        emit_all(&schema, &sources);
    }
    diagnostics.iter().map(|diagnostic| diagnostic.problem.code()).collect()
}

#[test]
fn deeply_nested_types_of_pages_need_bounded_stack_and_memory() {
    let chain = |count: usize, first: &str| {
        let row = |link: usize| match link.checked_sub(1) {
            Some(below) => format!("|part|yes|Link{below}|x|\n"),
            None => first.to_owned(),
        };
        objects((0..count).map(move |link| (format!("Link{link}"), row(link))))
    };
    let ring =
        |count: usize, required: &str| chain(count, &format!("|part|{required}|Link{}|x|\n", count - 1));
    // A quick run emits fewer levels than it reads.
    assert_eq!(codes_of(Form::Table, &chain(1_000, "|part|yes|string|x|\n")), [""; 0]);
    let levels = extent(1_000, 100);
    assert_eq!(emit_page(&chain(levels, "|part|yes|string|x|\n")), [""; 0]);
    assert_eq!(emit_page(&ring(levels, "no")), [""; 0], "a cycle of optional fields");
    assert_eq!(emit_page(&chain(1_001, "|part|yes|string|x|\n")), ["too-much-nesting"]);
    assert_eq!(emit_page(&ring(extent(20_000, 1_200), "no")), ["too-much-nesting"], "a long cycle");
    assert_eq!(emit_page(&ring(extent(10_000, 1_200), "yes")), ["endless-type"]);
    let doubled = objects((0..extent(64, 24)).map(|level: u32| {
        let ty = level.checked_sub(1).map_or("string".to_owned(), |below| format!("Level{below}"));
        (format!("Level{level}"), format!("|a|yes|{ty}|x|\n|b|yes|list of {ty}|x|\n|c|no|{ty}|x|\n"))
    }));
    assert_eq!(emit_page(&doubled), [""; 0]);
    let wide: String = (0..extent(5_000, 500))
        .map(|field| format!("|field{field}|no|list of integer|[@range 0, 9] x|\n"))
        .collect();
    assert_eq!(emit_page(&objects([("Wide".to_owned(), wide)].into_iter())), [""; 0]);
    let names = (0..extent(1_000, 400)).map(|link: u32| {
        let below = link.checked_sub(1).map_or("string".to_owned(), |below| format!("Link{below}"));
        format!("## Link{link}\n\nnull or {below}\n\n")
    });
    let names = vec![("names.md".to_owned(), names.collect::<String>().into_bytes())];
    assert!(emit_page(&names).iter().all(|code| *code == "too-many-parts"));
}

#[test]
fn reads_tables_of_types_in_linear_time() {
    let header = "|Field|Required|Type|Description|\n|-|-|-|-|\n";
    let bodies =
        ["(", "list of ", "a or ", "a, ", "\"", "one of a, ", "[", "[@pattern ", "[@pattern [", "\\"];
    for (number, body) in bodies.into_iter().enumerate() {
        let body = body.repeat(extent(1 << 17, 1 << 14) / body.len());
        let pages = [
            format!("# Gliders\n\n## Mark\n\n{header}|a|yes|{body}|x|\n"),
            format!("# Gliders\n\n## Mark\n\n{header}|a|yes|string|{body}|\n"),
            format!("# Gliders\n\n## Mark\n\nlist of {body}\n"),
            format!("# Gliders\n\n## Mark\n\nstring, {body}\n"),
            format!("# Gliders\n\n## {body}\n\n{header}"),
        ];
        for (at, page) in pages.into_iter().enumerate() {
            // A quick run reads each page in one of the formats.
            let skipped = extent(0, (number + at) % 2);
            for path in ["page.md", "page.adoc"].into_iter().skip(skipped).step_by(extent(1, 2)) {
                read_all(Form::Table, &[(path.to_owned(), page.clone().into_bytes())]);
            }
        }
    }
    let messages: String = (0..extent(20_000, 1_000))
        .map(|number| format!("## M-{number}\n\n### Request\n\nNo fields besides type.\n\nAnswer: M-{}\n\n### Response\n\nNo fields besides type.\n\n", number + 1))
        .collect();
    let files = [("messages.md".to_owned(), format!("# Messages\n\n{messages}").into_bytes())];
    assert_eq!(codes_of(Form::Table, &files), ["unknown-answer"], "only the last message has no answer");
}

#[test]
fn reports_thousands_of_unknown_types() {
    let count = extent(5_000, 1_000);
    let text: String = (0..count).map(|number| format!("Unknown{number} field{number}\n")).collect();
    let known = (0..count / 5).map(|number| file(&format!("Known{number}"), ""));
    let files: Vec<_> = known.chain([file("Glider", text)]).collect();
    assert_eq!(codes_of(PX4, &files), vec!["unknown-type"; count]);
    // Finding similar names takes time and memory proportional to the product of the lengths.
    let long = "A".repeat(extent(1_000_000, 200_000));
    let files = [file("Glider", format!("{long} a\n")), file(&format!("{long}A"), "")];
    assert_eq!(codes_of(PX4, &files), ["unknown-type"]);
}

/// A package: the name, the form, and the paths and texts of the sources.
type NamedPackage = (&'static str, Form, Vec<(String, String)>);

/// The definitions of this project that a quick run reads. These definitions refer to no others.
const FEW: [&str; 6] = [
    "ArmingCheckReply.msg",
    "Event.msg",
    "UnregisterExtComponent.msg",
    "ack.md",
    "error-codes.md",
    "timesync.md",
];

/// All outputs for `packages`, with the sources rotated by `turn`.
fn emitted(packages: &[NamedPackage], turn: usize) -> Vec<String> {
    let mut all: Vec<(usize, &String, &String)> = Vec::new();
    for (index, (_, _, files)) in packages.iter().enumerate() {
        all.extend(files.iter().map(|(path, text)| (index, path, text)));
    }
    let count = all.len();
    all.rotate_left(turn * 7 % count);
    if turn % 2 == 1 {
        all.reverse();
    }
    let mut sources = SourceMap::default();
    let mut inputs: Vec<PackageInput> =
        packages.iter().map(|(name, form, _)| support::package(name, *form)).collect();
    for (package, path, text) in all {
        inputs[package].sources.push(sources.add(path.as_str(), text.clone().into_bytes()).expect("valid"));
    }
    inputs.rotate_left(turn % packages.len());
    let (schema, diagnostics) = read(&sources, &inputs);
    assert!(!has_errors(&diagnostics), "{}", render::render(&diagnostics, &sources, false));
    let mut model = vec![inspect::schema(&schema).to_string()];
    let emitted = vectors::emit(&schema, &vectors::Options::default());
    model.extend(emitted.into_iter().map(|file| file.path + "\n" + &file.text));
    let files = uavspec_emit::rust::emit(&schema, &sources, &uavspec_emit::rust::Options::default());
    model.into_iter().chain(files.into_iter().map(|file| file.path + "\n" + &file.text)).collect()
}

#[test]
fn the_order_of_sources_does_not_affect_outputs() {
    let definitions = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../definitions");
    let text_of = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).expect("a definition");
        (path.file_name().expect("a name").to_string_lossy().into_owned(), text)
    };
    let of = |folder: &str, extension: &str| -> Vec<(String, String)> {
        let files = support::files_below(&definitions.join(folder), &[extension]);
        let texts = files.iter().map(text_of);
        texts.filter(|(name, _)| extent(true, FEW.contains(&name.as_str()))).collect()
    };
    let ros = [
        ("Point", "float64 x\nuint8 KIND_A=1\nuint8 KIND_B=1\nuint8 kind # [@enum KIND]\n"),
        ("Line", "Point[2] end\nzeta/Zone zone\n"),
    ];
    let zone = [("Zone", "string name \"a\"\n"), ("Area", "Zone[] zone\n")];
    let named = |files: &[(&str, &str)]| {
        files.iter().map(|(name, text)| (format!("{name}.msg"), (*text).to_owned())).collect()
    };
    let packages = [
        ("px4", PX4, of("px4", "msg")),
        ("flockwave", Form::Table, of("flockwave", "md")),
        ("geometry", ROS2, named(&ros)),
        ("zeta", ROS2, named(&zone)),
    ];
    let first = emitted(&packages, 0);
    for turn in (1..8).step_by(extent(1, 3)) {
        assert!(emitted(&packages, turn) == first, "the output differs for turn {turn}");
    }
}
