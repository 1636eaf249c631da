//! Decides which hints apply to a pair of messages.

use uavspec_schema::{Constant, Message, Schema};

use super::model::{Hint, HintValue, Key};
use crate::conversion::expression::{Name, Side};

/// A message and its schema.
pub(in crate::conversion) type Holder<'s> = (&'s Schema, &'s Message);

/// The first name in a hint that one of the messages lacks, with an explanation. `None` if the hint applies.
pub(in crate::conversion) fn missing<'h>(
    hint: &'h Hint,
    sides: [Holder<'_>; 2],
) -> Option<(&'h Key, String)> {
    let names = ["old", "new"];
    for (at, side) in sides.iter().enumerate() {
        let message = &hint.messages[at];
        if side.1.name != message.text {
            return Some((message, format!("no {} message `{}`", names[at], message.text)));
        }
        if let Some(topic) = hint.topic.as_ref().filter(|topic| !side.1.topics.contains(&topic.text)) {
            return Some((
                topic,
                format!("the {} message doesn't have the topic `{}`", names[at], topic.text),
            ));
        }
        let fields =
            hint.values[at].iter().map(|(key, _)| key).chain(hint.rename.iter().map(|pair| &pair[at]));
        for key in fields {
            if !has_field(side.1, &key.text) {
                let message = format!("`{}` has no {} field `{}`", side.1.name, names[at], key.text);
                return Some((key, message));
            }
        }
    }
    if let Some([old, new]) = hint.versions {
        let [before, after] = sides.map(|side| side.1.version.unwrap_or(0));
        if before > old || after < new {
            let message = format!("the versions are {before} and {after}, not {old} and {new}");
            return Some((&hint.messages[0], message));
        }
    }
    for key in hint.narrow.iter().map(|(key, _)| key).chain(&hint.same) {
        if !sides.iter().any(|side| has_field(side.1, &key.text) || constant(*side, &key.text).is_some()) {
            return Some((key, format!("neither message has a field or a constant `{}`", key.text)));
        }
    }
    (0..2).find_map(|target| missing_in_values(hint, target, sides))
}

/// The first name that the messages lack, among the values of one side's fields.
fn missing_in_values<'h>(hint: &'h Hint, target: usize, sides: [Holder<'_>; 2]) -> Option<(&'h Key, String)> {
    let source = sides[1 - target];
    for (key, value) in &hint.values[target] {
        match value {
            HintValue::Expression(node) => {
                let mut absent = None;
                node.names(&mut |name| {
                    if absent.is_none() && !exists(name, source, sides) {
                        absent = Some(format!("neither message has a field or a constant `{}`", name.text));
                    }
                });
                if let Some(message) = absent {
                    return Some((key, message));
                }
            }
            HintValue::Constants(pairs) => {
                for (name, side) in pairs.iter().flat_map(|[from, to]| [(from, source), (to, sides[target])])
                {
                    if constant(side, &name.text).is_none() {
                        return Some((name, format!("`{}` has no constant `{}`", side.1.name, name.text)));
                    }
                }
            }
        }
    }
    None
}

fn exists(name: &Name, source: Holder<'_>, sides: [Holder<'_>; 2]) -> bool {
    let has_constant = |side: Holder<'_>| constant(side, &name.text).is_some();
    match name.side {
        Some(Side::Old) => has_constant(sides[0]),
        Some(Side::New) => has_constant(sides[1]),
        None => has_field(source.1, &name.text) || sides.into_iter().any(has_constant),
    }
}

fn has_field(message: &Message, name: &str) -> bool {
    message.fields.iter().any(|field| field.name == name)
}

/// A constant of a message, or of another message whose constants a field uses.
pub(in crate::conversion) fn constant<'s>((schema, message): Holder<'s>, name: &str) -> Option<&'s Constant> {
    let enums = message.fields.iter().filter_map(|field| field.enumeration);
    let owners = enums.map(|reference| schema.message(reference.message));
    std::iter::once(message)
        .chain(owners)
        .find_map(|owner| owner.constants.iter().find(|constant| constant.name == name))
}
