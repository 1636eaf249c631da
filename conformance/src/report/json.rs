//! For programs: one object for each source.

use serde_json::{Value, json};

use super::Judged;
use crate::comparison::Comparison;
use crate::definitions::Definitions;
use crate::finding::{Group, Verdict};
use crate::judge::{Basis, McapChannel, Source, Standing};
use crate::known::Excuse;
use crate::record::Place;
use crate::rule::RULES;

/// The version of the form; it rises when a member changes its meaning or goes.
const VERSION: u32 = 1;

/// All judgements as JSON.
pub fn write(judged: &[Judged], definitions: &Definitions) -> String {
    let sources: Vec<Value> = judged.iter().map(|judged| source(judged, definitions)).collect();
    let report = json!({ "version": VERSION, "sources": sources });
    // Values of this kind can always be written.
    serde_json::to_string_pretty(&report).map_or_else(|_| String::new(), |text| text + "\n")
}

fn source(judged: &Judged, definitions: &Definitions) -> Value {
    let judgement = &judged.judgement;
    let rules: Vec<Value> = RULES
        .iter()
        .map(|rule| {
            json!({
                "id": rule.id,
                "level": rule.level.to_string(),
                "verdict": verdict(judgement.findings.verdict(rule)),
                "exercised": judgement.findings.exercised(rule),
            })
        })
        .collect();
    let damage: Vec<Value> = judgement.damage.iter().map(|(place, what)| located(*place, what)).collect();
    let findings: Vec<Value> = judgement.findings.groups().map(|group| finding(group, definitions)).collect();
    let mut members = json!({
        "path": judged.path,
        "records": judgement.records,
        "judged": judgement.judged,
        "duration_us": judgement.duration,
        "damage": damage,
        "more_damage": judgement.more_damage,
        "rules": rules,
        "findings": findings,
    });
    match &judgement.source {
        Source::Log(log) => {
            let formats: Vec<Value> = log.formats.iter().map(|(name, found)| format(name, found)).collect();
            members["kind"] = "ulog".into();
            members["firmware"] = json!(log.firmware);
            members["dropouts"] = log.dropouts.into();
            members["formats"] = formats.into();
        }
        Source::Json(found) => {
            let dialects: Vec<String> = found.dialects.iter().map(|dialect| dialect.to_string()).collect();
            members["kind"] = "json".into();
            members["lines"] = found.lines.into();
            members["types"] = found.types.into();
            members["skipped"] = found.skipped.into();
            members["undefined"] = json!(found.undefined);
            members["dialects"] = dialects.into();
        }
        Source::Mcap(found) => {
            let dialects: Vec<String> = found.dialects.iter().map(|dialect| dialect.to_string()).collect();
            let channels: Vec<Value> = found.channels.iter().map(channel).collect();
            members["kind"] = "mcap".into();
            members["profile"] = json!(found.profile);
            members["library"] = json!(found.library);
            members["channels"] = channels.into();
            members["dialects"] = dialects.into();
        }
    }
    members
}

/// A channel of MCAP, with what it was judged by.
fn channel(channel: &McapChannel) -> Value {
    let mut members = match &channel.standing {
        Standing::Judged(Basis::Compared(comparison)) => format(&channel.topic, comparison),
        Standing::Judged(basis) => {
            json!({ "topic": channel.topic, "result": "by name", "message": basis.problem() })
        }
        Standing::Undefined => format(&channel.topic, &Comparison::Undefined),
        Standing::Unsupported => json!({ "topic": channel.topic, "result": "unsupported" }),
    };
    members["encoding"] = json!(channel.encoding);
    members["schema"] = json!(channel.schema.as_ref().map(|(name, _)| name));
    members["schema_encoding"] = json!(channel.schema.as_ref().map(|(_, encoding)| encoding));
    members["has_other_hash"] = channel.has_other_hash.into();
    members["messages"] = channel.messages.into();
    members["unsupported_cdr"] = channel.other_cdr.into();
    members
}

fn located(place: Place, message: &str) -> Value {
    match place {
        Place::Byte(offset) => json!({ "byte": offset, "message": message }),
        Place::Line(line) => json!({ "line": line, "message": message }),
    }
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "pass",
        Verdict::Warn => "warn",
        Verdict::Fail => "fail",
        Verdict::Known => "known",
        Verdict::Shown => "shown",
        Verdict::NotExercised => "not exercised",
    }
}

fn format(name: &str, comparison: &Comparison) -> Value {
    match comparison {
        Comparison::Equal => json!({ "topic": name, "result": "equal" }),
        Comparison::Undefined => json!({ "topic": name, "result": "undefined" }),
        Comparison::Differs(differences) => {
            json!({ "topic": name, "result": "differs", "message": differences.to_string() })
        }
    }
}

fn finding(group: &Group, definitions: &Definitions) -> Value {
    let examples: Vec<Value> =
        group.examples.iter().map(|(place, detail)| located(*place, &detail.to_string())).collect();
    json!({
        "rule": group.rule.id,
        "level": group.rule.level.to_string(),
        "statement": group.rule.statement,
        "subject": group.subject,
        "count": group.count,
        "examples": examples,
        "definition": group.definition.map(|span| definitions.place(span)),
        "known": group.known.as_ref().map(excuse),
    })
}

/// Why something is let stand.
pub(crate) fn excuse(excuse: &Excuse) -> Value {
    json!({
        "kind": excuse.kind.name(),
        "reason": excuse.reason,
        "link": excuse.link,
        "expires": excuse.expires.map(|date| date.to_string()),
    })
}
