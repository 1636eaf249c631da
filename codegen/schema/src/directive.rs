//! Directives in comments: `uavspec:ignore RULE reason` makes `uavspec lint` ignore a finding.

use crate::span::Span;

/// The start of a directive.
pub const MARK: &str = "uavspec:ignore";

/// The start of a comment that contains a directive.
const OPENINGS: [&str; 3] = ["<!--", "//", "#"];

/// An exception to a rule at one location.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Directive<'s> {
    /// The id of the rule; empty if absent.
    pub rule: &'s str,
    /// The reason; empty if absent.
    pub reason: &'s str,
    /// The location of the directive, from its first to its last character.
    pub span: Span,
}

/// Finds the directive in `text`, which is located at `span`. Also returns the position in the text where the
/// directive's comment starts. The directive extends to the end of the line.
pub fn find(text: &str, span: Span) -> Option<(Directive<'_>, usize)> {
    let at = text.find(MARK)?;
    let words = &text[at + MARK.len()..];
    if !words.is_empty() && !words.starts_with([' ', '\t']) {
        return None;
    }
    let end = text.find("-->").filter(|end| *end > at).unwrap_or(text.len());
    let words = text[at + MARK.len()..end].trim();
    let (rule, reason) = words.split_once([' ', '\t']).unwrap_or((words, ""));
    let before = text[..at].trim_end();
    let start = OPENINGS.iter().find_map(|opening| before.strip_suffix(opening)).unwrap_or(before);
    let directive =
        Directive { rule, reason: reason.trim(), span: span.part(at..text[..end].trim_end().len()) };
    Some((directive, start.trim_end().len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_a_directive_at_the_end_of_any_comment() {
        let found = |text| find(text, Span::default()).map(|(found, at)| (found.rule, found.reason, at));
        assert_eq!(
            found(" [m] Height # uavspec:ignore unit-missing as upstream"),
            Some(("unit-missing", "as upstream", 11))
        );
        assert_eq!(found(" uavspec:ignore a-b  why "), Some(("a-b", "why", 0)));
        assert_eq!(found("| 64 | A | x | <!-- uavspec:ignore a why -->"), Some(("a", "why", 14)));
        assert_eq!(found("uavspec:ignore"), Some(("", "", 0)));
        assert_eq!(found("uavspec:ignored a b"), None);
        assert_eq!(found("nothing"), None);
    }
}
