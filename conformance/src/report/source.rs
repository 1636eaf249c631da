//! What came of judging a source, as a report tells it.

use std::collections::BTreeMap;

use crate::check::{
    self, Basis, FlockwaveSource, JsonSource, Judgement, LogSource, McapSource, Source, Standing, TypeCount,
};
use crate::definitions::Definitions;
use crate::model::{self, Findings, Group, Rule};
use crate::px4::comparison::Comparison;
use crate::rules::RULES;

use super::{
    About, ChannelResult, Conclusion, Damage, Definition, Example, Finding, Flockwave, FlockwaveType, Format,
    FormatResult, Json, Known, Mcap, McapChannel, RuleVerdict, Subject, Ulog, Verdict,
};

/// The rule that only counts where that is asked for.
const FORMATS: &str = "PX-FMT-01";

/// A source that was judged.
#[derive(Debug)]
pub struct Judged {
    /// Its path, as it was given.
    pub path: String,
    /// What came of it.
    pub judgement: Judgement,
    /// What happened on the way, where it is a server that was probed.
    pub notes: Vec<String>,
    /// How long that took, in milliseconds.
    pub elapsed: u128,
}

/// How a source was to be judged.
#[derive(Clone, Debug, Default)]
pub struct Settings {
    /// Whether formats that differ from the definitions count as breaches.
    pub are_formats_strict: bool,
    /// The arguments of the command but the files, so that one finds the same again.
    pub arguments: Vec<String>,
    /// The command that finds the same again, where it isn't `check`.
    pub command: Option<String>,
}

impl Settings {
    /// The command that judges a source again.
    fn command(&self, path: &str) -> String {
        if let Some(command) = &self.command {
            return command.clone();
        }
        let words = ["uavspec", "check"].into_iter().chain(self.arguments.iter().map(String::as_str));
        // What begins with a dash would be taken for an option; the dash alone is standard input.
        let is_like_option = path.starts_with('-') && path != "-";
        let path = if is_like_option { format!("./{path}") } else { path.to_owned() };
        crate::text::command_line(words.chain([path.as_str()]))
    }

    /// What came of a rule.
    fn verdict(&self, findings: &Findings, rule: &'static Rule) -> Verdict {
        match findings.verdict(rule) {
            model::Verdict::Shown if self.are_formats_strict && rule.id == FORMATS => Verdict::Fail,
            other => other.into(),
        }
    }
}

impl From<model::Verdict> for Verdict {
    fn from(verdict: model::Verdict) -> Self {
        match verdict {
            model::Verdict::Pass => Self::Pass,
            model::Verdict::Warn => Self::Warn,
            model::Verdict::Fail => Self::Fail,
            model::Verdict::Shown => Self::Shown,
            model::Verdict::Known => Self::Known,
            model::Verdict::NotExercised => Self::NotExercised,
        }
    }
}

impl Subject {
    /// Of a source that was judged.
    pub fn of_source(judged: Judged, definitions: &Definitions, settings: &Settings) -> Self {
        let Judged { path, judgement, notes, elapsed } = judged;
        let findings = &judgement.findings;
        // What the rules on other kinds of sources find in it isn't worth telling.
        let is_flockwave = matches!(judgement.source, Source::Flockwave(_));
        let rules: Vec<RuleVerdict> = RULES
            .iter()
            .filter(|rule| rule.is_on_flockwave() == is_flockwave)
            .map(|rule| of_rule(rule, findings, settings.verdict(findings, rule)))
            .collect();
        let command = settings.command(&path);
        let finding =
            |group: &Group| finding(group, settings.verdict(findings, group.rule), &command, definitions);
        let damage = judgement.damage.iter();
        let mut subject = Self {
            path,
            about: about(&judgement.source),
            records: judgement.records,
            judged: judgement.judged,
            duration_us: judgement.duration,
            conclusion: Conclusion::of_source(0, 0, 0, Vec::new()),
            findings: findings.groups().map(finding).collect(),
            more_findings: RULES.iter().map(|rule| findings.dropped(rule)).sum(),
            rules,
            damage: damage.map(|(place, text)| Damage { place: *place, message: text.clone() }).collect(),
            more_damage: judgement.more_damage,
            extent: judgement.extent,
            notes,
            elapsed,
        };
        subject.conclude();
        subject
    }

    /// Says of a source what its verdicts come to.
    pub fn conclude(&mut self) {
        let remarks = match self.damages() {
            0 => Vec::new(),
            1 => vec!["One place of the file can't be read".to_owned()],
            count => vec![format!("{count} places of the file can't be read")],
        };
        let (failed, warned) = (self.count(Verdict::Fail), self.count(Verdict::Warn));
        let conclusion = Conclusion::of_source(self.judged, failed, warned, remarks);
        self.conclusion = conclusion.read_so_far(self.extent);
    }
}

fn of_rule(rule: &'static Rule, findings: &Findings, verdict: Verdict) -> RuleVerdict {
    let kept: u64 = findings.of(rule).map(|group| group.count).sum();
    RuleVerdict {
        id: rule.id,
        level: rule.level,
        verdict,
        exercised: findings.exercised(rule),
        findings: kept + findings.dropped(rule),
    }
}

fn about(source: &Source) -> About {
    match source {
        Source::Log(LogSource { firmware, dropouts, formats }) => About::Ulog(Ulog {
            firmware: firmware.clone(),
            dropouts: *dropouts,
            formats: formats.iter().map(|(topic, found)| format_of(topic, found)).collect(),
        }),
        Source::Json(JsonSource { lines, types, skipped, undefined, dialects }) => About::Json(Json {
            lines: *lines,
            types: *types as u64,
            skipped: *skipped,
            undefined: undefined.iter().cloned().collect(),
            dialects: dialects.iter().map(|dialect| dialect.to_string()).collect(),
        }),
        Source::Mcap(McapSource { profile, library, channels, dialects }) => About::Mcap(Mcap {
            profile: profile.clone(),
            library: library.clone(),
            channels: channels.iter().map(channel).collect(),
            dialects: dialects.iter().map(|dialect| dialect.to_string()).collect(),
        }),
        Source::Flockwave(source) => About::Flockwave(flockwave(source)),
    }
}

fn flockwave(source: &FlockwaveSource) -> Flockwave {
    let list = |types: &BTreeMap<String, TypeCount>| {
        let of = |(name, count): (&String, &TypeCount)| FlockwaveType {
            name: name.clone(),
            from_client: count.out,
            from_server: count.incoming,
        };
        types.iter().map(of).collect()
    };
    Flockwave {
        connections: source.connections as u64,
        requests: source.requests,
        responses: source.responses,
        notifications: source.notifications,
        types: list(&source.types),
        unsupported: of_server(list(&source.unknown)),
        uncounted: source.uncounted,
    }
}

/// The types that the server sent: what a client asks for, to see what comes of it, isn't judged.
fn of_server(mut types: Vec<FlockwaveType>) -> Vec<FlockwaveType> {
    types.retain(|known| known.from_server > 0);
    types
}

fn channel(channel: &check::McapChannel) -> McapChannel {
    let (result, message) = match &channel.standing {
        Standing::Judged(Basis::Compared(comparison)) => {
            let hash = if channel.has_other_hash { "; its hash is another, too" } else { "" };
            match &**comparison {
                Comparison::Differs(differences) => (ChannelResult::Differs, format!("{differences}{hash}")),
                Comparison::Equal | Comparison::Undefined => (ChannelResult::Equal, String::new()),
            }
        }
        Standing::Judged(basis) => (ChannelResult::ByName, basis.problem().unwrap_or_default()),
        Standing::Undefined => (ChannelResult::Undefined, String::new()),
        Standing::Unsupported => (ChannelResult::Unsupported, String::new()),
    };
    McapChannel {
        topic: channel.topic.clone(),
        encoding: channel.encoding.clone(),
        schema: channel.schema.as_ref().map(|(name, _)| name.clone()),
        schema_encoding: channel.schema.as_ref().map(|(_, encoding)| encoding.clone()),
        messages: channel.messages,
        other_cdr: channel.other_cdr,
        result,
        message,
    }
}

fn format_of(topic: &str, comparison: &Comparison) -> Format {
    let (result, message) = match comparison {
        Comparison::Equal => (FormatResult::Equal, String::new()),
        Comparison::Undefined => (FormatResult::Undefined, String::new()),
        Comparison::Differs(differences) => (FormatResult::Differs, differences.to_string()),
    };
    Format { topic: topic.to_owned(), result, message }
}

fn finding(group: &Group, verdict: Verdict, command: &str, definitions: &Definitions) -> Finding {
    let Group { rule, subject, count, examples, definition, known, .. } = group;
    let example = |(place, detail): &(_, crate::model::Detail)| Example {
        place: *place,
        path: detail.path.clone(),
        part: detail.part.clone(),
        message: detail.message.clone(),
        expected: detail.expected.clone(),
        actual: detail.actual.clone(),
        excerpt: detail.excerpt.clone(),
    };
    Finding {
        rule: rule.id,
        level: rule.level,
        status: rule.status.to_string(),
        statement: rule.statement,
        url: uavspec_codegen::report::rule_url(rule.id),
        verdict: if known.is_some() { Verdict::Known } else { verdict },
        subject: subject.clone(),
        count: *count,
        examples: examples.iter().map(example).collect(),
        definition: definition.map(|span| Definition::of(definitions.line(span))),
        reproduce: command.to_owned(),
        known: known.as_ref().map(Known::from),
    }
}
