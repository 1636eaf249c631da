//! Computes layouts and sizes, and checks their limits.

use super::resolver::Resolver;
use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::{MAX_MESSAGE_SIZE, MAX_NESTED_FIELDS, MAX_NESTED_FIELDS_IN_ALL, MAX_NESTING};
use crate::msg::ast;
use crate::{Element, MessageId, layout};

impl Resolver<'_> {
    /// Computes layouts and sizes, and checks their limits.
    pub(super) fn measure(&mut self, order: &[MessageId]) {
        let sizes = layout::cdr(&self.schema, order);
        let mut nested_fields: Vec<u64> = vec![0; self.schema.messages.len()];
        let mut depths: Vec<u64> = vec![0; self.schema.messages.len()];
        let mut in_all = 0_u64;
        let mut is_too_large = vec![false; self.schema.messages.len()];
        for id in order {
            let index = id.0 as usize;
            let message = &self.schema.messages[index];
            nested_fields[index] = message.fields.len() as u64;
            for nested in message.nested() {
                depths[index] = depths[index].max(depths[nested.0 as usize] + 1);
                nested_fields[index] = nested_fields[index].saturating_add(nested_fields[nested.0 as usize]);
            }
            let uorb = layout::uorb(&self.schema, message);
            let size = uorb.as_ref().map_or(0, |layout| layout.size as u64).max(sizes[index].min);
            // Report only the nested message, not the messages that contain it.
            is_too_large[index] = message.nested().any(|nested| is_too_large[nested.0 as usize]);
            if !is_too_large[index] {
                let was_over = in_all > MAX_NESTED_FIELDS_IN_ALL;
                in_all = in_all.saturating_add(nested_fields[index]);
                let exceeds_all = !was_over && in_all > MAX_NESTED_FIELDS_IN_ALL;
                is_too_large[index] = self.is_too_deep(index, depths[index])
                    || !self.fits(index, size, nested_fields[index], exceeds_all);
            }
            let message = &mut self.schema.messages[index];
            message.uorb = uorb;
            message.cdr = sizes[index];
        }
    }

    /// True if messages are nested too deeply in a message. Reports the message in this case.
    fn is_too_deep(&mut self, index: usize, depth: u64) -> bool {
        let message = &self.schema.messages[index];
        if depth <= MAX_NESTING {
            return false;
        }
        let nested = message.fields.iter().find(|field| matches!(field.ty.element, Element::Message(_)));
        let span = nested.map_or(message.span.part(0..0), |field| field.span);
        let name = message.name.clone();
        self.report(Diagnostic::new(
            Problem::TooMuchNesting { name, max: MAX_NESTING, what: "levels of nested messages" },
            span,
        ));
        true
    }

    /// True if a message is within all other limits. Reports the first exceeded limit.
    fn fits(&mut self, index: usize, size: u64, nested_fields: u64, exceeds_all: bool) -> bool {
        let message = &self.schema.messages[index];
        let name = message.name.clone();
        let problem = if size > MAX_MESSAGE_SIZE {
            Problem::TooLarge { what: format!("the message `{name}`"), max: MAX_MESSAGE_SIZE }
        } else if nested_fields > MAX_NESTED_FIELDS {
            Problem::TooManyFields { name, max: MAX_NESTED_FIELDS }
        } else if exceeds_all {
            Problem::TooMuchNesting {
                name,
                max: MAX_NESTED_FIELDS_IN_ALL,
                what: "fields in all messages, including nested fields",
            }
        } else {
            return true;
        };
        let largest = message.fields.iter().max_by_key(|field| match field.ty.shape {
            ast::Shape::Array(length) => length,
            _ => 1,
        });
        let span = largest.map_or(message.span.part(0..0), |field| field.span);
        self.report(Diagnostic::new(problem, span));
        false
    }
}
