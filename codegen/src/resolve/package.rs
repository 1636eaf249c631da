//! Packages of syntax trees.

use crate::msg::Kind;
use crate::msg::ast::Definition;
use crate::schema::Form;
use crate::span::Span;
use crate::table::Page;

/// A package before it is resolved.
#[derive(Debug)]
pub(crate) struct PackageSource<'s> {
    /// Its name.
    pub(crate) name: String,
    /// The form of its definitions.
    pub(crate) form: Form,
    /// The name that ROS knows it by, which type hashes contain.
    pub(crate) ros_package: String,
    /// Where its definitions come from.
    pub(crate) origin: Option<String>,
    /// Which state of the origin they follow.
    pub(crate) revision: Option<String>,
    /// Which messages are wanted, with what they refer to; all, where absent.
    pub(crate) select: Option<Vec<(String, Span)>>,
    /// Its `.msg` files and their relatives: file stem, kind, span, tree.
    pub(crate) files: Vec<(&'s str, Kind, Span, Definition<'s>)>,
    /// Its pages with tables.
    pub(crate) pages: Vec<Page>,
}
