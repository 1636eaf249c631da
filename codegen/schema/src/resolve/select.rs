//! The selection of messages.

use std::collections::BTreeSet;

use super::resolver::Resolver;
use crate::MessageId;
use crate::diagnostic::{Diagnostic, Problem};

impl Resolver<'_> {
    /// Limits each package to the selected messages and the messages that they refer to.
    pub(super) fn select(&mut self) {
        if self.selections.iter().all(Option::is_none) {
            return;
        }
        let mut open: Vec<MessageId> = Vec::new();
        for (index, selection) in std::mem::take(&mut self.selections).into_iter().enumerate() {
            let package = &mut self.schema.packages[index];
            let Some(selection) = selection else {
                open.extend(package.all_messages());
                continue;
            };
            let is_selected = |name: &str| selection.iter().any(|(selected, _)| selected == name);
            package.interfaces.retain(|interface| is_selected(&interface.name));
            open.extend(package.interfaces.iter().flat_map(|interface| &interface.parts));
            let messages = &self.schema.messages;
            open.extend(package.messages.iter().filter(|id| is_selected(&messages[id.0 as usize].name)));
            for (name, span) in &selection {
                let is_message = package.messages.iter().any(|id| messages[id.0 as usize].name == *name);
                if !is_message && !package.interfaces.iter().any(|interface| interface.name == *name) {
                    let problem = Problem::UnknownType { name: name.clone(), package: package.name.clone() };
                    self.diagnostics.push(Diagnostic::new(problem, *span));
                }
            }
        }
        let mut selected: BTreeSet<MessageId> = BTreeSet::new();
        while let Some(id) = open.pop() {
            if selected.insert(id) {
                let message = self.schema.message(id);
                open.extend(message.nested());
                open.extend(message.fields.iter().filter_map(|field| Some(field.enumeration?.message)));
            }
        }
        for package in &mut self.schema.packages {
            package.messages.retain(|id| selected.contains(id));
        }
    }
}
