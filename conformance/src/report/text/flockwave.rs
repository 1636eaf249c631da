//! What a recording of Flockwave says of itself.

use std::fmt::{Result, Write as _};

use uavspec_codegen::emit::docs::markdown::plural;

use super::{MAX_SHOWN, duration};
use crate::report::{Flockwave, FlockwaveType, Subject};
use crate::text::{Grouped, shown};

/// Writes what the recording is, and which messages aren't judged.
pub(super) fn write(subject: &Subject, found: &Flockwave, text: &mut String) -> Result {
    writeln!(
        text,
        "{}  Flockwave, {}, {}, {}, {}, {} ({} ms)\n",
        shown(&subject.path),
        plural(found.connections, "connection"),
        duration(subject),
        plural(found.requests, "request"),
        plural(found.responses, "response"),
        plural(found.notifications, "notification"),
        subject.elapsed,
    )?;
    writeln!(text, "types        {}, the most frequent: {}", found.types.len(), frequent(&found.types))?;
    if !found.unsupported.is_empty() || found.uncounted > 0 {
        let messages: u64 = found.unsupported.iter().map(total).sum::<u64>() + found.uncounted;
        let messages = plural(messages, "message");
        writeln!(
            text,
            "unsupported  {messages} of types that the definitions don't have: {}",
            names(&found.unsupported)
        )?;
    }
    writeln!(text)
}

fn total(of: &FlockwaveType) -> u64 {
    of.from_client + of.from_server
}

/// The types of which there are most messages.
fn frequent(types: &[FlockwaveType]) -> String {
    let mut sorted: Vec<&FlockwaveType> = types.iter().collect();
    sorted.sort_by_key(|one| std::cmp::Reverse(total(one)));
    let told =
        sorted.iter().take(MAX_SHOWN).map(|one| format!("{} {}", shown(&one.name), Grouped(total(one))));
    if sorted.is_empty() { "none".to_owned() } else { told.collect::<Vec<_>>().join(", ") }
}

fn names(types: &[FlockwaveType]) -> String {
    let told: Vec<String> = types.iter().take(MAX_SHOWN).map(|one| shown(&one.name)).collect();
    let more = types.len() - told.len();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", told.join(", "))
}
