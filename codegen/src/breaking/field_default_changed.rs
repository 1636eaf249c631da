//! `field-default-changed`: a field with another default.

use super::message::Pair;
use super::message::both;
use super::rule::{Category, Check, Rule, Sink};
use crate::diagnostic::Level;
use crate::example::Example;
use crate::schema::Field;
use crate::value::Value;

pub(super) const RULE: Rule = Rule {
    id: "field-default-changed",
    purpose: "The default of a field changed (ROS 2): whoever leaves the field alone sends another value \
              than before.",
    breaks: &[(Category::Semantic, Level::Warning)],
    old: &[Example { path: "glider_msgs/Glider.msg", text: "float32 sink 0.5\n" }],
    new: &[Example { path: "glider_msgs/Glider.msg", text: "float32 sink 0.7\n" }],
    check: Check::Field(check),
};

fn check(pair: &Pair<'_>, old: &Field, new: &Field, sink: &mut Sink<'_>) {
    let text = |value: &Option<Value>| value.as_ref().map_or_else(|| "none".to_owned(), Value::to_string);
    let (before, now) = (text(&old.default), text(&new.default));
    if before == now {
        return;
    }
    let message = format!("the default of `{}.{}` is {now}, and was {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Semantic, "whoever leaves the field alone sends another value than before");
}
