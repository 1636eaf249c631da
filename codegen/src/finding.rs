//! What rules find in definitions: the form that `lint` and `breaking` share.
//!
//! A [`Diagnostic`] says what keeps a text from being read as the specification says; a finding may also be
//! a matter of care. [`render`](crate::render) shows them to people,
//! [`report`](crate::report) hands them to programs.
//!
//! ```
//! use uavspec_codegen::{diagnostic::Level, finding::Finding, source::Span};
//!
//! let mut finding = Finding::new("unit-missing", Level::Warning, Span::default(), "`speed` has no unit");
//! finding.help("write `[m/s]`");
//! assert!(finding.fix.is_empty());
//! ```

use crate::diagnostic::{Diagnostic, Level};
use crate::span::Span;

/// Something that a rule found at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The id of the rule.
    pub rule: &'static str,
    /// Whom it breaks, where two sets of definitions were compared.
    pub category: Option<&'static str>,
    /// How grave it is.
    pub level: Level,
    /// What is the matter.
    pub message: String,
    /// What to do about it, or what comes of it.
    pub help: String,
    /// Where. Where two sets of definitions were compared: the place in the new one, or of that which
    /// held it.
    pub span: Span,
    /// The two places that were compared.
    pub sides: Option<Sides>,
    /// Other places that have to do with it, each with a word on how.
    pub related: Vec<(Span, String)>,
    /// How to mend it without a doubt; empty where that takes a person.
    pub fix: Vec<Edit>,
}

/// The places of something in two sets of definitions, in each where it is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// In the old set.
    pub old: Option<Span>,
    /// In the new set.
    pub new: Option<Span>,
}

/// A change of a source.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Edit {
    /// What is replaced; an empty span is a place to insert at.
    pub span: Span,
    /// What comes in its place.
    pub text: String,
}

impl Finding {
    /// A finding without anything that only some have.
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

    /// Says what to do about it.
    pub fn help(&mut self, help: impl Into<String>) -> &mut Self {
        self.help = help.into();
        self
    }

    /// Adds another place that has to do with it.
    pub fn relate(&mut self, span: Span, label: impl Into<String>) -> &mut Self {
        self.related.push((span, label.into()));
        self
    }

    /// Adds a change that mends it.
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
