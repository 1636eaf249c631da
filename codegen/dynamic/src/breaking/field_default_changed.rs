//! `field-default-changed`: the default of a field changed.

use uavspec_schema::value::Value;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "field-default-changed",
    statement: "The default value of a ROS 2 field changed.",
    why: "Programs that don't set the field now send a different value.",
    fix: "Keep the default, or check all programs that don't set the field.",
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
    let message = format!("the default of `{}.{}` is {now} instead of {before}", pair.name(), new.name);
    sink.change(new.span, both(old.span, new.span), message)
        .breaks(Category::Semantic, "programs that don't set the field send a different value");
}
