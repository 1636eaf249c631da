//! The values of constants and the defaults of fields.

use std::ops::Range;

use uavspec_runtime::Scalar;

use super::{Invalid, LineParser, PX4_GENERATOR, ROSIDL};
use crate::diagnostic::Problem;
use crate::model;
use crate::msg::ast::{Constant, Element, Field, Name, Shape, Type};
use crate::msg::kind::Dialect;
use crate::msg::literal::{self, LiteralError};
use crate::source::Span;
use crate::value::Value;

/// The hint for text that is not a list.
const LIST_HINT: &str = "write the elements in brackets: `[1, 2]`";

impl<'s> LineParser<'s, '_> {
    /// Reads the value of a constant.
    pub(super) fn constant(&mut self, ty: &Type<'s>, name: Name<'s>) -> Result<Constant<'s>, Invalid> {
        self.check_style(name, true);
        self.skip_spaces();
        let start = self.at;
        let (ty, value) = match (ty.element, ty.shape) {
            (Element::Scalar(scalar), Shape::Single) => {
                let text = self.word(|c| c != '#').trim_end();
                let span = self.span.part(start..start + text.len());
                if text.is_empty() {
                    return Err(self.report(Problem::MissingValue { name: name.text.to_owned() }, name.span));
                }
                (model::Element::Scalar(scalar), self.scalar(text, span, scalar)?)
            }
            (Element::String { wide, bound: None }, Shape::Single) => {
                (model::Element::String { wide, bound: None }, Value::Text(self.string()?))
            }
            _ => {
                let type_name = self.line[..(ty.span.end - self.span.start) as usize].trim_start().to_owned();
                return Err(self.report(Problem::ConstantType { type_name }, ty.span));
            }
        };
        let end = start + self.line[start..self.at].trim_end().len();
        Ok(Constant { ty, name, value, value_span: self.span.part(start..end) })
    }

    /// Reads a quoted string, or the text up to a comment.
    fn string(&mut self) -> Result<String, Invalid> {
        let start = self.at;
        if !self.rest().starts_with(['"', '\'']) {
            let text = self.word(|c| c != '#').trim_end().to_owned();
            self.check_string(start..start + text.len(), false);
            return Ok(text);
        }
        let quoted = self.quoted()?;
        self.check_string(start..self.at, false);
        self.expect_end()?;
        Ok(quoted)
    }

    /// Reports a string that rosidl reads differently or rejects.
    fn check_string(&mut self, range: Range<usize>, is_default: bool) {
        let text = &self.line[range.clone()];
        let hint = if text.contains('#') {
            "rosidl ends the line at the `#`, even in quotes; choose a value without `#`"
        } else if is_default && text.contains('=') {
            "rosidl parses this line as a constant because of the `=`, even in quotes; choose a value \
             without `=`"
        } else if text.contains('\t') {
            "rosidl replaces the tab with a space; write `\\t`"
        } else {
            return;
        };
        let problem = Problem::NotPortable { tool: ROSIDL, text: text.to_owned(), instead: None };
        self.report_with(problem, self.span.part(range), hint);
    }

    /// Reads the default of a string without quotes.
    fn unquoted(&mut self, within: fn(char) -> bool) -> Result<String, Invalid> {
        let start = self.at;
        let text = self.word(within).trim_end().to_owned();
        if text.contains('=') {
            let span = self.span.part(start..start + text.len());
            let problem = Problem::InvalidLiteral { text, type_name: "string".to_owned() };
            let hint = "rosidl parses this line as a constant because of the `=`; choose a value without `=`";
            return Err(self.report_with(problem, span, hint));
        }
        Ok(text)
    }

    fn quoted(&mut self) -> Result<String, Invalid> {
        let start = self.at;
        let Some(quoted) = literal::parse_quoted(self.rest()) else {
            let span = self.span.part(start..self.line.len());
            self.at = self.line.len();
            return Err(self.report(Problem::UnterminatedString, span));
        };
        for range in quoted.unknown_escapes {
            let escape = self.line[start + range.start..start + range.end].to_owned();
            self.report(
                Problem::UnknownEscape { escape },
                self.span.part(start + range.start..start + range.end),
            );
        }
        self.at += quoted.len;
        Ok(quoted.value)
    }

    fn scalar(&mut self, text: &str, span: Span, scalar: Scalar) -> Result<Value, Invalid> {
        let type_name = scalar.name().to_owned();
        match literal::parse_scalar(text, scalar) {
            Ok(value) => {
                if self.dialect == Dialect::Px4 && !literal::is_portable(text, &value) {
                    let instead = match &value {
                        Value::Bool(true) => Some("True".to_owned()),
                        Value::Bool(false) => Some("False".to_owned()),
                        Value::Float(_) => None,
                        value => Some(value.to_string()),
                    };
                    let hint = match &instead {
                        Some(instead) => format!("write `{instead}`"),
                        None => "PX4 truncates every constant to an integer".to_owned(),
                    };
                    let text = text.to_owned();
                    let problem = Problem::NotPortable { tool: PX4_GENERATOR, text, instead };
                    self.report_with(problem, span, hint);
                }
                Ok(value)
            }
            Err(LiteralError::Form) => {
                let problem = Problem::InvalidLiteral { text: text.to_owned(), type_name };
                Err(self.report_with(problem, span, literal::form(scalar)))
            }
            Err(LiteralError::Range { min, max }) => {
                Err(self
                    .report(Problem::ConstantOutOfRange { text: text.to_owned(), type_name, min, max }, span))
            }
        }
    }

    /// Reads the rest of a field: nothing, or a default value in ROS 2.
    pub(super) fn field(&mut self, ty: Type<'s>, name: Name<'s>) -> Result<Field<'s>, Invalid> {
        if self.is_at_end() {
            return Ok(Field { ty, name, default: None });
        }
        let start = self.at;
        if self.dialect == Dialect::Px4 {
            let text = self.word(|c| c != '#').trim_end();
            let span = self.span.part(start..start + text.len());
            let problem = Problem::UnexpectedText { text: text.to_owned() };
            let hint = format!("{}; PX4 has no default values", problem.hint());
            return Err(self.report_with(problem, span, hint));
        }
        let default = match ty.shape {
            Shape::Single => self.default_value(ty.element, |c| c != '#')?,
            shape => self.default_list(ty.element, shape)?,
        };
        self.expect_end()?;
        Ok(Field { ty, name, default: Some(default) })
    }

    fn default_value(&mut self, element: Element<'s>, within: fn(char) -> bool) -> Result<Value, Invalid> {
        let start = self.at;
        match element {
            Element::Scalar(scalar) => {
                let text = self.word(within).trim_end();
                let span = self.span.part(start..start + text.len());
                self.scalar(text, span, scalar)
            }
            Element::String { bound, .. } => {
                let text = if self.rest().starts_with(['"', '\'']) {
                    self.quoted()?
                } else {
                    self.unquoted(within)?
                };
                self.check_string(start..start + self.line[start..self.at].trim_end().len(), true);
                let length = text.chars().count();
                if bound.is_some_and(|bound| length > bound as usize) {
                    let span = self.span.part(start..self.at);
                    let type_name = format!("string<={}", bound.unwrap_or(0));
                    let problem = Problem::InvalidLiteral { text, type_name };
                    return Err(self.report_with(
                        problem,
                        span,
                        format!("the value has {length} characters"),
                    ));
                }
                Ok(Value::Text(text))
            }
            Element::Message { name, .. } => {
                let text = self.word(within).trim_end().to_owned();
                let span = self.span.part(start..start + text.len());
                let problem = Problem::InvalidLiteral { text, type_name: name.to_owned() };
                Err(self.report_with(problem, span, "a field of a message type cannot have a default value"))
            }
        }
    }

    /// Parses `[a, b, …]`.
    fn default_list(&mut self, element: Element<'s>, shape: Shape) -> Result<Value, Invalid> {
        let start = self.at;
        let mut values = Vec::new();
        if !self.rest().starts_with('[') {
            self.word(|c| c != '#');
            return Err(self.not_a_list(start, LIST_HINT));
        }
        self.at += 1;
        self.skip_spaces_in_list(start, "write `[]` for an empty list; rosidl rejects the spaces")?;
        while !self.rest().starts_with(']') {
            if self.is_at_end() {
                return Err(self.not_a_list(start, LIST_HINT));
            }
            if self.rest().starts_with(',') {
                self.at += 1;
                return Err(self.not_a_list(start, "write a value before each comma"));
            }
            values.push(self.default_value(element, |c| !matches!(c, '#' | ',' | ']'))?);
            self.skip_spaces();
            if self.rest().starts_with(',') {
                self.at += 1;
                // rosidl splits a list at each comma, except a list of strings.
                let is_string = matches!(element, Element::String { .. });
                if !(is_string && self.rest().starts_with(']')) {
                    self.skip_spaces_in_list(
                        start,
                        "remove the comma after the last element; rosidl rejects it",
                    )?;
                }
            } else if !self.rest().starts_with(']') {
                self.expect_end()?;
            }
        }
        self.at += 1;
        let found = values.len();
        let length = match shape {
            Shape::Array(length) if found != length as usize => length,
            Shape::Bounded(length) if found > length as usize => length,
            _ => {
                self.skip_spaces();
                return Ok(Value::List(values));
            }
        };
        let span = self.span.part(start..self.at);
        let problem = Problem::ArrayDefault { found, length: length as usize };
        Err(match shape {
            Shape::Bounded(_) => self.report_with(problem, span, format!("give at most {length}")),
            _ => self.report(problem, span),
        })
    }

    /// Skips the spaces before an element of the list at `start`. Fails if the list ends there.
    fn skip_spaces_in_list(&mut self, start: usize, hint: &str) -> Result<(), Invalid> {
        let before = self.at;
        self.skip_spaces();
        let is_empty = before == start + 1 && self.at == before;
        if is_empty || !self.rest().starts_with(']') {
            return Ok(());
        }
        self.at += 1;
        Err(self.not_a_list(start, hint))
    }

    /// Reports the text from `start` to the current position, which is not a list.
    fn not_a_list(&mut self, start: usize, hint: &str) -> Invalid {
        let text = self.line[start..self.at].trim_end().to_owned();
        let span = self.span.part(start..start + text.len());
        let problem = Problem::InvalidLiteral { text, type_name: "array".to_owned() };
        self.report_with(problem, span, hint)
    }
}
