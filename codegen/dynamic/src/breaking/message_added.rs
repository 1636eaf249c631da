//! `message-added`: a message, service or action was added.

use super::comparison::MessageChange;
use super::message_removed::what;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "message-added",
    statement: "A message, service or action was added.",
    why: "No existing program is affected. The report lists the change for completeness.",
    fix: "No change is necessary.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[glider![]],
    new: &[Example {
        path: "Winch.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n\
               float32 sink      # [m/s] Sink rate\n",
    }],
    check: Check::Interface(check),
};

fn check(change: &MessageChange<'_>, sink: &mut Sink<'_>) {
    let MessageChange::Added(new) = change else { return };
    let place = new.span.part(0..0);
    let message = format!("the {} `{}` was added", what(new.kind), new.name);
    sink.change(place, Sides { old: None, new: Some(place) }, message)
        .breaks(Category::Source, "no existing program is affected");
}
