//! `FW-ENV-05`.

use super::fw::{self, Conversation, Shape, Turn};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-05",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`refs` of a message, where it is present, is a string of 1 to 36 characters.",
        source: fw::SCHEMA,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "`refs` of 37 characters",
        make: || {
            let talk = Conversation::new();
            let id = || "x".repeat(37);
            let talk = talk.request("SYS-VER", |message| message["id"] = id().into())?;
            Some(talk.reply_message("SYS-VER", |message| message["refs"] = id().into())?.to_bytes())
        },
        also: &[],
    }],
};

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = turn.message() else { return };
    fw::member(turn, context, Some(message), &[], ("refs", false), &Shape::Length(1, 36));
}
