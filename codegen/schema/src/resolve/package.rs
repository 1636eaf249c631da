//! Parsed packages.

use crate::Form;
use crate::msg::Kind;
use crate::msg::ast::Definition;
use crate::span::Span;
use crate::table::Page;

/// A package before it is resolved.
#[derive(Debug)]
pub struct PackageSource<'s> {
    /// The name.
    pub(crate) name: String,
    /// The form of the definitions.
    pub form: Form,
    /// The name of the ROS package, as used in type hashes.
    pub(crate) ros_package: String,
    /// The origin of the definitions.
    pub(crate) origin: Option<String>,
    /// The revision of the origin.
    pub(crate) revision: Option<String>,
    /// The selected messages, to which the resolver adds all messages they refer to. `None` selects all.
    pub select: Option<Vec<(String, Span)>>,
    /// The `.msg`, `.srv` and `.action` files: file stem, kind, span, tree.
    pub files: Vec<(&'s str, Kind, Span, Definition<'s>)>,
    /// The pages.
    pub pages: Vec<Page>,
}
