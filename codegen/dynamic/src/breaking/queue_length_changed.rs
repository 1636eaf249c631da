//! `queue-length-changed`: the length of a queue changed.

use uavspec_schema::Message;

use super::message::QUEUE_LENGTH;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "queue-length-changed",
    statement: "ORB_QUEUE_LENGTH changed.",
    why: "With a shorter queue, subscribers may miss messages. A longer queue uses more memory.",
    fix: "Check that all subscribers read the topic often enough.",
    breaks: &[(Category::Semantic, Level::Warning)],
    old: &[glider!["uint8 ORB_QUEUE_LENGTH = 8"]],
    new: &[glider!["uint8 ORB_QUEUE_LENGTH = 4"]],
    check: Check::Message(check),
};

/// PX4's default queue length.
const DEFAULT: u32 = 1;

fn check(pair: &Pair<'_>, sink: &mut Sink<'_>) {
    let length = |message: &Message| message.queue_length.unwrap_or(DEFAULT);
    let (before, now) = (length(pair.old), length(pair.new));
    if before == now || !pair.is_uorb() {
        return;
    }
    let place = |message: &Message| {
        message.constants.iter().find(|constant| constant.name == QUEUE_LENGTH).map(|found| found.span)
    };
    let sides = Sides { old: place(pair.old), new: place(pair.new) };
    let message = format!("`{}.{QUEUE_LENGTH}` is {now} instead of {before}", pair.name());
    let help = if now < before {
        "subscribers may lose messages in bursts that fit into the old queue"
    } else {
        "the queue uses more memory, and subscribers may receive more messages in a row"
    };
    sink.change(sides.new.unwrap_or(pair.head()), sides, message).breaks(Category::Semantic, help);
}
