//! Extracts references, alternatives and versions from the descriptions of error codes.

use std::ops::Range;

/// A reference to a code in a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Reference {
    /// The range of the code's digits in the description.
    pub(super) range: Range<usize>,
    /// True if the code is an alternative to the described code.
    pub(super) is_alternative: bool,
}

/// Words that indicate a code of another kind if they precede "code".
const FOREIGN: &[&str] = &["exit", "http", "key", "response", "result", "return", "status"];

/// Words between "use" and the condition: "use this error code only if".
const OBJECT: &[&str] = &["code", "error", "it", "one", "only", "that", "the", "this", "warning"];

/// The first words of a condition.
const CONDITION: &[&str] =
    &["if", "for", "in", "on", "unless", "until", "when", "whenever", "where", "while"];

/// Words in and before a version: "since version 2.10 of the specification".
const VERSION_WORDS: &[&str] = &["flockwave", "protocol", "release", "spec", "specification", "version"];

/// Finds the codes that `description` refers to: "code 131", "codes 66, 134 or 199".
///
/// References in "use … only if …; otherwise use code N" are alternatives. An alternative follows "use" in a clause
/// that starts with "otherwise", or in a clause after a condition and a semicolon.
pub(super) fn references(description: &str) -> Vec<Reference> {
    let lower = description.to_ascii_lowercase();
    let tokens = tokens(&lower);
    let mut references = Vec::new();
    let mut clause = Clause::default();
    let mut rest = &tokens[..];
    while let [token, after @ ..] = rest {
        rest = after;
        match &token.kind {
            Kind::Word(word @ ("code" | "codes"))
                if !is_foreign(&tokens[..tokens.len() - after.len() - 1]) =>
            {
                let is_alternative = clause.is_choice && clause.has_use;
                let numbers = list(&mut rest, *word == "codes");
                references.extend(numbers.into_iter().map(|range| Reference { range, is_alternative }));
            }
            kind => clause.read(kind, after),
        }
    }
    references
}

/// Finds the version after "since": "since specification 2.10".
pub(super) fn since(description: &str) -> Option<&str> {
    let lower = description.to_ascii_lowercase();
    let tokens = tokens(&lower);
    tokens.iter().enumerate().filter(|(_, token)| token.kind == Kind::Word("since")).find_map(|(index, _)| {
        let after = tokens[index + 1..].iter().take(3);
        let version = after.into_iter().find(|token| !is_word(&token.kind, VERSION_WORDS))?;
        let text = description[version.range.clone()].trim_start_matches(['v', 'V']);
        is_version(text).then_some(text)
    })
}

/// True for numbers separated by dots. A single number may be a count instead of a version.
fn is_version(text: &str) -> bool {
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    text.contains('.') && text.split('.').all(is_number)
}

/// The parser state within a sentence.
#[derive(Default)]
struct Clause {
    /// True after a condition for the use of the described code.
    is_conditional: bool,
    /// True in a clause about other cases.
    is_choice: bool,
    /// True after "use" in a clause about other cases.
    has_use: bool,
}

impl Clause {
    fn read(&mut self, kind: &Kind<'_>, rest: &[Token<'_>]) {
        match kind {
            Kind::Word("use" | "used") if self.is_choice => self.has_use = true,
            Kind::Word("use" | "used") => self.is_conditional |= starts_condition(rest),
            Kind::Word("otherwise") => (self.is_choice, self.has_use) = (true, false),
            Kind::Semicolon => (self.is_choice, self.has_use) = (self.is_conditional, false),
            Kind::Stop => (self.is_choice, self.has_use) = (false, false),
            _ => {}
        }
    }
}

fn starts_condition(tokens: &[Token<'_>]) -> bool {
    let first = tokens.iter().find(|token| !is_word(&token.kind, OBJECT));
    first.is_some_and(|first| is_word(&first.kind, CONDITION))
}

/// True for words such as "exit code" and "HTTP error code", given the tokens before "code".
fn is_foreign(before: &[Token<'_>]) -> bool {
    let noun = before.iter().rev().take(2).find(|token| token.kind != Kind::Word("error"));
    noun.is_some_and(|noun| is_word(&noun.kind, FOREIGN))
}

/// Consumes the list of numbers at the start of `rest`: "134", "66, 134 and 199", "66 or code 134".
fn list(rest: &mut &[Token<'_>], is_plural: bool) -> Vec<Range<usize>> {
    let mut numbers = Vec::new();
    while let [number, after @ ..] = *rest {
        // In "code 131, 3 seconds later", the second number is not a code.
        let counts = matches!(after, [Token { kind: Kind::Word(word), .. }, ..] if !is_joint(word));
        let is_doubtful = !is_plural && !numbers.is_empty() && counts;
        if number.kind != Kind::Number || starts_range(after) || is_doubtful {
            break;
        }
        numbers.push(number.range.clone());
        *rest = skip_joints(after);
        if rest.len() == after.len() {
            break;
        }
    }
    numbers
}

/// True for a range such as "64 to 127", which doesn't refer to a single code.
fn starts_range(tokens: &[Token<'_>]) -> bool {
    matches!(tokens, [dash, end, ..] if end.kind == Kind::Number
        && (dash.kind == Kind::Dash || is_word(&dash.kind, &["to", "through"])))
}

/// Skips the separators of a list: `,`, `or`, `and code`.
fn skip_joints<'t, 's>(tokens: &'t [Token<'s>]) -> &'t [Token<'s>] {
    let is_joint = |token: &Token<'_>| match token.kind {
        Kind::Comma => true,
        Kind::Word(word) => is_joint(word),
        _ => false,
    };
    let joints = tokens.iter().take_while(|token| is_joint(token)).count();
    let is_code = |token: &&Token<'_>| is_word(&token.kind, &["error", "code", "codes"]);
    let nouns = tokens[joints..].iter().take_while(is_code).count();
    if joints == 0 { tokens } else { &tokens[joints + nouns..] }
}

fn is_joint(word: &str) -> bool {
    matches!(word, "or" | "and")
}

fn is_word(kind: &Kind<'_>, words: &[&str]) -> bool {
    matches!(kind, Kind::Word(word) if words.contains(word))
}

#[derive(Debug)]
struct Token<'s> {
    kind: Kind<'s>,
    range: Range<usize>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Kind<'s> {
    /// Letters and digits with inner punctuation: `e.g`, `2.10`, `user-defined`, `64-127`.
    Word(&'s str),
    /// Digits only.
    Number,
    Comma,
    Dash,
    Semicolon,
    /// The end of a sentence.
    Stop,
    Other,
}

fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens: Vec<Token<'_>> = Vec::new();
    let mut at = 0;
    while let Some(c) = text[at..].chars().next() {
        let len = if c.is_alphanumeric() { word_len(&text[at..]) } else { c.len_utf8() };
        let range = at..at + len;
        at += len;
        let kind = match c {
            _ if c.is_alphanumeric() => word(&text[range.clone()]),
            ',' | '/' | '&' => Kind::Comma,
            '-' | '–' | '—' => Kind::Dash,
            ';' => Kind::Semicolon,
            '.' | '!' | '?' if !is_abbreviation(&tokens) => Kind::Stop,
            _ if c.is_whitespace() => continue,
            _ => Kind::Other,
        };
        tokens.push(Token { kind, range });
    }
    tokens
}

fn word(text: &str) -> Kind<'_> {
    if text.bytes().all(|byte| byte.is_ascii_digit()) { Kind::Number } else { Kind::Word(text) }
}

/// True if the previous word is an abbreviation such as `e.g`, whose full stop doesn't end a sentence.
fn is_abbreviation(tokens: &[Token<'_>]) -> bool {
    matches!(tokens.last(), Some(Token { kind: Kind::Word(word), .. }) if word.contains('.'))
}

/// The length of the word at the start of `text`.
fn word_len(text: &str) -> usize {
    let mut len = 0;
    loop {
        let rest = &text[len..];
        len += rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len());
        let mut next = text[len..].chars();
        match (next.next(), next.next()) {
            (Some(joint @ ('.' | '-' | '–' | '_' | '\'' | '’')), Some(letter))
                if letter.is_alphanumeric() =>
            {
                len += joint.len_utf8();
            }
            _ => return len,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(text: &str, is_alternative: bool) -> Vec<&str> {
        references(text)
            .into_iter()
            .filter(|reference| reference.is_alternative == is_alternative)
            .map(|reference| &text[reference.range])
            .collect()
    }

    #[test]
    fn finds_lists_of_codes_after_the_word_code() {
        for (text, expected) in [
            ("See code 131.", &["131"][..]),
            ("Codes 134 or 199 are worse", &["134", "199"]),
            ("(codes 66, 134 and 199)", &["66", "134", "199"]),
            ("error code 66, 134, or 199; code 1/2", &["66", "134", "199", "1", "2"]),
            ("code 5 or error code 6", &["5", "6"]),
            ("CODE 7, then 8", &["7"]),
            ("code 131, 3 seconds later", &["131"]),
            ("codes 64-127, codes 64 to 127, codes 64 – 127", &[]),
            ("barcode 5, code-6, code 2.10, code x1, exit code 3, HTTP error code 4", &[]),
            ("no code", &[]),
            ("code 99999999999", &["99999999999"]),
        ] {
            assert_eq!(codes(text, false), expected, "{text}");
        }
    }

    #[test]
    fn finds_alternatives_after_a_condition() {
        for (text, expected) in [
            (
                "Fuel low. Use this error code only if there is enough (e.g. for the way home); otherwise use code 5 or 6. See code 7.",
                &["5", "6"][..],
            ),
            ("USE IT ONLY FOR boats; OTHERWISE USE CODES 5, 6 AND 7.", &["5", "6", "7"]),
            ("Use this error code if it floats; when it sinks use code 5.", &["5"]),
            ("Use only while afloat. Otherwise, use either error code 5 or code 6!", &["5", "6"]),
            ("To be used only when afloat; otherwise, e.g. ashore, use code 5", &["5"]),
            ("Only when afloat; otherwise use code 5.", &["5"]),
            ("Leaks; for worse leaks use code 5.", &[]),
            ("Used for leaks. Use code 5 for floods.", &[]),
            ("Use this error code only for boats; see code 5 for ships.", &[]),
            ("Use this error code for any leak. Code 5 is worse.", &[]),
        ] {
            assert_eq!(codes(text, true), expected, "{text}");
        }
    }

    #[test]
    fn finds_versions_with_dots() {
        for text in [
            "Leak (since 2.10).",
            "Leak. Since specification 2.10",
            "since version v2.10 of it",
            "since the flood; since 2.10",
        ] {
            assert_eq!(since(text), Some("2.10"), "{text}");
        }
        for text in ["since 5 minutes", "ever since", "since", "since version two", "since 2..1", "2.10"] {
            assert_eq!(since(text), None, "{text}");
        }
    }
}
