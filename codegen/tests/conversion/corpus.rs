//! Conversions between the releases of PX4.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use uavspec_codegen::conversion::{Conversion, Conversions, Hints, read_hints};
use uavspec_codegen::dynamic::Types;
use uavspec_codegen::msg::Dialect;
use uavspec_codegen::schema::Form;
use uavspec_codegen::{PackageInput, Schema, SourceMap, read};

use super::support::PX4_HINTS;
use crate::support::{add_folder, differs, shared};

pub(super) const RELEASES: [&str; 7] = ["1.13", "1.14", "1.15", "1.16", "1.17", "1.18", "main"];

/// Reads the definitions of all releases, each as a package.
pub(super) fn releases(sources: &mut SourceMap, folder: &Path) -> Schema {
    let packages = RELEASES.map(|release| {
        let mut package = PackageInput::new(release, Form::Msg(Dialect::Px4), Vec::new());
        add_folder(sources, &mut package, &folder.join(release));
        package
    });
    read(sources, &packages).0
}

pub(super) fn published_hints(sources: &mut SourceMap) -> Hints {
    let source = sources.add("px4.toml", PX4_HINTS.as_bytes().to_vec()).expect("a source");
    let hints = read_hints(sources, source);
    assert_eq!(hints.mistakes, []);
    hints
}

/// The fixture lists what the definitions and the published hints don't decide between neighbouring releases.
#[test]
fn lists_the_undecided_parts_between_releases() {
    let Some(folder) = shared("corpus/px4") else { return };
    let mut sources = SourceMap::default();
    let schema = releases(&mut sources, &folder);
    let hints = published_hints(&mut sources);
    let mut text = String::new();
    for pair in RELEASES.windows(2) {
        let found = Conversions::within(&schema, pair[0], pair[1], &hints).expect("both packages");
        assert_eq!(found.mistakes, []);
        let decided = |all: &[Arc<Conversion>]| all.iter().filter(|found| found.is_decided()).count();
        let [forward, backward] = [decided(&found.forward), decided(&found.backward)];
        let messages = found.forward.len();
        writeln!(text, "{} to {}: {forward} of {messages}, back {backward}", pair[0], pair[1])
            .expect("a string");
        for undecided in found.undecided() {
            writeln!(text, "    {}", undecided.message).expect("a string");
        }
    }
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/conversion/px4.txt");
    assert_eq!(differs(&fixture, &text), None, "UAVSPEC_UPDATE_FIXTURES=1 accepts the current text");
}

/// The messages of the hand-written translations whose versions are both in the corpus.
#[test]
fn decides_the_hand_written_steps_between_real_releases() {
    let Some(folder) = shared("corpus/px4") else { return };
    let mut sources = SourceMap::default();
    let schema = releases(&mut sources, &folder);
    let hints = published_hints(&mut sources);
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
    for (old, new, name) in steps {
        let found = Conversions::within(&schema, old, new, &hints).expect("both packages");
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

/// If the initial message of the source satisfies its definition, the converted message satisfies the target's, except
/// for the listed fields.
#[test]
fn converted_messages_of_real_releases_validate() {
    let Some(folder) = shared("corpus/px4") else { return };
    let mut sources = SourceMap::default();
    let schema = releases(&mut sources, &folder);
    let hints = published_hints(&mut sources);
    let types = Types::new(&schema);
    let mut count = 0;
    for pair in RELEASES.windows(2) {
        let found = Conversions::within(&schema, pair[0], pair[1], &hints).expect("both packages");
        let decided = found.forward.iter().chain(&found.backward).filter(|found| found.is_decided());
        for conversion in decided {
            let source = types.get(conversion.from).default();
            let initial = types.get(conversion.to).default().to_json().expect("JSON");
            let message = source.to_json().expect("JSON");
            let converted = conversion.convert_json((&schema, &schema), &message, &initial);
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
    assert!(count > 2000, "{count}");
}
