//! `unit-missing-integer`: an integer field without a unit.

use std::collections::HashSet;
use std::sync::LazyLock;

use uavspec_schema::{Element, Field};

use super::prelude::*;
use super::quantity::{self, Groups};
use super::unit_missing;

pub(super) const RULE: Rule = Rule {
    id: "unit-missing-integer",
    statement: "An integer field without a unit.",
    why: "PX4's documentation standard requires a unit for all fields except flags and enums. Fields \
        whose names don't describe a quantity are not reported, nor are fields that `unit-missing` excludes.",
    fix: "Write the unit at the start of the comment, or `[-]` for a plain number.",
    levels: Levels::strict(Level::Note),
    bad: glider!["uint16 altitude  # Above mean sea level"],
    good: glider!["uint16 altitude  # [m] Above mean sea level"],
    measured: Some(Measured { findings: 89, sample: 30, right: 27 }),
    check: Check::Message(Scope::Px4, check),
};

/// Words in the names of fields without a unit: identifiers, counters, counts, flags and modes.
const NO_QUANTITIES: [&str; 6] = [
    // Identifiers
    "id ids uid uuid identifier address addr index idx instance instances channel channels port slot \
     number serial vendor product version ver revision major minor hash crc checksum signature key \
     token pid ssrc mnc mcc lac mac prn squawk interface letter label session sessions date",
    // Sequence numbers
    "seq sequence counter counters generation iteration order priority",
    // Counts
    "count counts num n nr total len length strlen size samples errors rxerrors dropouts drops dropped \
     lost gaps overruns retries changes satellites cells points frames streams clipping clip noutputs",
    // Flags and modes
    "mask bitmask bitfield bits flags flag type types mode modes state states status reason source src \
     sources action command cmd result code level levels class kind category severity health format \
     protocol function role group events event fault faults failure failures warning warnings quality \
     component system target origin destination node device backend executor selected request phase \
     frame orientation pattern band color behaviour behavior fix gear saturation config configuration \
     confirmation item custom default",
    // Booleans
    "active valid enabled connected present available healthy armed changed used switch button buttons \
     oc silence",
    // Raw data
    "data raw buffer payload bytes arguments text name val value values reserved rsv padding junk fom",
];

/// Suffixes of compound words for values without a unit: `sysid`, `cmdcount`.
const ENDS: [&str; 5] = ["sysid", "compid", "svid", "sessionid", "count"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let groups = Groups::new(subject.message);
    for (field, _) in subject.fields() {
        let is_integer =
            matches!(field.ty.element, Element::Scalar(scalar) if scalar.integer_bounds().is_some());
        if is_integer && is_quantity(field) && unit_missing::lacks_unit(field, &groups) {
            let help = quantity::advice(field, "mV");
            sink.report(field.span, format!("`{}` has no unit", field.name), help);
        }
    }
}

/// The words of [`NO_QUANTITIES`] as a set.
fn no_quantities() -> &'static HashSet<&'static str> {
    static WORDS: LazyLock<HashSet<&str>> =
        LazyLock::new(|| NO_QUANTITIES.iter().flat_map(|words| words.split(' ')).collect());
    &WORDS
}

fn is_quantity(field: &Field) -> bool {
    // Timestamps are microseconds in all messages.
    let is_timestamp = field.name.starts_with("timestamp");
    let mut words = quantity::name_words(field);
    !is_timestamp
        && field.enum_prefixes.is_empty()
        && field.counts.is_none()
        && !field.is_text()
        && !words.any(|word| no_quantities().contains(word) || ENDS.iter().any(|end| word.ends_with(end)))
}
