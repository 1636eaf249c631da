//! The sequence numbers of the messages on a topic. Gaps reveal losses.

use std::collections::HashMap;

use super::attachment::Attachment;

/// The maximum number of publishers per topic whose sequence numbers are followed.
const MAX_PUBLISHERS: usize = 256;

/// The way in which a message arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Delivery {
    /// Directly after it was published.
    Live,
    /// As a reply to a query for stored messages.
    Stored,
}

/// The sequence numbers of all publishers on a topic.
#[derive(Default)]
pub(super) struct Sequences(HashMap<[u8; 16], Sequence>);

/// The sequence numbers that have arrived from a publisher.
#[derive(Default)]
struct Sequence {
    /// The highest number of a live message.
    live: Option<i64>,
    /// The highest number of a stored message.
    stored: Option<i64>,
}

impl Sequences {
    /// Returns the number of messages that are missing before this one. Returns `None` if this message has already
    /// arrived, or is older than live messages.
    pub(super) fn observe(&mut self, attachment: &Attachment, delivery: Delivery) -> Option<u64> {
        // Real topics have few publishers. If a peer invents more, the only effect is that gaps are forgotten.
        if self.0.len() >= MAX_PUBLISHERS && !self.0.contains_key(&attachment.publisher) {
            self.0.clear();
        }
        let sequence = self.0.entry(attachment.publisher).or_default();
        match delivery {
            Delivery::Live => sequence.live(attachment.sequence),
            Delivery::Stored => sequence.stored(attachment.sequence),
        }
    }
}

impl Sequence {
    /// Observes a live message. Only live messages reveal gaps, because a publisher stores only its latest messages.
    fn live(&mut self, number: i64) -> Option<u64> {
        let Some(highest) = self.live else {
            self.live = Some(number);
            let is_known = self.stored.is_some_and(|stored| number <= stored);
            return (!is_known).then_some(0);
        };
        self.live = Some(highest.max(number));
        let step = number.checked_sub(highest).and_then(|step| u64::try_from(step).ok());
        Some(step.unwrap_or_default().saturating_sub(1))
    }

    /// Observes a stored message. It counts as new if it is newer than the other stored messages, and no live message
    /// has arrived yet; otherwise, it would be out of order.
    fn stored(&mut self, number: i64) -> Option<u64> {
        if self.live.is_some() || self.stored.is_some_and(|stored| number <= stored) {
            return None;
        }
        self.stored = Some(number);
        Some(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn observe(sequences: &mut Sequences, publisher: u8, sequence: i64, delivery: Delivery) -> Option<u64> {
        sequences.observe(&Attachment { sequence, time: 0, publisher: [publisher; 16] }, delivery)
    }

    #[test]
    fn counts_gaps_of_each_publisher() {
        let mut sequences = Sequences::default();
        let mut live = |publisher, number| observe(&mut sequences, publisher, number, Delivery::Live);
        assert_eq!(live(1, 10), Some(0));
        assert_eq!(live(2, 1), Some(0));
        assert_eq!(live(1, 11), Some(0));
        assert_eq!(live(1, 15), Some(3));
        assert_eq!(live(1, 12), Some(0));
        assert_eq!(live(1, 16), Some(0));
        assert_eq!(live(2, 2), Some(0));
    }

    #[test]
    fn keeps_messages_of_publishers_that_never_count() {
        let mut sequences = Sequences::default();
        for _ in 0..3 {
            assert_eq!(observe(&mut sequences, 1, 0, Delivery::Live), Some(0));
        }
    }

    #[test]
    fn stored_messages_show_no_gaps_and_arrive_once() {
        let mut sequences = Sequences::default();
        assert_eq!(observe(&mut sequences, 1, 5, Delivery::Stored), Some(0));
        assert_eq!(observe(&mut sequences, 1, 5, Delivery::Stored), None);
        assert_eq!(observe(&mut sequences, 1, 5, Delivery::Live), None);
        assert_eq!(observe(&mut sequences, 1, 6, Delivery::Live), Some(0));
        assert_eq!(observe(&mut sequences, 1, 6, Delivery::Stored), None);
        assert_eq!(observe(&mut sequences, 3, 8, Delivery::Live), Some(0));
        assert_eq!(observe(&mut sequences, 3, 7, Delivery::Stored), None);
        assert_eq!(observe(&mut sequences, 2, 9, Delivery::Stored), Some(0));
        assert_eq!(observe(&mut sequences, 2, 12, Delivery::Live), Some(0));
    }

    #[test]
    fn extreme_numbers_never_panic() {
        let mut sequences = Sequences::default();
        for number in [i64::MIN, i64::MAX, 0, i64::MAX, i64::MIN] {
            for delivery in [Delivery::Live, Delivery::Stored] {
                observe(&mut sequences, 1, number, delivery);
            }
        }
        for publisher in 0..=u8::MAX {
            observe(&mut sequences, publisher, 1, Delivery::Live);
        }
        assert!(sequences.0.len() <= MAX_PUBLISHERS);
    }
}
