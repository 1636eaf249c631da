//! Tests that outputs and allocations grow linearly with the size of the definitions, in each dimension.

use std::fmt::Write as _;
use std::fs;

use allocation_counter::measure;
use uavspec_codegen::generate;
use uavspec_dynamic::breaking::{Between, breaking};
use uavspec_emit::{EMITTERS, docs, inspect, json_schema, python, typescript, vectors};
use uavspec_lint::format::format;
use uavspec_lint::{Preset, Settings, apply, lint};
use uavspec_schema::diagnostic::has_errors;
use uavspec_schema::msg::Dialect;
use uavspec_schema::translation::Translations;
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read, render};
use uavspec_test_definitions as support;
use walkdir::WalkDir;

/// The files of a package.
type Files = Vec<(String, String)>;

/// The size of the output of each emitter, in bytes.
fn sizes(files: &Files) -> Vec<(&'static str, u64)> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut config =
        "[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n[output]\n".to_owned();
    for emitter in EMITTERS {
        writeln!(config, "{0} = \"out/{0}\"", emitter.name).expect("a string");
    }
    let path = folder.path().join("uavspec.toml");
    fs::write(&path, config).expect("a file");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    generate(&path).expect("valid definitions");
    let size = |name: &str| {
        let entries = WalkDir::new(folder.path().join("out").join(name)).into_iter();
        entries.map(|entry| entry.and_then(|entry| entry.metadata()).expect("a file").len()).sum()
    };
    EMITTERS.iter().map(|emitter| (emitter.name, size(emitter.name))).collect()
}

fn message(lines: impl Iterator<Item = String>) -> Files {
    vec![("Wind.msg".to_owned(), format!("uint64 timestamp  # [us] Time\n{}", lines.collect::<String>()))]
}

fn fields(count: usize) -> Files {
    message((0..count).map(|number| format!("uint8 wind_{number:05}  # [m/s] Speed\n")))
}

fn constants(count: usize) -> Files {
    let constants = (0..count).map(|number| format!("uint16 WIND_{number:05} = {number}  # A wind\n"));
    message(constants.chain(["uint16 wind  # [@enum WIND] The wind\n".to_owned()]))
}

fn length_of_names(length: usize) -> Files {
    message(["a", "b"].iter().map(|name| format!("uint8 {}  # [m/s] Speed\n", name.repeat(length))))
}

fn files(count: usize) -> Files {
    (0..count)
        .map(|number| (format!("Wind{number:05}.msg"), "uint64 timestamp  # [us] Time\n".to_owned()))
        .collect()
}

#[test]
fn outputs_grow_linearly_with_the_definitions() {
    for (name, count, files) in [
        // Use many fields. With fewer fields, there would be vectors for each field, which grow quadratically.
        ("fields", support::extent(2_000, 600), fields as fn(usize) -> Files),
        ("constants", support::extent(2_000, 300), constants),
        ("names", 50, length_of_names),
        ("files", support::extent(40, 12), self::files),
    ] {
        for ((emitter, once), (_, twice)) in sizes(&files(count)).into_iter().zip(sizes(&files(2 * count))) {
            assert!(
                once > 0 && twice * 10 <= once * 22,
                "{emitter}, twice the {name}: {once} and {twice} bytes"
            );
        }
    }
}

/// A dimension in which definitions grow: its name, the form of the definitions, the number of parts, and a function
/// that creates the files with a given number of parts.
type Dimension = (&'static str, Form, usize, fn(usize) -> Files);

const PX4: Form = Form::Msg(Dialect::Px4);
const ROS2: Form = Form::Msg(Dialect::Ros2);

const DIMENSIONS: [Dimension; 23] = [
    ("fields", PX4, 200, fields),
    ("constants", PX4, 200, constants),
    ("lengths of names", PX4, 1_000, length_of_names),
    ("files", PX4, 40, files),
    ("nested definitions", PX4, 40, |count| {
        let nested = numbered(count, "Wind~ wind_~  # Wind ~\n");
        [files(count), vec![("Storm.msg".to_owned(), format!("uint64 timestamp  # [us] Time\n{nested}"))]]
            .concat()
    }),
    ("fields without comments", PX4, 200, |count| message_of(numbered(count, "  uint8   wind_~\n"))),
    ("fields with an enum", PX4, 200, |count| {
        message_of(
            "uint8 WIND_CALM = 0  # Calm\n".to_owned()
                + &numbered(count, "uint8 wind_~  # [@enum WIND] The wind\n"),
        )
    }),
    ("names that differ in underscores", PX4, 100, |count| {
        let separator = |number: usize, bit: usize| if number >> bit & 1 == 0 { "_" } else { "__" };
        let name =
            |number: usize| (0..9).fold("a".to_owned(), |name, bit| name + separator(number, bit) + "a");
        message((0..count).map(|number| format!("uint8 {}  # [m/s] Speed\n", name(number))))
    }),
    ("fields of one name", PX4, 200, |count| message_of(numbered(count, "uint8 wind  # [m/s] Speed\n"))),
    ("unknown names", PX4, 100, |count| {
        message_of(numbered(count, "Gust~ gust_~\nuint8 wind_~  # [@count gale_~] [@enum GUST_~] Speed\n"))
    }),
    ("lines of a comment", PX4, 500, |count| message_of(numbered(count, "# Line ~ of the comment.\n"))),
    ("topics", PX4, 500, |count| message_of(numbered(count, "# TOPICS wind_~\n"))),
    ("values of a default", ROS2, 500, |count| {
        message_of(format!("uint16[] winds [{}1]\n", numbered(count, "1~, ")))
    }),
    ("error codes", Form::Table, 200, |count| {
        page(
            "# Winds (codes 100000 and above)\n\n|Code|Abbr|Description|\n|-|-|-|\n",
            &numbered(count, "|1~|W~|Wind ~|\n"),
        )
    }),
    ("tables of error codes", Form::Table, 40, |count| {
        let table = "## Winds ~ (codes 1~-1~)\n\n|Code|Abbr|Description|\n|-|-|-|\n|1~|W~|Wind ~|\n\n";
        page("# Winds\n\n", &numbered(count, table))
    }),
    ("fields of a type", Form::Table, 100, |count| {
        page(
            &format!("# Winds\n\n## Wind\n\n{HEAD}"),
            &numbered(count, "|wind_~|yes|number|[m/s] Speed ~|\n"),
        )
    }),
    ("types", Form::Table, 40, |count| {
        page("# Winds\n\n", &numbered(count, &format!("## Wind~\n\n{HEAD}|speed|no|Wind~|Speed ~|\n\n")))
    }),
    ("alternatives", Form::Table, 40, |count| {
        page(
            "# Winds\n\n## Wind\n\n",
            &format!("{HEAD}|speed|yes|one of {}calm|Speed|\n", numbered(count, "w~, ")),
        )
    }),
    ("messages", Form::Table, 40, |count| {
        let message = "## WIND-~\n\n### Request\n\nNo fields besides type.\n\n### Response\n\nNo fields besides type.\n\n";
        page("# Winds\n\n", &numbered(count, message))
    }),
    ("events", Form::Events, 60, |count| {
        metadata("", &numbered(count, "\"1~\": {\"name\": \"wind_~\", \"message\": \"Wind\"},\n"))
    }),
    ("arguments of unknown types", Form::Events, 60, |count| {
        let argument = "{\"name\": \"wind_~\", \"type\": \"gale_~_t\"},\n";
        metadata("", &event(&numbered(count, argument)))
    }),
    ("enums of events", Form::Events, 60, |count| {
        let declared = "\"wind_~_t\": {\"type\": \"uint8_t\", \"entries\": {}},\n";
        metadata(&numbered(count, declared), &event(""))
    }),
    ("entries of an enum", Form::Events, 200, |count| {
        let entries = numbered(count, "\"~\": {\"name\": \"wind_~\", \"description\": \"Wind ~\"},\n");
        let declared = format!("\"wind_t\": {{\"type\": \"uint32_t\", \"entries\": {{{entries}}}}},");
        metadata(&declared, &event("{\"name\": \"wind\", \"type\": \"wind_t\"},"))
    }),
];

fn event(arguments: &str) -> String {
    format!("\"1\": {{\"name\": \"wind\", \"message\": \"Wind\", \"arguments\": [{arguments}]}},")
}

/// Event metadata with lists of enums and events. Each item ends with a comma, and the last comma is removed.
fn metadata(enums: &str, events: &str) -> Files {
    let text = format!(
        "{{\"version\": 2, \"components\": {{\"0\": {{\"namespace\": \"common\", \"enums\": {{{enums}}},\n\
         \"event_groups\": {{\"default\": {{\"events\": {{{events}}}}}}}}}}}}}\n"
    );
    let text = text.replace(",\n}", "\n}").replace(",\n]", "\n]").replace(",}", "}").replace(",]", "]");
    vec![("winds.json".to_owned(), text)]
}

const HEAD: &str = "|Field|Required|Type|Description|\n|-|-|-|-|\n";

/// Copies of a text, with a number of five digits in place of `~`.
fn numbered(count: usize, text: &str) -> String {
    (0..count).map(|number| text.replace('~', &format!("{number:05}"))).collect()
}

fn message_of(lines: String) -> Files {
    message([lines].into_iter())
}

fn page(head: &str, rest: &str) -> Files {
    vec![("winds.md".to_owned(), format!("{head}{rest}"))]
}

/// Reads files in one form.
type Work = fn(Form, &Files);

/// The tested operations, each with its name and a factor. The number of parts of a dimension is multiplied by this
/// factor.
const WORK: &[(&str, usize, Work)] = &[
    ("reading", 1, |form, files| {
        let (sources, package) = input(form, files);
        let (schema, diagnostics) = read(&sources, &[package]);
        render::render(&diagnostics, &sources, false);
        inspect::schema(&schema);
    }),
    ("linting", 1, |form, files| {
        let (sources, package) = input(form, files);
        let settings = Settings { preset: Preset::Strict, ..Settings::default() };
        let findings = lint(&sources, &[package], &[], &settings);
        render::findings(&findings, &sources, false);
        apply(&findings, &sources);
    }),
    ("formatting", 1, |form, files| {
        let (sources, package) = input(form, files);
        for id in package.sources {
            let _ = format(&sources, id, form);
        }
    }),
    ("comparing", 1, |form, files| {
        let changed = |(name, text): &(String, String)| {
            (name.clone(), text.replace("wind_", "gale_").replace("uint8", "int16"))
        };
        let (mut sources, old) = input(form, files);
        let new = add(&mut sources, form, &files.iter().map(changed).collect());
        let [old, new] = [old, new].map(|package| read(&sources, &[package]));
        if !has_errors(&old.1) && !has_errors(&new.1) {
            breaking(&sources, &old.0, &new.0, Between::default());
        }
    }),
    ("emitting JSON Schemas", 1, |form, files| {
        emit(form, files, |schema, _| json_schema::emit(schema, &json_schema::Options::default()));
    }),
    ("emitting documentation", 1, |form, files| {
        emit(form, files, |schema, sources| {
            docs::emit(schema, &Translations::default(), sources, &docs::Options::default())
        });
    }),
    ("emitting TypeScript", 1, |form, files| {
        emit(form, files, |schema, _| {
            typescript::emit(schema, &Translations::default(), &typescript::Options::default())
        });
    }),
    ("emitting Python", 1, |form, files| {
        emit(form, files, |schema, _| python::emit(schema, &Translations::default()));
    }),
    // Use large messages, which have no vectors for each field. For messages with few fields, these vectors grow
    // quadratically.
    ("emitting vectors", 8, |form, files| {
        emit(form, files, |schema, _| vectors::emit(schema, &vectors::Options::default()));
    }),
    ("emitting Rust", 1, |form, files| {
        emit(form, files, |schema, sources| {
            uavspec_emit::rust::emit(schema, sources, &uavspec_emit::rust::Options::default())
        });
    }),
    ("editing", 1, |form, files| crate::lsp::edit_all(form, files)),
];

/// Emits definitions that have no errors.
fn emit<T>(form: Form, files: &Files, emit: impl FnOnce(&Schema, &SourceMap) -> T) {
    let (sources, package) = input(form, files);
    let (schema, diagnostics) = read(&sources, &[package]);
    if !has_errors(&diagnostics) {
        emit(&schema, &sources);
    }
}

fn input(form: Form, files: &Files) -> (SourceMap, PackageInput) {
    let mut sources = SourceMap::default();
    let package = add(&mut sources, form, files);
    (sources, package)
}

fn add(sources: &mut SourceMap, form: Form, files: &Files) -> PackageInput {
    let mut package = support::package("demo", form);
    for (name, text) in files {
        package.sources.push(sources.add(name.as_str(), text.clone().into_bytes()).expect("a valid text"));
    }
    package
}

/// Only the allocations of this thread are counted, so the inputs are small enough to be read in one thread.
#[test]
fn allocations_grow_linearly_with_each_dimension() {
    let mut failures = Vec::new();
    let pairs = DIMENSIONS.into_iter().flat_map(|dimension| WORK.iter().map(move |work| (dimension, work)));
    // The step of a quick run selects different dimensions and parts.
    for ((name, form, count, files), (work, times, run)) in pairs.step_by(support::extent(1, 43)) {
        // Run the operation once before counting, because the first run also creates lazily initialized data.
        run(form, &files(2));
        let [once, twice] = [count, 2 * count].map(|count| {
            let files = files(times * count);
            measure(|| run(form, &files))
        });
        for (what, once, twice) in
            [("all", once.bytes_total, twice.bytes_total), ("most", once.bytes_max, twice.bytes_max)]
        {
            if 10 * twice > 22 * once {
                failures.push(format!(
                    "{work}, twice the {name}: {once} and {twice} bytes of {what} allocations"
                ));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
