//! Syntax trees to model: names become references, and all that is wrong across lines and files is
//! found. The only place that knows both sides.

mod declare;
mod enums;
mod error_codes;
mod gather;
mod json_type;
mod lower;
mod measure;
mod order;
mod package;
mod pages;
mod reference;
mod resolver;
mod select;

pub(crate) use self::lower::default_topic;
pub(crate) use self::package::PackageSource;
use self::resolver::Resolver;
use crate::diagnostic::{Diagnostic, has_errors};
use crate::schema::Schema;

/// Resolves all packages together, which are sorted by name. Where an error is among the diagnostics, the
/// schema is not complete, and nothing should be generated from it.
pub(crate) fn resolve(packages: &[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>) {
    let mut resolver = Resolver::default();
    resolver.declare(packages);
    resolver.lower(packages);
    resolver.tables(packages);
    let order = resolver.order();
    resolver.enums();
    resolver.measure(&order);
    resolver.schema.nested_first = order;
    if !has_errors(&resolver.diagnostics) {
        resolver.fingerprints();
    }
    resolver.select();
    (resolver.schema, resolver.diagnostics)
}
