//! `count-missing`: a field that counts the entries of an array, but has no `@count`.

use uavspec_schema::msg::annotation::is_bracketed;
use uavspec_schema::msg::ast::Line;
use uavspec_schema::msg::statement::Statement;
use uavspec_schema::source::Span;
use uavspec_schema::{Element, Field, Shape};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "count-missing",
    statement: "A field that seems to count the used entries of an array, but has no `@count`.",
    why: "Without `@count`, tools can only guess from the names which entries are valid. PX4's own \
        tools do not support `@count` yet.",
    fix: "Add `[@count array]` with the name of the array.",
    levels: Levels::strict(Level::Note),
    bad: glider![
        "uint8 num_waypoints    # [-] Waypoints in use",
        "float32[8] waypoints  # [m] Distance to each"
    ],
    good: glider![
        "uint8 num_waypoints    # [-] [@count waypoints] Waypoints in use",
        "float32[8] waypoints  # [m] Distance to each"
    ],
    measured: Some(Measured { findings: 9, sample: 9, right: 9 }),
    check: Check::Message(Scope::Px4, check),
};

/// Prefixes, suffixes and complete names of fields that count the entries of an array.
const STARTS: [&str; 2] = ["num_", "n_"];
const ENDS: [&str; 3] = ["_count", "_len", "_length"];
const WHOLE: [&str; 4] = ["count", "num", "len", "length"];

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    let fields = &subject.message.fields;
    let mut arrays = fields.iter().filter(|field| is_list(field));
    let only = arrays.next().filter(|_| arrays.next().is_none());
    let has_count = fields.iter().any(|field| field.counts.is_some());
    for (field, line) in subject.fields() {
        if let Some(array) = field.counts.and_then(|array| fields.get(array)) {
            if !states_count(line) {
                let help = format!("write `[@count {}]`", array.name);
                let message = format!("`{}` seems to count the entries of `{}`", field.name, array.name);
                let finding = sink.report(field.span, message, help);
                if is_bracketed(&format!("[@count {}]", array.name)) {
                    finding.fix.push(insertion(line, &array.name, subject.sources));
                }
            }
        } else if let Some(array) = only.filter(|array| !has_count && looks_like_count(field, array)) {
            let help =
                format!("if it counts the entries of `{}`, write `[@count {}]`", array.name, array.name);
            sink.report(field.span, format!("`{}` may count the entries of an array", field.name), help);
        }
    }
}

/// True for an array that may be partly used. Text, vectors and quaternions are always used completely.
fn is_list(field: &Field) -> bool {
    matches!(field.ty.shape, Shape::Array(length) if length > 4)
}

fn looks_like_count(field: &Field, array: &Field) -> bool {
    let name = field.name.as_str();
    let is_integer = matches!(field.ty.element, Element::Scalar(scalar) if scalar.integer_bounds().is_some());
    let mut named = STARTS.iter().filter_map(|start| name.strip_prefix(start));
    let mut named_before = ENDS.iter().filter_map(|end| name.strip_suffix(end));
    // The name of the count may contain the array's name in the singular.
    let is_array =
        |rest: &str| array.name.strip_prefix(rest).is_some_and(|rest| matches!(rest, "" | "s" | "es"));
    is_integer
        && field.ty.shape == Shape::Single
        && (WHOLE.contains(&name) || named.any(is_array) || named_before.any(is_array))
}

fn states_count(line: &Line<'_>) -> bool {
    let note = line.comment.as_ref().and_then(|comment| comment.note.as_ref());
    note.is_some_and(|note| {
        note.annotations.iter().any(|annotation| matches!(annotation.statement, Statement::Count(_)))
    })
}

/// The edit that inserts the annotation at the start of the comment, after a unit, or in a new comment.
fn insertion(line: &Line<'_>, array: &str, sources: &SourceMap) -> Edit {
    let Some(comment) = &line.comment else {
        let end = sources.slice(line.span).trim_end().len();
        return Edit { span: line.span.part(end..end), text: format!("  # [@count {array}]") };
    };
    let start = 1 + comment.text.len() - comment.text.trim_start().len();
    let first = comment.note.as_ref().and_then(|note| note.annotations.first());
    match first.filter(|first| {
        first.span.start == comment.span.part(start..start).start
            && matches!(first.statement, Statement::Unit(_))
    }) {
        Some(unit) => {
            let at = Span { start: unit.span.end, end: unit.span.end };
            Edit { span: at, text: format!(" [@count {array}]") }
        }
        None if comment.text.is_empty() => {
            Edit { span: comment.span.part(1..1), text: format!(" [@count {array}]") }
        }
        None => Edit { span: comment.span.part(start..start), text: format!("[@count {array}] ") },
    }
}
