//! The parser, with one function for each grammar production.

mod separator;
mod value;

use uavspec_runtime::Scalar;

use self::separator::ROSIDL;
pub use self::separator::is_separator;
use super::annotation;
use super::ast::{Comment, Definition, Element, Item, Line, Name, Part, Shape, Type};
use super::kind::{Dialect, Kind};
use crate::diagnostic::{Diagnostic, Problem, has_errors};
use crate::limits::{MAX_ARRAY, MAX_BAD_LINES};
use crate::name::is_identifier;
use crate::source::Span;
use crate::{characters, directive};

/// The tool that reads the messages of PX4.
const PX4_GENERATOR: &str = "PX4's generator";

pub(super) fn parse(
    text: &str,
    span: Span,
    kind: Kind,
    dialect: Dialect,
) -> (Definition<'_>, Vec<Diagnostic>) {
    let mut diagnostics = Vec::new();
    let mut parts = vec![Part::default()];
    let expected = kind.part_suffixes().len();
    let mut at = 0;
    let mut bad_lines = 0;
    for raw in text.split_inclusive('\n') {
        if bad_lines > MAX_BAD_LINES {
            return (Definition { parts: padded(parts, expected) }, diagnostics);
        }
        let line = raw.strip_suffix('\n').unwrap_or(raw);
        let line = line.strip_suffix('\r').filter(|_| raw.ends_with('\n')).unwrap_or(line);
        let place = span.part(at..at + line.len());
        at += raw.len();
        let reported = diagnostics.len();
        characters::check(line, place, &mut diagnostics);
        let has_bad_character = has_errors(&diagnostics[reported..]);
        if let Some(problem) = separator::invalid(line, place, kind) {
            diagnostics.truncate(reported);
            diagnostics.push(problem);
            bad_lines += 1;
            if parts.len() < expected {
                parts.push(Part::default());
            }
            continue;
        }
        if is_separator(line) {
            separator::check(line, place, &mut diagnostics);
            if let (Some(at), Some(part)) = (line.find('#'), parts.last_mut()) {
                let (line, span) = (&line[at..], place.part(at..line.len()));
                let comment = LineParser { line, span, at: 0, dialect, diagnostics: &mut diagnostics }.line();
                // Without the blank line, the comment could become the documentation of the part.
                part.lines.extend([Line::blank(span), comment]);
            }
            if parts.len() < expected {
                parts.push(Part::default());
            } else {
                diagnostics.push(Diagnostic::new(Problem::MisplacedSeparator, place));
            }
            continue;
        }
        let reported = diagnostics.len();
        let line = LineParser { line, span: place, at: 0, dialect, diagnostics: &mut diagnostics }.line();
        if line.is_invalid && has_bad_character {
            // The character is the cause of the error, so report only the character.
            diagnostics.truncate(reported);
        }
        bad_lines += usize::from(line.is_invalid || has_bad_character);
        if let Some(part) = parts.last_mut() {
            part.lines.push(line);
        }
    }
    if parts.len() < expected {
        let end = span.part(text.len()..text.len());
        diagnostics.push(Diagnostic::new(Problem::MissingSeparator { found: parts.len(), expected }, end));
    }
    (Definition { parts: padded(parts, expected) }, diagnostics)
}

/// Adds an empty part for each missing part.
fn padded(mut parts: Vec<Part<'_>>, expected: usize) -> Vec<Part<'_>> {
    parts.resize_with(expected, Part::default);
    parts
}

/// Marks a production that could not be parsed; the diagnostic has been reported.
struct Invalid;

struct LineParser<'s, 'd> {
    line: &'s str,
    span: Span,
    at: usize,
    dialect: Dialect,
    diagnostics: &'d mut Vec<Diagnostic>,
}

impl<'s> LineParser<'s, '_> {
    fn line(&mut self) -> Line<'s> {
        self.skip_spaces();
        self.check_indent();
        let mut line = Line::blank(self.span);
        if !self.is_at_end() {
            if let Ok(item) = self.item() {
                line.item = Some(Box::new(item));
            } else {
                // Skip the rest of the line except its comment.
                line.is_invalid = true;
                self.at = self.line[self.at..].find('#').map_or(self.line.len(), |at| self.at + at);
            }
        }
        line.comment = self.comment(line.item.as_deref()).map(Box::new);
        line
    }

    /// Reports spaces before a declaration. rosidl interprets them as an empty type.
    fn check_indent(&mut self) {
        if self.dialect == Dialect::Ros2 && self.at > 0 && !self.is_at_end() {
            let text = self.line.split('#').next().unwrap_or(self.line).trim_end().to_owned();
            let problem = Problem::NotPortable { tool: ROSIDL, text, instead: Some(String::new()) };
            self.report_with(
                problem,
                self.span.part(0..self.at),
                "remove the spaces at the start of the line",
            );
        }
    }

    fn item(&mut self) -> Result<Item<'s>, Invalid> {
        let start = self.at;
        let type_text = self.word(|c| !is_space(c) && c != '#');
        let type_span = self.span.part(start..self.at);
        if type_text.starts_with('@') {
            return Err(self.report(Problem::UnsupportedAnnotation { text: type_text.to_owned() }, type_span));
        }
        let spaces = self.word(is_space);
        if self.is_at_end() {
            return Err(self.missing_name(type_text, type_span));
        }
        let ty = self.parse_type(type_text, type_span)?;
        let name = self.name(type_text)?;
        if self.dialect == Dialect::Px4 && !spaces.contains(' ') {
            let instead = Some(format!("{type_text} {}", name.text));
            let text = format!("{type_text}<tab>{}", name.text);
            let problem = Problem::NotPortable { tool: PX4_GENERATOR, text, instead };
            self.report_with(problem, type_span.to(name.span), "put a space between type and name");
        }
        self.skip_spaces();
        if self.rest().starts_with('=') {
            self.at += 1;
            self.constant(&ty, name).map(Item::Constant)
        } else {
            self.check_style(name, false);
            self.field(ty, name).map(Item::Field)
        }
    }

    fn missing_name(&mut self, type_text: &str, span: Span) -> Invalid {
        let diagnostic = Diagnostic::new(Problem::MissingName { type_name: type_text.to_owned() }, span);
        let other_space = type_text.chars().find(|c| c.is_whitespace());
        self.diagnostics.push(match other_space {
            Some(c) => {
                diagnostic.with_hint(format!("U+{:04X} is not a separator; write a space", u32::from(c)))
            }
            None => diagnostic,
        });
        Invalid
    }

    /// Parses a name, up to white space, `=` or a comment.
    fn name(&mut self, type_text: &str) -> Result<Name<'s>, Invalid> {
        let start = self.at;
        let text = self.word(|c| !is_space(c) && !matches!(c, '=' | '#'));
        let span = self.span.part(start..self.at);
        let letters = text.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
        let (identifier, rest) = text.split_at(letters);
        if !identifier.starts_with(|c: char| c.is_ascii_alphabetic()) {
            return Err(self.report(Problem::InvalidName { name: text.to_owned() }, span));
        }
        if rest.is_empty() {
            return Ok(Name { text, span });
        }
        if rest.starts_with('[') {
            let problem = Problem::ArrayAfterName { name: identifier.to_owned() };
            let hint = match rest.find(']') {
                Some(end) if end + 1 == rest.len() => {
                    format!("move it to the type: `{type_text}{rest} {identifier}`")
                }
                _ => problem.hint(),
            };
            return Err(self.report_with(problem, span, hint));
        }
        let problem = Problem::InvalidName { name: text.to_owned() };
        Err(match rest {
            ";" => self.report_with(problem, span, "remove the `;`; a declaration ends with the line"),
            _ => self.report(problem, span),
        })
    }

    /// Checks the style of a name. ROS 2 rejects names that violate the style; PX4 accepts most of them.
    fn check_style(&mut self, name: Name<'_>, is_constant: bool) {
        let well_formed = |is_letter: fn(u8) -> bool| {
            name.text.bytes().all(|byte| is_letter(byte) || byte.is_ascii_digit() || byte == b'_')
                && !name.text.ends_with('_')
                && !name.text.contains("__")
        };
        let (is_well_formed, style) = if is_constant {
            (well_formed(|byte| byte.is_ascii_uppercase()), "UPPER_SNAKE_CASE")
        } else {
            (well_formed(|byte| byte.is_ascii_lowercase()), "lower_snake_case")
        };
        if is_well_formed {
            return;
        }
        let name_text = name.text.to_owned();
        let problem = match self.dialect {
            Dialect::Px4 => Problem::NameStyle { name: name_text, style },
            Dialect::Ros2 => Problem::NameStyleRos { name: name_text, style },
        };
        let words = crate::name::words(name.text).join("_");
        let suggestion = if is_constant { words.to_ascii_uppercase() } else { words.to_ascii_lowercase() };
        self.report_with(problem, name.span, format!("write `{suggestion}`"));
    }

    fn parse_type(&mut self, text: &'s str, span: Span) -> Result<Type<'s>, Invalid> {
        let (element_text, brackets) = match text.find('[') {
            Some(at) => text.split_at(at),
            None => (text, ""),
        };
        let shape = self.shape(brackets, span.part(element_text.len()..text.len()))?;
        let element = self.element(element_text, span.part(0..element_text.len()))?;
        if self.dialect == Dialect::Px4 && matches!(shape, Shape::Sequence | Shape::Bounded(_)) {
            let what = format!("variable-length arrays such as `{brackets}`");
            return Err(self.not_in_px4(what, span, "use a fixed length: `[8]`"));
        }
        Ok(Type { span, element, shape })
    }

    /// Parses `[N]`, `[<=N]`, `[]` or an empty text.
    fn shape(&mut self, brackets: &str, span: Span) -> Result<Shape, Invalid> {
        if brackets.is_empty() {
            return Ok(Shape::Single);
        }
        let Some(length) = brackets.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')) else {
            return Err(self.report(Problem::InvalidArray { text: brackets.to_owned() }, span));
        };
        if length.contains(['[', ']']) {
            return Err(self.report(Problem::MultiDimensional, span));
        }
        if length.is_empty() {
            return Ok(Shape::Sequence);
        }
        match length.strip_prefix("<=") {
            Some(bound) => self.length(bound, brackets, span).map(Shape::Bounded),
            None => self.length(length, brackets, span).map(Shape::Array),
        }
    }

    fn length(&mut self, digits: &str, whole: &str, span: Span) -> Result<u32, Invalid> {
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(self.report(Problem::InvalidArray { text: whole.to_owned() }, span));
        }
        match digits.parse::<u32>() {
            Ok(0) => Err(self.report(Problem::ZeroLength, span)),
            Ok(length) if length <= MAX_ARRAY => Ok(length),
            _ => {
                Err(self
                    .report(Problem::TooLarge { what: format!("`{whole}`"), max: MAX_ARRAY.into() }, span))
            }
        }
    }

    fn element(&mut self, text: &'s str, span: Span) -> Result<Element<'s>, Invalid> {
        if let Some(scalar) = Scalar::from_name(text) {
            if scalar == Scalar::Byte {
                self.only_in_ros2("the type `byte`", span, "write `uint8`")?;
            }
            return Ok(Element::Scalar(scalar));
        }
        let (base, bound) = match text.split_once("<=") {
            Some((base, bound)) => (base, Some(bound)),
            None => (text, None),
        };
        if matches!(base, "string" | "wstring") {
            self.only_in_ros2(
                &format!("the type `{text}`"),
                span,
                "write `char[16]`, with the maximum length in bytes",
            )?;
            let bound = match bound {
                Some(digits) => Some(self.length(digits, text, span)?),
                None => None,
            };
            return Ok(Element::String { wide: base == "wstring", bound });
        }
        self.message(text, span)
    }

    /// Parses `Name` or `package/Name`.
    fn message(&mut self, text: &'s str, span: Span) -> Result<Element<'s>, Invalid> {
        let (package, name) = match text.split_once('/') {
            Some((package, name)) => (Some(package), name),
            None => (None, text),
        };
        if !is_identifier(name) || !package.is_none_or(is_identifier) {
            let problem = Problem::InvalidType { text: text.to_owned() };
            return Err(match (package, name.strip_prefix("msg/")) {
                (Some(package), Some(name)) => {
                    self.report_with(problem, span, format!("write `{package}/{name}`"))
                }
                _ => self.report(problem, span),
            });
        }
        if package.is_some() {
            self.only_in_ros2(
                "messages of other packages",
                span,
                "write only the name, and add the definition to this package",
            )?;
        }
        Ok(Element::Message { package, name })
    }

    fn only_in_ros2(&mut self, what: &str, span: Span, instead: &str) -> Result<(), Invalid> {
        if self.dialect == Dialect::Ros2 {
            return Ok(());
        }
        Err(self.not_in_px4(what.to_owned(), span, instead))
    }

    fn not_in_px4(&mut self, what: String, span: Span, instead: &str) -> Invalid {
        let problem = Problem::NotInDialect { what, dialect: "px4" };
        let hint = format!("{instead}; {}", problem.hint());
        self.report_with(problem, span, hint)
    }

    fn expect_end(&mut self) -> Result<(), Invalid> {
        self.skip_spaces();
        if self.is_at_end() {
            return Ok(());
        }
        let start = self.at;
        let text = self.word(|c| c != '#').trim_end();
        let span = self.span.part(start..start + text.len());
        Err(self.report(Problem::UnexpectedText { text: text.to_owned() }, span))
    }

    fn comment(&mut self, item: Option<&Item<'_>>) -> Option<Comment<'s>> {
        let column = self.at;
        let whole = self.rest().strip_prefix('#')?.trim_end();
        let found = directive::find(whole, self.span.part(column + 1..column + 1 + whole.len()));
        let text = found.map_or(whole, |(_, start)| &whole[..start]);
        let span = self.span.part(column + 1..column + 1 + text.len());
        let note = match item {
            Some(Item::Field(_)) => Some(annotation::read(text, span, self.diagnostics)),
            Some(Item::Constant(_)) => Some(annotation::read_with_parameters(text, span, self.diagnostics)),
            None => None,
        };
        let span = self.span.part(column..column + 1 + whole.len());
        Some(Comment { span, column, text, directive: found.map(|(directive, _)| directive), note })
    }

    /// Consumes characters that satisfy `take`.
    fn word(&mut self, take: impl Fn(char) -> bool) -> &'s str {
        let rest = &self.line[self.at..];
        let len = rest.find(|c| !take(c)).unwrap_or(rest.len());
        self.at += len;
        &rest[..len]
    }

    fn skip_spaces(&mut self) {
        self.word(is_space);
    }

    fn rest(&self) -> &'s str {
        &self.line[self.at..]
    }

    /// True if only a comment is left.
    fn is_at_end(&self) -> bool {
        self.rest().is_empty() || self.rest().starts_with('#')
    }

    fn report(&mut self, problem: Problem, span: Span) -> Invalid {
        self.diagnostics.push(Diagnostic::new(problem, span));
        Invalid
    }

    fn report_with(&mut self, problem: Problem, span: Span, hint: impl Into<String>) -> Invalid {
        self.diagnostics.push(Diagnostic::new(problem, span).with_hint(hint));
        Invalid
    }
}

fn is_space(character: char) -> bool {
    matches!(character, ' ' | '\t')
}
