//! The text of messages without findings, used as templates for later messages on the same channels.

use uavspec_px4::json::{Clean, Plans, Template};

use super::envelope::Open;

/// The maximum number of templates.
const MAX_TEMPLATES: usize = 64;

/// The maximum length of a template's text, in bytes.
const MAX_TEXT: usize = 64 * 1024;

/// The number of consecutive misses after which no more templates are created. This many misses suggest that the form
/// of the messages varies, for example because the producer numbers the messages.
const MAX_MISSES: usize = 256;

/// The templates of a capture.
#[derive(Debug, Default)]
pub(super) struct Templates {
    known: Vec<Known>,
    /// The index of the template that matched last.
    last: usize,
    /// The number of consecutive misses.
    misses: usize,
}

#[derive(Debug)]
struct Known {
    channel: usize,
    template: Template,
    /// The index of the template that most recently matched directly after this template.
    next: usize,
}

impl Templates {
    /// Creates a set that never learns templates.
    pub(super) fn disabled() -> Self {
        Self { misses: usize::MAX, ..Self::default() }
    }

    /// Matches a message against the templates. Returns the channel and the message's contribution to the result.
    /// Stores the field values in `values` if the channel needs them.
    pub(super) fn read(
        &mut self,
        text: &str,
        plans: &Plans<'_>,
        values: &mut Vec<u8>,
    ) -> Option<(usize, Clean)> {
        // Messages on topics with fixed rates arrive in a repeating order.
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

    /// Learns the form of a message without findings.
    pub(super) fn learn(&mut self, text: &str, open: &Open, channel: usize, plans: &Plans<'_>) {
        if self.known.len() == MAX_TEMPLATES || text.len() > MAX_TEXT || self.misses > MAX_MISSES {
            return;
        }
        let template =
            open.defined.and_then(|(id, _)| Template::new(plans, id, text, open.key, open.num_bytes));
        let next = self.known.len();
        self.known.extend(template.map(|template| Known { channel, template, next }));
    }
}
