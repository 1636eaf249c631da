//! `PX-EVT-01`.

use super::prelude::*;
use crate::sample::Entry;

/// The rule.
pub static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-01",
    name: "Event metadata of a log",
    level: Level::Must,
    status: Status::Normative,
    statement: "The event metadata in a log is readable, and its SHA-256 hash equals the hash in the log.",
    source: "`metadata_events` and `metadata_events_sha256` of PX4's logger",
    applies_to: "logs",
    why: "The metadata explains the events of the log. If it is corrupt, nobody can find out why the \
          vehicle didn't arm.",
    example: "metadata_events:        16,241 bytes, SHA-256 834c6a91…\n\
              metadata_events_sha256: 1f00b2c4…",
    fix: "Embed the file `all_events.json.xz` of the same build without changes, split into pieces. \
          `uavspec lint` lists all mistakes in such a file.",
})
.check(Check::Source)
.mutants(&[
    Mutant::ulog("the hash of different metadata", |_, mut log| {
        let is_hash = |entry: &&mut Entry| {
            matches!(entry, Entry::Information(key, _) if key.ends_with("metadata_events_sha256"))
        };
        let Some(Entry::Information(_, digest)) = log.entries.iter_mut().find(is_hash) else { return None };
        digest.fill(b'0');
        Some(log)
    }),
    Mutant::ulog("metadata that isn't JSON", |_, mut log| {
        log.entries.retain(|entry| !matches!(entry, Entry::Information(key, _) if key.contains("metadata")));
        log.entries.insert(1, Entry::Metadata(b"[]".to_vec()));
        Some(log)
    }),
]);
