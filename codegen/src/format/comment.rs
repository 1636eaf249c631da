//! Comments, from the `#` on.

use std::fmt::Write as _;

use super::meaning;
use crate::directive;
use crate::msg::annotation::{self, Annotation, Note};
use crate::msg::statement::Statement;
use crate::msg::words::{single_spaced, split_word};
use crate::schema::documentation::is_ruler;
use crate::source::Span;

/// A comment on a line of its own; `text` is what follows the `#`. All blanks after the first are part of
/// what it says.
pub(super) fn own(text: &str) -> String {
    let is_apart = text.is_empty() || text.starts_with([' ', '\t']) || is_drawn(text);
    format!("#{}{text}", if is_apart { "" } else { " " })
}

/// A comment that goes on with the one above.
pub(super) fn continued(text: &str) -> String {
    let rest = text.trim_start_matches([' ', '\t']);
    let indent = &text[..text.len() - rest.len()];
    if indent.contains('\t') { own(rest) } else { own(text) }
}

/// The comment of a declaration, with its annotations in order and spelled right. A directive at its end stays
/// as it is, and where it is.
pub(super) fn trailing(text: &str, is_constant: bool) -> String {
    let (said, directive) = split_directive(text);
    let with_directive = |said: String| match directive {
        "" => said,
        directive => format!("{said} {directive}"),
    };
    let laid_out = with_directive(with_mark(text, &body(said, is_constant)));
    let is_same = read(&laid_out[1..], is_constant) == read(text, is_constant);
    if is_same { laid_out } else { with_directive(with_mark(text, said.trim())) }
}

/// What a comment says, and the directive at its end.
fn read(text: &str, is_constant: bool) -> (String, &str) {
    let (said, directive) = split_directive(text);
    let note = if is_constant {
        annotation::read_with_parameters(said, Span::default(), &mut Vec::new())
    } else {
        annotation::read(said, Span::default(), &mut Vec::new())
    };
    (meaning::of_note(&note), directive)
}

/// `body` after its `#`, where `text` is what was written there.
fn with_mark(text: &str, body: &str) -> String {
    let is_joined = body.is_empty() || (!text.starts_with(char::is_whitespace) && is_drawn(body));
    format!("#{}{body}", if is_joined { "" } else { " " })
}

/// Whether a text starts with a stroke that a comment mark may run into: `----`, `## Heading`.
fn is_drawn(text: &str) -> bool {
    let len = text.len() - text.trim_start_matches(['#', '-', '=', '*', '_', '/']).len();
    text.starts_with('#') || is_ruler(&text[..len])
}

/// Parts a comment from the directive at its end.
pub(super) fn split_directive(text: &str) -> (&str, &str) {
    let (said, directive) =
        text.split_at(directive::find(text, Span::default()).map_or(text.len(), |(_, start)| start));
    (said, directive.trim_start())
}

fn body(text: &str, is_constant: bool) -> String {
    let mut body = String::new();
    match bars(text).filter(|_| is_constant) {
        Some(bars) => with_parameters(text, &bars, &mut body),
        None => note(text, &mut body),
    }
    body
}

/// Where the pipes between the parameters of a command stand, if there are as many as there have to be.
fn bars(text: &str) -> Option<Vec<usize>> {
    let bars: Vec<usize> = text.match_indices('|').map(|(at, _)| at).collect();
    annotation::PARAMETER_BARS.contains(&bars.len()).then_some(bars)
}

/// `text |p1|p2|…|p7|`.
fn with_parameters(text: &str, bars: &[usize], body: &mut String) {
    note(&text[..bars[0]], body);
    if !body.is_empty() {
        body.push(' ');
    }
    let ends = bars[1..].iter().copied().chain([text.len()]);
    for (number, (bar, end)) in bars.iter().zip(ends).enumerate() {
        body.push('|');
        let part = &text[bar + 1..end];
        // What follows the eighth pipe is no parameter.
        if number < 7 {
            note(part, body);
        } else if !part.trim().is_empty() {
            body.push(' ');
            body.push_str(part.trim());
        }
    }
}

/// The annotations of `text`, then what else it says.
fn note(text: &str, body: &mut String) {
    let Note { mut annotations, text: rest, .. } = annotation::read(text, Span::default(), &mut Vec::new());
    annotations.sort_by_key(|annotation| annotation.statement.rank());
    let mut separator = "";
    for annotation in &annotations {
        let _ = write!(body, "{separator}{}", spelled(text, annotation));
        separator = " ";
    }
    if !rest.is_empty() {
        body.push_str(separator);
        body.push_str(&rest);
    }
}

/// An annotation as it should be written. The words of its argument are those of `text`.
fn spelled(text: &str, annotation: &Annotation<'_>) -> String {
    let written = &text[annotation.span.start as usize..annotation.span.end as usize];
    let content = written.get(1..written.len() - 1).unwrap_or("").trim();
    match &annotation.statement {
        Statement::Unit(symbol) => format!("[{symbol}]"),
        Statement::Attribute(attribute, text) => format!("[@{} {text}]", attribute.name),
        Statement::Count(field) => format!("[@count {field}]"),
        Statement::Enum(_) => format!("[@enum {}]", single_spaced(argument(content, "enum"))),
        Statement::Flags(_) => format!("[@flags {}]", single_spaced(argument(content, "flags"))),
        Statement::Constraint(kind, ..) => {
            format!("[@{} {}]", kind.name, (kind.lay_out)(argument(content, kind.name)))
        }
        // Pages alone have these, and their words are none of this layout's business.
        Statement::Length { .. } | Statement::Unique | Statement::Pattern(_) | Statement::Format(_) => {
            format!("[{content}]")
        }
    }
}

/// What follows the name of an annotation, whether it has its `@`, and whether the name is there.
fn argument<'s>(content: &'s str, name: &str) -> &'s str {
    match split_word(content.strip_prefix('@').unwrap_or(content)) {
        (found, argument) if found == name => argument,
        _ => content,
    }
}
