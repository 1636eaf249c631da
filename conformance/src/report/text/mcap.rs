//! What a file of MCAP says of itself.

use std::fmt::{Result, Write as _};

use uavspec_codegen::emit::docs::markdown::plural;

use super::{MAX_SHOWN, duration};
use crate::report::{ChannelResult, Mcap, McapChannel, Subject};
use crate::text::{Grouped, shown};

/// Writes what the file is, and what its channels were judged by.
pub(super) fn write(subject: &Subject, found: &Mcap, text: &mut String) -> Result {
    head(subject, found, text)?;
    let channels = &found.channels;
    let count = |wanted| channels.iter().filter(|channel| channel.result == wanted).count();
    writeln!(
        text,
        "definitions  {} of {} channels equal, {} differ, {} without a schema that can be compared, {} not defined",
        count(ChannelResult::Equal),
        channels.len(),
        count(ChannelResult::Differs),
        count(ChannelResult::ByName),
        count(ChannelResult::Undefined),
    )?;
    let of =
        |wanted| move |channel: &McapChannel| (channel.result == wanted).then(|| shown(&channel.message));
    list("differs", channels, text, of(ChannelResult::Differs))?;
    list("by name", channels, text, of(ChannelResult::ByName))?;
    list("not read", channels, text, |channel| match channel.result {
        ChannelResult::Unsupported => Some(format!("messages as `{}`", shown(&channel.encoding))),
        _ if channel.other_cdr > 0 => {
            Some(format!("{} messages in CDR that isn't plain version 1", Grouped(channel.other_cdr)))
        }
        _ => None,
    })?;
    list("undefined", channels, text, |channel| {
        let schema = || channel.schema.as_deref().map_or_else(|| "no schema".to_owned(), shown);
        (channel.result == ChannelResult::Undefined).then(schema)
    })?;
    for dialect in &found.dialects {
        writeln!(text, "  {:<10} {dialect}", "dialect")?;
    }
    writeln!(text)
}

fn head(subject: &Subject, found: &Mcap, text: &mut String) -> Result {
    let or = |text: &str, none: &str| if text.is_empty() { none.to_owned() } else { shown(text) };
    writeln!(
        text,
        "{}  {} ({}), {}, {}, {} ({} ms)\n",
        shown(&subject.path),
        or(&found.profile, "no profile"),
        or(&found.library, "unknown library"),
        duration(subject),
        plural(found.channels.len() as u64, "channel"),
        plural(subject.records, "message"),
        subject.elapsed,
    )
}

/// A line for each channel of which there is something to say.
fn list(
    what: &str,
    channels: &[McapChannel],
    text: &mut String,
    of: impl Fn(&McapChannel) -> Option<String>,
) -> Result {
    let mut found = channels.iter().filter_map(|channel| Some((channel, of(channel)?)));
    for (channel, said) in found.by_ref().take(MAX_SHOWN) {
        writeln!(text, "  {what:<10} {}: {said}", shown(&channel.topic))?;
    }
    let more = found.count();
    if more > 0 { writeln!(text, "             … and {more} more") } else { Ok(()) }
}
