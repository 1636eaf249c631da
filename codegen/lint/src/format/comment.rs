//! Formatting of comments, from the `#` on.

use std::fmt::Write as _;

use uavspec_schema::directive;
use uavspec_schema::documentation::is_ruler;
use uavspec_schema::msg::annotation::{self, Annotation, Note};
use uavspec_schema::msg::statement::Statement;
use uavspec_schema::msg::words::{single_spaced, split_word};
use uavspec_schema::source::Span;

use super::meaning;

/// Formats a comment on a separate line. `text` is the part after the `#`. White space after the first space is
/// significant.
pub(super) fn standalone(text: &str) -> String {
    let needs_no_space = text.is_empty() || text.starts_with([' ', '\t']) || is_drawn(text);
    format!("#{}{text}", if needs_no_space { "" } else { " " })
}

/// Formats a comment line that continues the comment above.
pub(super) fn continued(text: &str) -> String {
    let rest = text.trim_start_matches([' ', '\t']);
    let indent = &text[..text.len() - rest.len()];
    if indent.contains('\t') { standalone(rest) } else { standalone(text) }
}

/// Formats the comment of a declaration, with its annotations in a fixed order and spelling. A directive at the end is
/// left unchanged.
pub(super) fn trailing(text: &str, is_constant: bool) -> String {
    let (content, directive) = split_directive(text);
    let with_directive = |content: String| match directive {
        "" => content,
        directive => format!("{content} {directive}"),
    };
    let laid_out = with_directive(with_mark(text, &body(content, is_constant)));
    let is_same = read(&laid_out[1..], is_constant) == read(text, is_constant);
    if is_same { laid_out } else { with_directive(with_mark(text, content.trim())) }
}

/// Returns a description of the comment's content, for comparison, and the directive at the comment's end.
fn read(text: &str, is_constant: bool) -> (String, &str) {
    let (content, directive) = split_directive(text);
    let note = if is_constant {
        annotation::read_with_parameters(content, Span::default(), &mut Vec::new())
    } else {
        annotation::read(content, Span::default(), &mut Vec::new())
    };
    (meaning::describe_note(&note), directive)
}

/// Prepends `#` and a space to `body`. Omits the space if `body` is empty, or if it is a ruler or heading that directly
/// followed the `#` in `text`.
fn with_mark(text: &str, body: &str) -> String {
    let touches_mark = body.is_empty() || (!text.starts_with(char::is_whitespace) && is_drawn(body));
    format!("#{}{body}", if touches_mark { "" } else { " " })
}

/// True if the text starts with characters that may directly follow the `#` of a comment: `----`, `## Heading`.
fn is_drawn(text: &str) -> bool {
    let len = text.len() - text.trim_start_matches(['#', '-', '=', '*', '_', '/']).len();
    text.starts_with('#') || is_ruler(&text[..len])
}

/// Splits a comment into its text and the directive at its end.
pub(super) fn split_directive(text: &str) -> (&str, &str) {
    let (content, directive) =
        text.split_at(directive::find(text, Span::default()).map_or(text.len(), |(_, start)| start));
    (content, directive.trim_start())
}

fn body(text: &str, is_constant: bool) -> String {
    let mut body = String::new();
    match bars(text).filter(|_| is_constant) {
        Some(bars) => push_parameters(text, &bars, &mut body),
        None => push_note(text, &mut body),
    }
    body
}

/// The offsets of the pipes that separate the parameters of a command, if the number of pipes is valid.
fn bars(text: &str) -> Option<Vec<usize>> {
    let bars: Vec<usize> = text.match_indices('|').map(|(at, _)| at).collect();
    annotation::PARAMETER_BARS.contains(&bars.len()).then_some(bars)
}

/// Appends a comment of the form `text |p1|p2|…|p7|` to `body`.
fn push_parameters(text: &str, bars: &[usize], body: &mut String) {
    push_note(&text[..bars[0]], body);
    if !body.is_empty() {
        body.push(' ');
    }
    let ends = bars[1..].iter().copied().chain([text.len()]);
    for (number, (bar, end)) in bars.iter().zip(ends).enumerate() {
        body.push('|');
        let part = &text[bar + 1..end];
        // Text after the eighth pipe is not a parameter.
        if number < 7 {
            push_note(part, body);
        } else if !part.trim().is_empty() {
            body.push(' ');
            body.push_str(part.trim());
        }
    }
}

/// Formats the annotations of `text`, followed by its remaining text.
fn push_note(text: &str, body: &mut String) {
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

/// The normalized spelling of an annotation. The words of the argument are copied from `text`.
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
        // These annotations occur only in pages, which this formatter does not rewrite.
        Statement::Length { .. } | Statement::Unique | Statement::Pattern(_) | Statement::Format(_) => {
            format!("[{content}]")
        }
    }
}

/// The argument of an annotation. The `@` or the name of the annotation may be missing.
fn argument<'s>(content: &'s str, name: &str) -> &'s str {
    match split_word(content.strip_prefix('@').unwrap_or(content)) {
        (found, argument) if found == name => argument,
        _ => content,
    }
}
