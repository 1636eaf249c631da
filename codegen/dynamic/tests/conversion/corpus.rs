//! Conversions between the releases of PX4.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{Conversion, Conversions, Hints, read_hints};
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Form, PackageInput, Schema, SourceMap, read};
use uavspec_test_definitions::{add_folder, differs, extent, shared};

use super::reference::convert_json;
use super::support::PX4_HINTS;

/// The releases that the tests convert between, oldest first. A quick run converts only between the two releases with
/// the most hand-written translations.
pub(super) fn releases() -> &'static [&'static str] {
    extent::<&[&str]>(&["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"], &["1.16", "1.17"])
}

/// The definitions of the releases, each as a package, and their conversions.
pub(super) struct Corpus {
    pub(super) schema: Schema,
    /// The published hints.
    pub(super) hints: Hints,
    /// The conversions between neighbouring releases.
    pub(super) neighbours: BTreeMap<[&'static str; 2], Conversions>,
}

/// Shared by the tests, because building it takes most of their time.
pub(super) static CORPUS: LazyLock<Option<Corpus>> = LazyLock::new(|| {
    let folder = shared("corpus/px4")?;
    let mut sources = SourceMap::default();
    let mut packages = Vec::new();
    for release in releases() {
        let mut package = PackageInput::new(*release, Form::Msg(Dialect::Px4), Vec::new());
        add_folder(&mut sources, &mut package, &folder.join(release));
        packages.push(package);
    }
    let (schema, _) = read(&sources, &packages);
    let source = sources.add("px4.toml", PX4_HINTS.as_bytes().to_vec()).expect("a source");
    let hints = read_hints(&sources, source);
    assert_eq!(hints.mistakes, []);
    let mut neighbours = BTreeMap::new();
    for pair in releases().windows(2) {
        let found = Conversions::within(&schema, pair[0], pair[1], &hints).expect("both packages");
        neighbours.insert([pair[0], pair[1]], found);
    }
    Some(Corpus { schema, hints, neighbours })
});

/// The fixture lists the parts of conversions between neighbouring releases that are undecided despite the published
/// hints.
#[test]
fn lists_the_undecided_parts_between_releases() {
    let Some(corpus) = &*CORPUS else { return };
    let mut text = String::new();
    for ([old, new], found) in &corpus.neighbours {
        assert_eq!(found.mistakes, []);
        let decided = |all: &[Arc<Conversion>]| all.iter().filter(|found| found.is_decided()).count();
        let [forward, backward] = [decided(&found.forward), decided(&found.backward)];
        let messages = found.forward.len();
        writeln!(text, "{old} to {new}: {forward} of {messages}, back {backward}").expect("a string");
        for undecided in found.undecided() {
            writeln!(text, "    {}", undecided.message).expect("a string");
        }
    }
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/conversion/px4.txt");
    if extent(true, false) {
        assert_eq!(differs(&fixture, &text), None, "UAVSPEC_UPDATE_FIXTURES=1 accepts the current text");
    } else {
        // The lines after a pair of releases are indented.
        let expected = fs::read_to_string(fixture).expect("a fixture");
        let rest = expected.split_once(&text).map(|(_, rest)| rest);
        assert!(rest.is_some_and(|rest| !rest.starts_with(' ')), "found\n{text}expected\n{expected}");
    }
}

/// Tests the hand-written translations whose two message versions are both in the corpus.
#[test]
fn decides_the_hand_written_steps_between_real_releases() {
    let Some(Corpus { schema, neighbours, .. }) = &*CORPUS else { return };
    let steps = [
        ("1.17", "1.18", "ActuatorServos"),
        ("1.16", "1.17", "AirspeedValidated"),
        ("1.16", "1.17", "ArmingCheckReply"),
        ("1.16", "1.17", "ArmingCheckRequest"),
        ("1.17", "1.18", "AuxGlobalPosition"),
        ("1.16", "1.17", "BatteryStatus"),
        ("1.17", "1.18", "ConfigOverrides"),
        ("1.16", "1.17", "HomePosition"),
        ("1.17", "1.18", "RegisterExtComponentReply"),
        ("1.17", "1.18", "RegisterExtComponentRequest"),
        ("1.16", "1.17", "VehicleAttitudeSetpoint"),
        ("1.15", "1.16", "VehicleLocalPosition"),
    ];
    let is_read = |release: &&str| releases().contains(release);
    for (old, new, name) in steps.into_iter().filter(|(old, new, _)| is_read(old) && is_read(new)) {
        let found = &neighbours[&[old, new]];
        for (all, is_forward) in [(&found.forward, true), (&found.backward, false)] {
            let is_named = |id| schema.message(id).name == name;
            let conversion =
                all.iter().find(|found| is_named(if is_forward { found.to } else { found.from }));
            let conversion = conversion.unwrap_or_else(|| panic!("{name}: no conversion"));
            let hashes = [conversion.from, conversion.to].map(|id| schema.message(id).hash);
            assert_ne!(hashes[0], hashes[1], "{name} didn't change");
            assert_eq!(conversion.undecided, [], "{name}");
            assert!(conversion.is_decided(), "{name}");
        }
    }
}

/// Checks that a converted message satisfies its definition if the initial source message does. The listed fields are
/// exceptions.
#[test]
fn converted_messages_of_real_releases_validate() {
    let Some(Corpus { schema, neighbours, .. }) = &*CORPUS else { return };
    let types = Types::new(schema);
    let mut count = 0;
    for (pair, found) in neighbours {
        let decided = found.forward.iter().chain(&found.backward).filter(|found| found.is_decided());
        for conversion in decided {
            let source = types.get(conversion.from).default();
            let initial = types.get(conversion.to).default().to_json().expect("JSON");
            let message = source.to_json().expect("JSON");
            let converted = convert_json(schema, conversion, &message, &initial);
            let read = types.get(conversion.to).from_json(&converted);
            let name = &schema.message(conversion.to).name;
            let read = read.unwrap_or_else(|error| panic!("{} {name}: {error}", pair[1]));
            if source.validate().is_empty() {
                for violation in read.validate() {
                    let path = violation.to_string();
                    let field = path.split(['.', '[', ':']).next().unwrap_or_default();
                    let fields = &schema.message(conversion.to).fields;
                    let is_listed = conversion.unchecked.iter().any(|at| fields[*at].name == field);
                    assert!(is_listed, "{pair:?} {name}: {path}");
                }
                count += 1;
            }
        }
    }
    assert!(count > extent(2000, 200), "{count}");
}
