//! Which constants the fields that are annotated with an enum hold.

use uavspec_runtime::Scalar;

use super::gather::by_prefix;
use super::resolver::{PendingEnum, Resolver, id};
use crate::diagnostic::{Diagnostic, Problem};
use crate::msg::statement::Prefix;
use crate::schema::{Element, EnumRef, MessageId};
use crate::source::Span;

/// Most members that all enums of a run may have together.
const MAX_MEMBERS: usize = 1 << 20;

impl<'s> Resolver<'s> {
    /// The message whose constants are meant: this one, or the one that the prefix names.
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
        for wanted in std::mem::take(&mut self.pending) {
            self.enumeration(&wanted);
        }
    }

    fn enumeration(&mut self, wanted: &PendingEnum) {
        let field = &self.schema.messages[wanted.message].fields[wanted.field];
        let scalar = match field.ty.element {
            Element::Scalar(scalar) if scalar.integer_bounds().is_some() => scalar,
            element => {
                let type_name = match element {
                    Element::Scalar(scalar) => scalar.name(),
                    Element::String { .. } => "string",
                    Element::Message(_) => "message",
                };
                let problem = Problem::EnumOnNonInteger { type_name: type_name.to_owned() };
                self.report(Diagnostic::new(problem, wanted.span));
                return;
            }
        };
        let key = (wanted.owner, wanted.prefixes.clone(), scalar, wanted.is_flags);
        let reference = match self.gathered.get(&key) {
            Some(known) => *known,
            None => self.gather(wanted, scalar),
        };
        self.gathered.insert(key, reference);
        self.schema.messages[wanted.message].fields[wanted.field].enumeration = reference;
    }

    /// Gathers an enum that no field has asked for before; none where it has no members.
    fn gather(&mut self, wanted: &PendingEnum, scalar: Scalar) -> Option<EnumRef> {
        let owner = self.schema.message(wanted.owner);
        let by_prefix = self
            .by_prefix
            .entry(wanted.owner)
            .or_insert_with(|| by_prefix(owner, &self.claimed[wanted.owner.0 as usize]));
        for prefix in &wanted.prefixes {
            if !by_prefix.is_used(prefix) {
                let problem = Problem::UnknownEnum { prefix: prefix.clone(), place: owner.name.clone() };
                self.diagnostics.push(Diagnostic::new(problem, wanted.span));
            }
        }
        self.members += wanted.prefixes.iter().map(|prefix| by_prefix.count(prefix)).sum::<usize>();
        if self.members > MAX_MEMBERS {
            let problem = Problem::TooManyMembers { max: MAX_MEMBERS };
            self.diagnostics.push(Diagnostic::new(problem, wanted.span));
            return None;
        }
        let candidate = by_prefix.gather(owner, &wanted.prefixes, scalar, wanted.is_flags);
        for (constant, value) in candidate.out_of_range {
            let constant = &owner.constants[constant];
            let problem = Problem::EnumValueOutOfRange {
                constant: constant.name.clone(),
                value: value.to_string(),
                type_name: scalar.name().to_owned(),
            };
            let diagnostic = Diagnostic::new(problem, wanted.span);
            self.diagnostics.push(diagnostic.with_related(constant.span, "the constant"));
        }
        if candidate.found.members.is_empty() {
            return None;
        }
        let enums = &mut self.schema.messages[wanted.owner.0 as usize].enums;
        enums.push(candidate.found);
        Some(EnumRef { message: wanted.owner, index: enums.len() - 1 })
    }
}
