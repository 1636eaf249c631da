//! `FW-SYS-CLOSE-02`.

use serde_json::json;

use super::fw::{self, Conversation, Turn};
use super::{Check, Checker, Detail, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};
use crate::flockwave::session::remembered::Remembered;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-CLOSE-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "After SYS-CLOSE the server closes the connection.",
        source: fw::DERIVED,
        applies_to: "SYS-CLOSE over time",
    },
    check: Check::State(|| Box::new(Closing::default())),
    mutants: &[Mutant {
        name: "the server speaks on",
        make: || {
            let mut talk = Conversation::new();
            let closed = talk.lines.pop()?;
            talk.tells(json!({ "type": "SYS-MSG", "items": [{ "message": "One more thing" }] }));
            talk.lines.push(closed);
            Some(talk.to_bytes())
        },
        also: &[],
    }],
};

/// How much is kept, in bytes.
const LIMIT: usize = 1 << 20;

/// The connections that are to be closed.
struct Closing(Remembered<u64, ()>);

impl Default for Closing {
    fn default() -> Self {
        Self(Remembered::new(LIMIT))
    }
}

impl Checker for Closing {
    fn exchanged(&mut self, turn: &Turn<'_>, context: &mut RuleContext<'_>) {
        if !turn.is_of_server() || !turn.exchange.connection.is_told {
            return;
        }
        if self.0.remove(&turn.serial).is_some() {
            turn.breaks(context, || Detail::new("the server speaks on after SYS-CLOSE"));
        }
        if turn.body_of("SYS-CLOSE").is_some() {
            context.covered();
            self.0.insert(turn.serial, (), 0);
        }
    }
}
