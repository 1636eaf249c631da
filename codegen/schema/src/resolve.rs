//! Converts syntax trees to the model. Resolves names, and reports errors that concern several lines or files. Only
//! this module uses both the syntax tree and the model.

mod declare;
mod enums;
mod error_codes;
mod events;
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

pub use self::error_codes::code_references;
pub use self::lower::default_topic;
pub use self::package::PackageSource;
use self::resolver::Resolver;
use crate::Schema;
use crate::diagnostic::{Diagnostic, has_errors};
use crate::fingerprint::add_hashes;

/// Resolves all packages together. The packages must be sorted by name. If the diagnostics contain an error, the schema
/// is incomplete, and no output should be generated from it.
pub fn resolve(packages: &[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>) {
    let mut resolver = resolve_without_hashes(packages);
    if !has_errors(&resolver.diagnostics) {
        add_hashes(&mut resolver.schema, |_, _| None);
    }
    resolver.select();
    (resolver.schema, resolver.diagnostics)
}

/// Like [`resolve`], but without the hashes of messages and types. For hostile input, computing the hashes takes much
/// longer than everything else.
pub fn resolve_formats(packages: &[PackageSource<'_>]) -> (Schema, Vec<Diagnostic>) {
    let mut resolver = resolve_without_hashes(packages);
    resolver.select();
    (resolver.schema, resolver.diagnostics)
}

fn resolve_without_hashes<'s>(packages: &[PackageSource<'s>]) -> Resolver<'s> {
    let mut resolver = Resolver::default();
    resolver.declare(packages);
    resolver.lower(packages);
    resolver.tables(packages);
    resolver.events(packages);
    let order = resolver.order();
    resolver.enums();
    resolver.measure(&order);
    resolver.schema.topological_order = order;
    resolver
}
