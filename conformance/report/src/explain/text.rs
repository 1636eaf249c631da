//! Explanations for terminals.

use std::fmt::Write as _;

use uavspec_model::text::{shown, wrapped};

use super::Explanation;
use super::annotation::STATED;
use super::answer::{
    Answer, Asked, Candidates, Code, Constant, ErrorCode, Field, Hash, Limits, Member, Message, Presence,
    Values,
};
use crate::rule_list;

/// The maximum number of candidates to list.
const MAX_CANDIDATES: usize = 30;

/// The text for the unit of dimensionless numbers.
const NO_UNIT: &str = "-";

/// Formats the answers, with an empty line between them.
pub fn to_text(explanation: &Explanation) -> String {
    explanation.answers.iter().map(answer).collect::<Vec<_>>().join("\n")
}

fn answer(answer: &Answer) -> String {
    match answer {
        Answer::Rule(entry) => uavspec_rules::rule(entry.id).map_or_else(String::new, rule_list::rule_text),
        Answer::ErrorCode(code) => error_code(code),
        Answer::Hash(found) => hash(found),
        Answer::Message(found) => message(found),
        Answer::Field(found) => field(found),
        Answer::Constant(found) => constant(found),
        Answer::Candidates(found) => candidates(found),
    }
}

/// A text that is built line by line.
#[derive(Default)]
struct Lines(String);

impl Lines {
    /// Adds a line that wraps at the width of a terminal. The continuation lines are indented by `indent` columns.
    fn line(&mut self, indent: usize, text: &str) {
        self.0.push_str(wrapped(text, 0, indent).trim_end());
        self.0.push('\n');
    }

    /// Adds a fact with a label.
    fn fact(&mut self, label: &str, text: &str) {
        if !text.contains(' ') && !text.is_empty() {
            // A long hash stays on the same line as its label.
            let _ = writeln!(self.0, "{:<13}  {}", format!("{label}:"), shown(text));
        } else if !text.is_empty() {
            self.line(15, &format!("{:<13}  {}", format!("{label}:"), shown(text)));
        }
    }

    /// Adds a paragraph.
    fn paragraph(&mut self, text: &str) {
        for line in text.lines() {
            self.line(0, &shown(line));
        }
    }

    /// Adds a description, and an empty line on each side.
    fn description(&mut self, text: &str) {
        if !text.is_empty() {
            self.0.push('\n');
            self.paragraph(text);
        }
        self.0.push('\n');
    }

    /// Adds a section, if it has items.
    fn section(&mut self, title: &str, items: impl IntoIterator<Item = String>) {
        let mut items = items.into_iter().peekable();
        if items.peek().is_some() {
            self.0.push('\n');
            self.line(2, title);
        }
        for item in items {
            self.line(6, &format!("  {}", shown(&item)));
        }
    }
}

fn error_code(code: &ErrorCode) -> String {
    let mut lines = Lines::default();
    let abbreviation = code.abbreviation.as_ref().map(|text| format!(" {text}")).unwrap_or_default();
    lines.line(0, &format!("Error code {}{abbreviation}: {}", code.code, code.class));
    let undefined = "The specification doesn't define this code.";
    lines.description(code.description.as_deref().unwrap_or(undefined));
    lines.fact("Severity", code.severity);
    lines.fact("Since", code.since.as_deref().unwrap_or_default());
    let related = |code: &Code| format!("{}  {}", code.code, code.description);
    lines.section("Alternatives", code.alternatives.iter().map(related));
    lines.section("See also", code.see_also.iter().map(related));
    lines.0
}

fn hash(hash: &Hash) -> String {
    let mut lines = Lines::default();
    let form = if hash.form == "uorb" { "uORB message hash" } else { "ROS 2 type hash" };
    lines.line(2, &format!("{}: {form}", hash.digits));
    let definitions = hash.definitions.iter().map(|found| {
        let mut releases = found.releases.join(", ");
        if found.documented {
            releases.push_str(if releases.is_empty() {
                "uavspec's definition"
            } else {
                ", uavspec's definition"
            });
        }
        format!("{}: {releases}", found.name)
    });
    lines.section("Definitions", definitions);
    lines.0
}

fn message(message: &Message) -> String {
    let mut lines = Lines::default();
    let is_service = message.name.contains("/srv/");
    lines.line(2, &format!("{}: {}", message.name, if is_service { "service" } else { "message" }));
    lines.description(&message.description);
    lines.fact("As in", &message.release);
    lines.fact("Topics", &message.topics.join(", "));
    lines.fact("Version", &message.version.map(|version| version.to_string()).unwrap_or_default());
    let size = message.uorb_size.map(|size| format!("{size} bytes")).unwrap_or_default();
    lines.fact("uORB size", &size);
    lines.fact("uORB hash", message.uorb_hash.as_deref().unwrap_or_default());
    lines.fact("Type hash", message.type_hash.as_deref().unwrap_or_default());
    for part in &message.parts {
        let of = if is_service { format!(" of {}", part.name) } else { String::new() };
        let fields = part.fields.iter().map(|field| {
            let unit = unit(field.unit.as_deref());
            with_description(format!("{} {}{unit}", field.ty, field.name), &field.description)
        });
        lines.section(&format!("Fields{of}"), fields);
        lines.section(&format!("Constants{of}"), part.constants.iter().map(member));
    }
    presence(&mut lines, &message.presence);
    lines.0
}

fn field(field: &Field) -> String {
    let mut lines = Lines::default();
    match &field.asked {
        Some(asked) => asked_value(&mut lines, field, asked),
        None => lines.line(2, &format!("{}: field of {}", field.name, field.message)),
    }
    lines.description(&field.description);
    lines.fact("As in", &field.release);
    lines.fact("Type", &field.ty);
    limits(&mut lines, &field.limits);
    lines.fact("Default", field.default.as_deref().unwrap_or_default());
    if let Some(values) = &field.values {
        lines.section(&title(values, field.asked.as_ref()), values.members.iter().map(member));
    }
    presence(&mut lines, &field.presence);
    lines.0
}

/// The title of a field's list of constants.
fn title(values: &Values, asked: Option<&Asked>) -> String {
    let word = match (values.flags, asked) {
        (true, None) => "Bits",
        (true, Some(_)) => "All bits",
        (false, None) => "Values",
        (false, Some(_)) => "All values",
    };
    let known_from = Some(&values.known_from).filter(|source| *source != STATED);
    let known_from = known_from.map(|source| format!(", known from {source}")).unwrap_or_default();
    format!("{word}: constants of {}{known_from}", values.message)
}

fn asked_value(lines: &mut Lines, field: &Field, asked: &Asked) {
    let names: Vec<&str> = asked.meaning.iter().map(|member| member.name.as_str()).collect();
    let meaning = if names.is_empty() { String::new() } else { format!(": {}", names.join(" + ")) };
    lines.line(2, &shown(&format!("{}={}{meaning}", field.name, asked.value)));
    for member in asked.meaning.iter().filter(|member| !member.description.is_empty()) {
        lines.line(4, &format!("  {}: {}", member.name, shown(&member.description)));
    }
    for note in &asked.notes {
        lines.line(4, &format!("  {}", shown(note)));
    }
    let meanings = asked.by_release.iter().filter(|_| asked.by_release.len() > 1);
    lines.section(
        "In each release",
        meanings.map(|meaning| {
            let names =
                if meaning.names.is_empty() { "no constant".to_owned() } else { meaning.names.join(", ") };
            format!("{}: {names}", meaning.releases.join(", "))
        }),
    );
}

fn constant(constant: &Constant) -> String {
    let mut lines = Lines::default();
    let word = if constant.parameters.is_empty() { "constant" } else { "command" };
    lines.line(2, &format!("{} = {}: {word} of {}", constant.name, constant.value, constant.message));
    lines.description(&constant.description);
    lines.fact("As in", &constant.release);
    lines.fact("Type", &constant.ty);
    lines.fact("Fields", &constant.fields.join(", "));
    lines.fact("Also in", &constant.also_in.join(", "));
    let parameters = constant.parameters.iter().filter_map(|parameter| {
        let values = if parameter.values.is_empty() {
            String::new()
        } else {
            format!("a value of {}", parameter.values.join(", "))
        };
        let limits = &parameter.limits;
        let range = limits.range.as_ref().map(|range| format!("range {range}"));
        let unit = limits.unit.as_ref().map(|unit| format!("[{unit}]"));
        let facts: Vec<String> = unit
            .into_iter()
            .chain(range)
            .chain(limits.facts.iter().cloned())
            .chain([values, parameter.description.clone()])
            .filter(|fact| !fact.is_empty())
            .collect();
        Some(format!("{}: {}", parameter.number, facts.join(", "))).filter(|_| !facts.is_empty())
    });
    lines.section("Parameters (the releases describe no others)", parameters);
    lines.section("Alternatives", constant.alternatives.iter().map(member));
    presence(&mut lines, &constant.presence);
    lines.0
}

fn candidates(found: &Candidates) -> String {
    let mut lines = Lines::default();
    let count = found.candidates.len();
    lines.line(2, &format!("{}: in {count} messages", found.name));
    let more = count.checked_sub(MAX_CANDIDATES).filter(|more| *more > 0);
    let more = more.map(|more| format!("and {more} more; --format json lists all"));
    lines.section("Explain one of", found.candidates.iter().take(MAX_CANDIDATES).cloned().chain(more));
    lines.0
}

fn limits(lines: &mut Lines, limits: &Limits) {
    lines.fact("Unit", limits.unit.as_deref().filter(|unit| *unit != NO_UNIT).unwrap_or_default());
    lines.fact("Range", limits.range.as_deref().unwrap_or_default());
    for fact in &limits.facts {
        lines.fact("Note", fact);
    }
}

fn member(member: &Member) -> String {
    with_description(format!("{} = {}", member.name, member.value), &member.description)
}

fn with_description(text: String, description: &str) -> String {
    let description = description.replace('\n', " ");
    if description.is_empty() { text } else { format!("{text}: {description}") }
}

fn unit(unit: Option<&str>) -> String {
    unit.filter(|unit| *unit != NO_UNIT).map(|unit| format!(" [{unit}]")).unwrap_or_default()
}

fn presence(lines: &mut Lines, presence: &Presence) {
    lines.0.push('\n');
    lines.fact("Since", presence.since.as_deref().unwrap_or_default());
    lines.fact("Releases", &presence.releases.join(", "));
    for entry in &presence.history {
        let _ = writeln!(lines.0, "\nChanges in {}", entry.release);
        for change in &entry.changes {
            lines.line(4, &format!("  {}", shown(change)));
        }
    }
}
