//! `PX-STR-01`.

use super::{Change, Check, Level, Mutant, Px4Rule, Rule, Status};
use uavspec_codegen::dynamic::{Placed, PlacedElement};

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-STR-01",
        level: Level::Should,
        status: Status::Normative,
        statement: "Text in a `char` array is UTF-8 up to its first NUL.",
        source: "`char[N]` of the definition",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::Value,
    mutants: &[
        Mutant {
            name: "text that is no UTF-8",
            change: Change::Ulog(|flight, log| {
                let (topic, at) = flight.find_field(is_text)?;
                log.with_payload(topic, |payload| payload[at] = 0xff)
            }),
            also: &[],
        },
        Mutant {
            name: "text with a NUL",
            change: Change::Flight(|flight| {
                let (topic, _) = flight.find_field(is_text)?;
                let name = flight.type_of(topic).layout().find(is_text)?.name;
                flight.with_last(topic, |message| message[name] = "D\0".into())
            }),
            also: &[],
        },
    ],
};

fn is_text(field: &Placed<'_>) -> bool {
    matches!(field.element, PlacedElement::Text(_))
}
