//! Sorts messages so that nested messages come first, and detects messages that contain themselves.

use super::resolver::{Resolver, id};
use crate::diagnostic::{Diagnostic, Problem};
use crate::{Element, Field, MessageId};

/// The number of names at each end of a displayed path; the middle of longer paths is omitted.
const MAX_CYCLE_END: usize = 8;

impl Resolver<'_> {
    /// All messages. Each message follows the messages that it contains. Messages that contain themselves are reported
    /// and omitted.
    pub(super) fn order(&mut self) -> Vec<MessageId> {
        let count = self.schema.messages.len();
        let mut missing: Vec<usize> = vec![0; count];
        let mut holders: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (index, message) in self.schema.messages.iter().enumerate() {
            for nested in message.nested() {
                missing[index] += 1;
                holders[nested.0 as usize].push(index);
            }
        }
        let mut ready: Vec<usize> = (0..count).filter(|index| missing[*index] == 0).collect();
        let mut order = Vec::with_capacity(count);
        while let Some(index) = ready.pop() {
            order.push(id(index));
            for holder in &holders[index] {
                missing[*holder] -= 1;
                if missing[*holder] == 0 {
                    ready.push(*holder);
                }
            }
        }
        self.report_cycles(&missing);
        order
    }

    /// Reports each cycle once. For each message, `missing` is the number of nested messages without a position in the
    /// order. If this number is not 0, following nested messages without a position always leads to a cycle.
    fn report_cycles(&mut self, missing: &[usize]) {
        let mut is_done = vec![false; missing.len()];
        for start in 0..missing.len() {
            let mut path: Vec<usize> = Vec::new();
            let mut at = start;
            while missing[at] > 0 && !is_done[at] {
                is_done[at] = true;
                path.push(at);
                let next =
                    self.schema.messages[at].nested().map(|id| id.0 as usize).find(|next| missing[*next] > 0);
                let Some(next) = next else { break };
                at = next;
            }
            if let Some(first) = path.iter().position(|index| *index == at).filter(|_| missing[at] > 0) {
                self.report_cycle(&path[first..]);
            }
        }
    }

    fn report_cycle(&mut self, cycle: &[usize]) {
        let messages = &self.schema.messages;
        let closing = |from: usize, to: usize| {
            let holds = |field: &&Field| field.ty.element == Element::Message(id(to));
            messages[from].fields.iter().find(holds).map(|field| field.span)
        };
        let names: Vec<&str> =
            cycle.iter().chain(&cycle[..1]).map(|index| messages[*index].name.as_str()).collect();
        let mut steps = (0..cycle.len()).filter_map(|at| closing(cycle[at], cycle[(at + 1) % cycle.len()]));
        let Some(span) = steps.next() else { return };
        let mut path = names.clone();
        if path.len() > 2 * MAX_CYCLE_END {
            path.splice(MAX_CYCLE_END..path.len() - MAX_CYCLE_END, ["…"]);
        }
        let mut diagnostic = Diagnostic::new(Problem::Cycle { path: path.join(" → ") }, span);
        for (span, name) in steps.zip(&names[2..]).take(MAX_CYCLE_END) {
            diagnostic = diagnostic.with_related(span, format!("contains `{name}`"));
        }
        self.report(diagnostic);
    }
}
