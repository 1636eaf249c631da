//! `FW-ENV-05`.

use super::fw::{self, Exchange, Session, Shape};
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
            let session = Session::new();
            let id = || "x".repeat(37);
            let session = session.request("SYS-VER", |message| message["id"] = id().into())?;
            Some(session.reply_message("SYS-VER", |message| message["refs"] = id().into())?.to_bytes())
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message() else { return };
    fw::member(exchange, context, Some(message), &[], ("refs", false), &Shape::Length(1, 36));
}
