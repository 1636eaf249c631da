//! `PX-STR-01`.

use uavspec_dynamic::Field;
use uavspec_schema::Element;
use uavspec_types::px4::RegisterExtComponentRequest;

use super::prelude::*;

/// The position of the `name` in the payload, after the encapsulation header, `timestamp` and `request_id`.
const NAME: usize = 4 + 8 + 8;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-STR-01",
    name: "Text is valid Unicode",
    level: Level::Should,
    status: Status::Normative,
    statement: "Text in a `char` array is valid UTF-8 and ends at the first NUL. A `string` is valid \
                UTF-8, and a `wstring` is valid UTF-16.",
    source: "`char[N]`, `string` or `wstring` in the definition; ROS 2 design, Unicode Support",
    applies_to: "message values",
    why: "Readers show replacement characters in place of invalid bytes, or reject the message.",
    example: "definition: char[25] name\n\
              bytes:      4d 6f 64 65 ff 00 …    (ff is not valid in UTF-8)",
    fix: "Write valid UTF-8, or valid UTF-16 in a `wstring`. Fill the rest of a `char` array with NUL \
          bytes. If you shorten a text, do not split a character.",
})
.check(Check::Value)
.bug(Bug::message(Side::Component, "The name of the component ends with an invalid byte.", |out| {
    out.edit_payload::<RegisterExtComponentRequest>(1, |payload| {
        if let Some(end) = payload.iter_mut().skip(NAME).find(|byte| **byte == 0) {
            *end = 0xff;
        }
    });
}))
.mutants(&[
    Mutant::ulog("text that is not UTF-8", |flight, log| {
        let (topic, at) = flight.find_field(is_text)?;
        log.with_payload(topic, |payload| payload[at] = 0xff)
    }),
    Mutant::flight("text with a NUL", |flight| {
        let (topic, _) = flight.find_field(is_text)?;
        let name = &*flight.type_of(topic).fields().iter().find(|field| is_text(field))?.name;
        flight.with_last(topic, |message| message[name] = "D\0".into())
    }),
]);

fn is_text(field: &Field) -> bool {
    matches!(field.element, Element::Text(_))
}
