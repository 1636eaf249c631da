//! Tests that each rule finds its mutants, and that conforming captures have no findings.

use std::collections::BTreeSet;
use std::fs;
use std::sync::LazyLock;

use tempfile::TempDir;
use uavspec_check::check_capture;
use uavspec_probe::self_test::{Row, conforming, matrix, rows};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::{Encoding, Flight};
use uavspec_rules::{Mutant, RULES, mutants, rule};
use uavspec_test_support::{extent, shared};

/// The rows of all mutants for the built-in definitions. In quick mode, only the tested mutants.
pub(crate) static ROWS: LazyLock<Vec<Row>> =
    LazyLock::new(|| rows(&Definitions::built_in(), tested_mutants(&[])));

/// In quick mode, the mutants of one out of this many rules are tested.
const STEP: usize = 37;

/// All mutants. In quick mode, only the mutants of a few rules of both families, and of the rules in `also`.
pub(crate) fn tested_mutants(also: &[&'static str]) -> impl Iterator<Item = Mutant> {
    let some = RULES.iter().step_by(extent(1, STEP)).map(|rule| rule.id);
    let ids: BTreeSet<&str> = some.chain(also.iter().copied()).collect();
    mutants().filter(move |mutant| ids.contains(mutant.rule.id))
}

/// Asserts that conforming captures of these definitions have no findings. Returns the covered rules.
fn check_conforming(definitions: &Definitions) -> BTreeSet<&'static str> {
    let mut covered = BTreeSet::new();
    for (name, result) in conforming(definitions) {
        let found: Vec<String> = result
            .findings
            .groups()
            .map(|group| format!("{} {}: {}", group.rule.id, group.subject, group.examples[0].1))
            .collect();
        assert_eq!((found, result.corruption), (vec![], vec![]), "{name}");
        assert!(result.checked > 0 && result.checked == result.records, "{name}");
        covered.extend(RULES.iter().filter(|rule| result.findings.covered(rule) > 0).map(|rule| rule.id));
    }
    covered
}

/// Asserts that all mutants violate their rules. Returns the rules with mutants.
fn check_rows(rows: &[Row]) -> BTreeSet<&'static str> {
    let wrong: Vec<String> = rows
        .iter()
        .filter(|row| !row.is_right())
        .map(|row| format!("{}, {}: {:?}", row.rule.id, row.title, row.violated))
        .collect();
    assert_eq!(wrong, Vec::<String>::new());
    rows.iter().filter(|row| row.violated.is_some()).map(|row| row.rule.id).collect()
}

#[test]
fn built_in_definitions_have_mutants_of_every_rule() {
    let definitions = Definitions::built_in();
    let all: BTreeSet<&str> = RULES.iter().map(|rule| rule.id).collect();
    let mut covered = check_conforming(&definitions);
    // The version can be wrong only for a topic that has a version suffix.
    covered.insert("PX-VER-01");
    // The definitions have no VehicleStatus.
    covered.insert("PX-EVT-08");
    assert_eq!(covered, all);
    let tested: BTreeSet<&str> = tested_mutants(&[]).map(|mutant| mutant.rule.id).collect();
    assert_eq!(tested.len(), all.len().div_ceil(extent(1, STEP)));
    assert_eq!(check_rows(&ROWS), tested);
    assert!(ROWS.iter().all(|row| row.violated.is_some()));
}

/// Also checks findings in sessions.
#[test]
fn findings_have_a_definition_and_the_expected_value() {
    let definitions = Definitions::built_in();
    let flight = Flight::new(&definitions);
    let fields = [
        ("PX-EXT-01", "ArmingCheckReply", "uint8 request_id"),
        ("PX-EXT-02", "ArmingCheckReply", "uint8 registration_id"),
        ("PX-EXT-03", "ArmingCheckRequest", "#"),
        ("PX-EXT-04", "ArmingCheckReply", "Event[5] events"),
        ("PX-EXT-05", "ArmingCheckReply", "uint8 num_events"),
        ("PX-EXT-06", "ArmingCheckReply", "uint8 request_id"),
        ("PX-EXT-07", "RegisterExtComponentReply", "char[25] name"),
        ("PX-FSF-03", "FailsafeFlags", "bool attitude_invalid"),
    ];
    for (id, message, expected) in fields.into_iter().step_by(extent(1, 3)) {
        let rule = rule(id).expect("a rule");
        for mutant in mutants().filter(|mutant| mutant.rule.id == id) {
            let captures = mutant.captures(&flight);
            assert_eq!(captures.len(), Encoding::ALL.len(), "{id}: {}", mutant.name);
            for (title, bytes) in captures {
                let result = check_capture(&bytes[..], None, &definitions).expect("bytes");
                let group = result.findings.groups_of(rule).next().expect("a finding");
                let detail = &group.examples[0].1;
                assert!(
                    !detail.expected.is_empty() && !detail.actual.is_empty(),
                    "{id}, {title}: {detail:?}"
                );
                let line = definitions.line(group.definition.expect("a definition"));
                assert!(line.file.contains(message), "{id}, {title}: {}", line.file);
                assert!(line.text.trim().starts_with(expected), "{id}, {title}: {}", line.text);
            }
        }
    }
}

/// Rules don't depend on the built-in definitions.
#[test]
fn unrelated_definitions_have_mutants() {
    let folder = TempDir::new().expect("a folder");
    let glider = "\
uint64 timestamp          # [us] Time since system start
float32 speed             # [m/s] [@range 0, 60] [@invalid -1] Speed
float64 distance          # [m] Distance flown
float32[2] flaps          # [rad] [@range -1, 1] [@invalid NaN] Left and right
uint8 MODE_CRUISE = 0     # Straight on
uint8 MODE_THERMAL = 7    # Circling in lift
uint8 mode                # [@enum MODE] What it does
uint8 num_marks           # [-] [@count marks] Entries of marks in use
Mark[3] marks             # Places to fly to
char[4] name              # Call sign
bool is_landed            # Whether it stands on the ground
";
    fs::write(folder.path().join("Glider.msg"), glider).expect("a file");
    let mark = "uint64 timestamp  # [us] Time of entry\nint16 height  # [m] Height\n";
    fs::write(folder.path().join("Mark.msg"), mark).expect("a file");
    let definitions = Definitions::load(folder.path()).expect("definitions");
    check_conforming(&definitions);
    let found = check_rows(&rows(&definitions, tested_mutants(&["PX-LEN-01", "PX-RANGE-01"])));
    assert!(found.contains("PX-RANGE-01") && found.contains("PX-LEN-01"), "{found:?}");
    assert!(!found.contains("PX-VER-01"), "no message has a version");
}

#[test]
#[ignore = "slow"]
fn px4_definitions_have_mutants() {
    let Some(corpus) = shared("corpus/px4") else { return };
    let definitions = Definitions::load(&corpus.join("main")).expect("definitions");
    check_conforming(&definitions);
    check_rows(&matrix(&definitions));
}
