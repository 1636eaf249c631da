//! The messages of a subscribed topic, which are delivered by Zenoh's threads.

use std::mem;
use std::sync::{Arc, Mutex, PoisonError};

use uavspec_model::clock::Clock;
use zenoh::sample::{Sample, SampleKind};

use super::attachment::Attachment;
use super::sequence::{Delivery, Sequences};
use crate::bus::queue::Sender;
use crate::bus::{Encoding, Event, Received, Topic, nanoseconds};

/// The receiving end of a subscription.
pub(super) struct Intake {
    topic: Topic,
    sender: Sender,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    sequences: Sequences,
    /// True if messages without a valid attachment have been reported.
    is_reported: bool,
}

impl Intake {
    pub(super) fn new(topic: Topic, sender: Sender) -> Self {
        Self { topic, sender, state: Mutex::default() }
    }

    /// Adds a message and its losses to the queue.
    pub(super) fn accept(&self, sample: &Sample, delivery: Delivery) {
        if sample.kind() != SampleKind::Put {
            return;
        }
        // The state stays locked until the message is in the queue, so that no other thread can overtake this one.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match sample.attachment().and_then(|bytes| Attachment::parse(&bytes.to_bytes())) {
            Some(attachment) => match state.sequences.observe(&attachment, delivery) {
                None => return,
                Some(0) => {}
                Some(count) => self.lost(count),
            },
            None if mem::replace(&mut state.is_reported, true) => {}
            None => self.report_attachment(),
        }
        let (time, payload) = (nanoseconds(&Clock::real()), sample.payload().to_bytes().into_owned());
        self.sender.send(Event::Message(Received::new(self.topic.clone(), Encoding::Cdr, time, payload)));
    }

    fn lost(&self, count: u64) {
        self.sender.send(Event::Lost { topic: Arc::clone(&self.topic.name), count });
    }

    fn report_attachment(&self) {
        let name = self.topic.name.escape_debug();
        self.sender.send(Event::Problem(format!(
            "{name}: found a message whose attachment lacks its number, time and publisher; rmw_zenoh ignores it"
        )));
    }
}
