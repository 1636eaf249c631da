//! `message-added`: a message, service or action that is new.

use super::comparison::MessageChange;
use super::message_removed::what;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::finding::Sides;

pub(super) const RULE: Rule = Rule {
    id: "message-added",
    purpose: "A message, a service or an action is new. That breaks nobody; it is said so that the report \
              tells all that changed.",
    breaks: &[(Category::Source, Level::Note)],
    old: &[Example {
        path: "Glider.msg",
        text: "# State of a glider\n\
               \n\
               uint64 timestamp  # [us] Time since system start\n",
    }],
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
    let message = format!("the {} `{}` is new", what(new.kind), new.name);
    sink.change(place, Sides { old: None, new: Some(place) }, message)
        .breaks(Category::Source, "nobody: programs may use it from now on");
}
