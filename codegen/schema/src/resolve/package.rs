//! Parsed packages.

use crate::event::file::EventFile;
use crate::msg::Kind;
use crate::msg::ast::Definition;
use crate::read::PackageInput;
use crate::span::Span;
use crate::table::Page;

/// A package before it is resolved.
#[derive(Debug)]
pub struct PackageSource<'s> {
    /// The package.
    pub input: &'s PackageInput,
    /// The `.msg`, `.srv` and `.action` files: file stem, kind, span, tree.
    pub files: Vec<(&'s str, Kind, Span, Definition<'s>)>,
    /// The pages.
    pub pages: Vec<Page>,
    /// The files with event metadata.
    pub events: Vec<EventFile>,
}
