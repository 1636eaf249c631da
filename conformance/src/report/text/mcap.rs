//! What a file of MCAP says of itself.

use std::fmt::{Result, Write as _};

use super::{Grouped, Judged, MAX_SHOWN};
use crate::judge::{Basis, McapChannel, McapSource, Standing};

/// Writes what the file is, and what its channels were judged by.
pub(super) fn write(judged: &Judged, found: &McapSource, text: &mut String) -> Result {
    head(judged, found, text)?;
    let channels = &found.channels;
    let count = |wanted: fn(&McapChannel) -> bool| channels.iter().filter(|channel| wanted(channel)).count();
    writeln!(
        text,
        "definitions  {} of {} channels equal, {} differ, {} without a schema that can be compared, {} not defined",
        count(|channel| is_compared(channel) && channel.standing.differences().is_none()),
        channels.len(),
        count(|channel| channel.standing.differences().is_some()),
        count(|channel| by_name(channel).is_some()),
        count(|channel| channel.standing == Standing::Undefined),
    )?;
    list("differs", channels, text, |channel| {
        let hash = if channel.has_other_hash { "; its hash is another, too" } else { "" };
        channel.standing.differences().map(|differences| format!("{differences}{hash}"))
    })?;
    list("by name", channels, text, by_name)?;
    list("not read", channels, text, |channel| match channel.standing {
        Standing::Unsupported => Some(format!("messages as `{}`", channel.encoding)),
        _ if channel.other_cdr > 0 => {
            Some(format!("{} messages in CDR that isn't plain version 1", Grouped(channel.other_cdr)))
        }
        _ => None,
    })?;
    list("undefined", channels, text, |channel| {
        let schema = || channel.schema.as_ref().map_or("no schema", |(name, _)| name).to_owned();
        (channel.standing == Standing::Undefined).then(schema)
    })?;
    for dialect in found.dialects.iter() {
        writeln!(text, "  {:<10} {dialect}", "dialect")?;
    }
    writeln!(text)
}

fn head(judged: &Judged, found: &McapSource, text: &mut String) -> Result {
    let judgement = &judged.judgement;
    let profile = if found.profile.is_empty() { "no profile" } else { &found.profile };
    let library = if found.library.is_empty() { "unknown library" } else { &found.library };
    let seconds = judgement.duration / 1_000_000;
    writeln!(
        text,
        "{}  {profile} ({library}), {} min {} s, {} {}, {} {} ({} ms)\n",
        judged.path,
        seconds / 60,
        seconds % 60,
        found.channels.len(),
        if found.channels.len() == 1 { "channel" } else { "channels" },
        Grouped(judgement.records),
        if judgement.records == 1 { "message" } else { "messages" },
        judged.elapsed,
    )
}

fn is_compared(channel: &McapChannel) -> bool {
    matches!(channel.standing, Standing::Judged(Basis::Compared(_)))
}

/// Why nothing but its name says what a channel is, where that is so.
fn by_name(channel: &McapChannel) -> Option<String> {
    let Standing::Judged(basis) = &channel.standing else { return None };
    basis.problem()
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
        writeln!(text, "  {what:<10} {}: {said}", channel.topic)?;
    }
    let more = found.count();
    if more > 0 { writeln!(text, "             … and {more} more") } else { Ok(()) }
}
