//! How clean messages were written, channel by channel.

use super::envelope::Open;
use crate::px4::json::{Clean, Plans, Template};

/// Most templates that are kept.
const MAX_TEMPLATES: usize = 64;

/// The longest text that a template is made of, in bytes.
const MAX_TEXT: usize = 64 * 1024;

/// How often in a row no template may fit before making more is given up: then each message is written in a way of
/// its own, as by a producer that counts them.
const MAX_MISSES: usize = 256;

/// The templates of a source.
#[derive(Debug, Default)]
pub(super) struct Templates {
    known: Vec<Known>,
    /// The one that fitted last.
    last: usize,
    /// How often in a row none fitted.
    misses: usize,
}

#[derive(Debug)]
struct Known {
    channel: usize,
    template: Template,
    /// The one that fitted after it.
    next: usize,
}

impl Templates {
    /// Templates that never learn one.
    pub(super) fn none() -> Self {
        Self { misses: usize::MAX, ..Self::default() }
    }

    /// The channel of a message that is written as one before it, and what it says of itself. `values` gets what it
    /// says, where its channel wants that.
    pub(super) fn read(&mut self, text: &str, plans: &Plans, values: &mut Vec<u8>) -> Option<(usize, Clean)> {
        // Topics that come regularly come in the same order.
        let guess = self.known.get(self.last)?.next;
        let others = (0..self.known.len()).filter(|at| *at != guess);
        for at in std::iter::once(guess).chain(others) {
            let known = &mut self.known[at];
            if let Some(clean) = known.template.read(plans, text) {
                values.clear();
                values.extend_from_slice(known.template.values());
                let channel = known.channel;
                self.known[self.last].next = at;
                (self.last, self.misses) = (at, 0);
                return Some((channel, clean));
            }
        }
        self.misses += 1;
        None
    }

    /// Learns how a clean message of a channel is written.
    pub(super) fn learn(&mut self, text: &str, open: &Open, channel: usize, plans: &Plans) {
        if self.known.len() == MAX_TEMPLATES || text.len() > MAX_TEXT || self.misses > MAX_MISSES {
            return;
        }
        let template =
            open.defined.and_then(|(id, _)| Template::new(plans, id, text, open.key, open.num_bytes));
        let next = self.known.len();
        self.known.extend(template.map(|template| Known { channel, template, next }));
    }
}
