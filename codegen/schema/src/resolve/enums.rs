//! Finds the constants of enum fields.

use uavspec_runtime::Scalar;

use super::gather::by_prefix;
use super::resolver::{PendingEnum, Resolver, id};
use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::MAX_MEMBERS;
use crate::msg::statement::Prefix;
use crate::source::Span;
use crate::{Element, EnumRef, MessageId};

impl<'s> Resolver<'s> {
    /// The message that defines the constants: the current message, or the message named in the prefix.
    pub(super) fn enum_owner(
        &mut self,
        index: usize,
        prefixes: &[Prefix<'s>],
        span: Span,
    ) -> Option<MessageId> {
        match prefixes.iter().find_map(|prefix| prefix.message) {
            Some(message) => self.reference(index, None, message, span),
            None => Some(id(index)),
        }
    }

    pub(super) fn enums(&mut self) {
        for pending in std::mem::take(&mut self.pending) {
            self.enumeration(&pending);
        }
    }

    fn enumeration(&mut self, pending: &PendingEnum) {
        let field = &self.schema.messages[pending.message].fields[pending.field];
        let scalar = match field.ty.written().element {
            Element::Scalar(scalar) if scalar.integer_bounds().is_some() => scalar,
            element => {
                let type_name = match element {
                    Element::Scalar(scalar) => scalar.name(),
                    Element::Text(_) | Element::String { .. } => "string",
                    Element::Message(_) => "message",
                };
                let problem = Problem::EnumOnNonInteger { type_name: type_name.to_owned() };
                self.report(Diagnostic::new(problem, pending.span));
                return;
            }
        };
        let key = (pending.owner, pending.prefixes.clone(), scalar, pending.is_flags);
        let reference = match self.gathered.get(&key) {
            Some(known) => *known,
            None => self.gather(pending, scalar),
        };
        self.gathered.insert(key, reference);
        self.schema.messages[pending.message].fields[pending.field].enumeration = reference;
    }

    /// Creates a new enum, or returns `None` if it would have no members.
    fn gather(&mut self, pending: &PendingEnum, scalar: Scalar) -> Option<EnumRef> {
        let owner = self.schema.message(pending.owner);
        let by_prefix = self
            .by_prefix
            .entry(pending.owner)
            .or_insert_with(|| by_prefix(owner, &self.claimed[pending.owner.0 as usize]));
        for prefix in &pending.prefixes {
            if !by_prefix.is_used(prefix) {
                let problem = Problem::UnknownEnum { prefix: prefix.clone(), place: owner.name.clone() };
                self.diagnostics.push(Diagnostic::new(problem, pending.span));
            }
        }
        self.members += pending.prefixes.iter().map(|prefix| by_prefix.count(prefix)).sum::<usize>();
        if self.members > MAX_MEMBERS {
            let problem = Problem::TooManyMembers { max: MAX_MEMBERS };
            self.diagnostics.push(Diagnostic::new(problem, pending.span));
            return None;
        }
        let candidate = by_prefix.gather(owner, &pending.prefixes, scalar, pending.is_flags);
        for (constant, value) in candidate.out_of_range {
            let constant = &owner.constants[constant];
            let problem = Problem::EnumValueOutOfRange {
                constant: constant.name.clone(),
                value: value.to_string(),
                type_name: scalar.name().to_owned(),
            };
            let diagnostic = Diagnostic::new(problem, pending.span);
            self.diagnostics.push(diagnostic.with_related(constant.span, "the constant"));
        }
        if candidate.found.members.is_empty() {
            return None;
        }
        let enums = &mut self.schema.messages[pending.owner.0 as usize].enums;
        enums.push(candidate.found);
        Some(EnumRef { message: pending.owner, index: enums.len() - 1 })
    }
}
