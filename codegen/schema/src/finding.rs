//! Rule violations in definitions, for both `lint` and `breaking`.
//!
//! A [`Diagnostic`] reports a definition that can't be read as intended; a finding may also concern style.
//! [`render`](crate::render) formats findings for people, the crate `uavspec-lint` for programs.
//!
//! ```
//! use uavspec_schema::{diagnostic::Level, finding::Finding, source::Span};
//!
//! let mut finding = Finding::new("unit-missing", Level::Warning, Span::default(), "`speed` has no unit");
//! finding.help("write `[m/s]`");
//! assert!(finding.fix.is_empty());
//! ```

use crate::diagnostic::{Diagnostic, Level};
use crate::span::Span;

/// A finding of a rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The id of the rule.
    pub rule: &'static str,
    /// The affected category, if two versions were compared.
    pub category: Option<&'static str>,
    /// The severity.
    pub level: Level,
    /// The problem.
    pub message: String,
    /// The advice or the consequence.
    pub help: String,
    /// The location of the finding. In a comparison, this is the location in the new version or, if the item was
    /// removed, the location of the enclosing item.
    pub span: Span,
    /// The locations in the old and the new version, if two versions were compared.
    pub sides: Option<Sides>,
    /// Other relevant locations, each with a label.
    pub related: Vec<(Span, String)>,
    /// The automatic fix; empty if there is none.
    pub fix: Vec<Edit>,
}

/// The locations of an item in the two versions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// The location in the old version.
    pub old: Option<Span>,
    /// The location in the new version.
    pub new: Option<Span>,
}

/// A change to a source.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edit {
    /// The span to replace. If the span is empty, the new text is inserted.
    pub span: Span,
    /// The new text.
    pub text: String,
}

impl Finding {
    /// Creates a finding that has only the required fields.
    pub fn new(rule: &'static str, level: Level, span: Span, message: impl Into<String>) -> Self {
        Self {
            rule,
            category: None,
            level,
            message: message.into(),
            help: String::new(),
            span,
            sides: None,
            related: Vec::new(),
            fix: Vec::new(),
        }
    }

    /// True if `other` concerns the same change. The findings of a comparison differ only in category.
    pub fn is_same_change(&self, other: &Self) -> bool {
        (self.rule, self.span, &self.message) == (other.rule, other.span, &other.message)
            && self.category.is_some()
    }

    /// Sets the advice.
    pub fn help(&mut self, help: impl Into<String>) -> &mut Self {
        self.help = help.into();
        self
    }

    /// Adds another location with a label.
    pub fn relate(&mut self, span: Span, label: impl Into<String>) -> &mut Self {
        self.related.push((span, label.into()));
        self
    }

    /// Adds an edit to the automatic fix.
    pub fn edit(&mut self, span: Span, text: impl Into<String>) -> &mut Self {
        self.fix.push(Edit { span, text: text.into() });
        self
    }
}

impl From<&Diagnostic> for Finding {
    fn from(diagnostic: &Diagnostic) -> Self {
        let problem = &diagnostic.problem;
        let finding = Self::new(problem.code(), problem.level(), diagnostic.span, problem.to_string());
        Self { help: diagnostic.hint(), related: diagnostic.related.clone(), ..finding }
    }
}
