//! The queue between the threads of a transport and the thread that reads its events.

use std::collections::{BTreeMap, VecDeque};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use uavspec_model::clock::Clock;

use super::Event;

/// The maximum number of waiting events.
const MAX_EVENTS: usize = 1 << 14;

/// The maximum total size of the waiting payloads, in bytes.
const MAX_BYTES: usize = 256 << 20;

/// The numbers of messages that were lost because the queue had no space, by topic.
type Losses = BTreeMap<Arc<str>, u64>;

/// An event in the queue.
#[derive(Debug)]
struct Waiting {
    event: Event,
    /// The losses between the previous event and the current event.
    lost: Losses,
}

/// The losses since the last event in the queue, and the counts of waiting messages.
#[derive(Debug, Default)]
struct State {
    lost: Losses,
    /// The number of waiting messages.
    messages: usize,
    /// The size of the waiting payloads.
    bytes: usize,
}

impl State {
    /// True if there is space for a message. After a loss, the queue must first be half empty: if there were a loss
    /// between any two messages, the reader would be even slower.
    fn has_space(&self, size: usize) -> bool {
        let is_full = self.bytes + size > MAX_BYTES || self.messages >= MAX_EVENTS;
        let is_half_full = self.bytes > MAX_BYTES / 2 || self.messages > MAX_EVENTS / 2;
        !is_full && (self.lost.is_empty() || !is_half_full)
    }

    fn lose(&mut self, topic: Arc<str>) {
        *self.lost.entry(topic).or_default() += 1;
    }
}

/// The end of the queue that adds events, for the threads of a transport.
#[derive(Clone, Debug)]
pub(crate) struct Sender {
    events: SyncSender<Waiting>,
    state: Arc<Mutex<State>>,
}

/// The end of the queue that returns the events.
#[derive(Debug)]
pub(crate) struct Queue {
    events: Receiver<Waiting>,
    state: Arc<Mutex<State>>,
    /// Losses to return next, and the event that follows them.
    due: VecDeque<Event>,
}

/// Creates a queue.
pub(crate) fn queue() -> (Sender, Queue) {
    let (sender, events) = mpsc::sync_channel(MAX_EVENTS);
    let state = Arc::default();
    (Sender { events: sender, state: Arc::clone(&state) }, Queue { events, state, due: VecDeque::new() })
}

impl Sender {
    /// Adds an event. If there is no space, a message is dropped and counted as lost; for any other event, the thread
    /// waits. Returns false if the queue no longer has a reader.
    pub(crate) fn send(&self, event: Event) -> bool {
        let Event::Message(message) = &event else {
            return self.events.send(Waiting { event, lost: Losses::new() }).is_ok();
        };
        let (topic, size) = (Arc::clone(&message.topic.name), message.payload.len());
        // The state stays locked, so that no other message can get between the losses and the message that carries
        // them.
        let mut state = locked(&self.state);
        if !state.has_space(size) {
            state.lose(topic);
            return true;
        }
        let lost = std::mem::take(&mut state.lost);
        match self.events.try_send(Waiting { event, lost }) {
            Ok(()) => {
                state.bytes += size;
                state.messages += 1;
                true
            }
            Err(TrySendError::Full(refused)) => {
                state.lost = refused.lost;
                state.lose(topic);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

impl Queue {
    /// The next event, if there is one before the deadline. Losses are returned in the order in which they occurred.
    pub(crate) fn receive(&mut self, deadline: Instant) -> Option<Event> {
        if let Some(event) = self.due.pop_front() {
            return Some(event);
        }
        match Clock::real().receive(&self.events, deadline) {
            Ok(Waiting { event, lost }) => {
                if let Event::Message(message) = &event {
                    let mut state = locked(&self.state);
                    state.bytes -= message.payload.len();
                    state.messages -= 1;
                }
                self.due.extend(events(lost));
                self.due.push_back(event);
                self.due.pop_front()
            }
            // All events before these losses have been returned.
            Err(RecvTimeoutError::Timeout) => self.latest_loss(),
            Err(RecvTimeoutError::Disconnected) => {
                self.latest_loss().or_else(|| Some(Event::Closed("the connection ended".to_owned())))
            }
        }
    }

    fn latest_loss(&mut self) -> Option<Event> {
        self.due.extend(events(std::mem::take(&mut locked(&self.state).lost)));
        self.due.pop_front()
    }

    /// The losses and the unreadable data that haven't been returned yet. Drops the waiting messages, so the queue must
    /// not be used afterwards.
    pub(crate) fn remaining_losses(&mut self) -> Vec<Event> {
        let mut remaining = Losses::new();
        let mut add = |topic, count| *remaining.entry(topic).or_default() += count;
        let mut unreadable = Vec::new();
        let waiting: Vec<Waiting> = self.events.try_iter().take(MAX_EVENTS).collect();
        for Waiting { event, lost } in waiting {
            self.due.extend(events(lost));
            self.due.push_back(event);
        }
        self.due.extend(events(std::mem::take(&mut locked(&self.state).lost)));
        for event in self.due.drain(..) {
            match event {
                Event::Lost { topic, count } => add(topic, count),
                Event::Unreadable(_) => unreadable.push(event),
                _ => {}
            }
        }
        unreadable.into_iter().chain(events(remaining)).collect()
    }
}

fn events(lost: Losses) -> impl Iterator<Item = Event> {
    lost.into_iter().map(|(topic, count)| Event::Lost { topic, count })
}

fn locked(state: &Mutex<State>) -> MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::bus::{Encoding, Received, Topic};

    fn message(size: usize) -> Event {
        message_of("/wind", size)
    }

    fn message_of(topic: &str, size: usize) -> Event {
        let topic = Topic { name: topic.into(), type_name: "sky_msgs/msg/Wind".into(), type_hash: None };
        Event::Message(Received::new(topic, Encoding::Cdr, 1, vec![0; size]))
    }

    /// A queue without space.
    fn full() -> (Sender, Queue) {
        let (sender, queue) = queue();
        for _ in 0..MAX_EVENTS {
            assert!(sender.send(message(1)));
        }
        (sender, queue)
    }

    fn next(queue: &mut Queue) -> Option<Event> {
        queue.receive(Clock::real().now() + Duration::from_millis(1))
    }

    /// The topic and the number of messages of a loss.
    fn loss(event: Option<Event>) -> (String, u64) {
        match event {
            Some(Event::Lost { topic, count }) => (topic.to_string(), count),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn counts_messages_without_space() {
        let (sender, mut queue) = full();
        for _ in 0..3 {
            assert!(sender.send(message(1)));
        }
        let (mut messages, mut lost) = (0, 0);
        while let Some(event) = next(&mut queue) {
            match event {
                Event::Message(_) => messages += 1,
                Event::Lost { count, .. } => lost += count,
                other => panic!("{other:?}"),
            }
        }
        assert_eq!((messages, lost), (MAX_EVENTS, 3));
    }

    #[test]
    fn returns_losses_at_their_place() {
        let (sender, mut queue) = full();
        for topic in ["/wind", "/rain", "/wind"] {
            assert!(sender.send(message_of(topic, 1)));
        }
        for _ in 0..MAX_EVENTS / 2 {
            assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        }
        for _ in 0..2 {
            assert!(sender.send(message(1)));
        }
        for _ in MAX_EVENTS / 2..MAX_EVENTS {
            assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        }
        assert_eq!(loss(next(&mut queue)), ("/rain".to_owned(), 1));
        assert_eq!(loss(next(&mut queue)), ("/wind".to_owned(), 2));
        for _ in 0..2 {
            assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        }
        assert!(next(&mut queue).is_none());
    }

    #[test]
    fn losses_do_not_alternate_with_messages() {
        let (sender, mut queue) = full();
        let mut losses = 0;
        for _ in 0..2 * MAX_EVENTS {
            assert!(sender.send(message(1)));
            losses += u32::from(matches!(next(&mut queue), Some(Event::Lost { .. })));
        }
        assert!((1..4).contains(&losses), "{losses}");
    }

    #[test]
    fn returns_all_losses_at_the_end() {
        let (sender, mut queue) = full();
        for _ in 0..2 {
            assert!(sender.send(message(1)));
        }
        assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        assert!(sender.send(Event::Unreadable("a bag".to_owned())));
        let mut remaining = queue.remaining_losses().into_iter();
        assert!(matches!(remaining.next(), Some(Event::Unreadable(_))));
        assert_eq!(loss(remaining.next()), ("/wind".to_owned(), 2));
        assert!(remaining.next().is_none());
        assert!(queue.remaining_losses().is_empty());
    }

    #[test]
    fn limits_the_size_of_waiting_payloads() {
        let (sender, mut queue) = queue();
        for _ in 0..3 {
            assert!(sender.send(message(MAX_BYTES / 2)));
        }
        for _ in 0..2 {
            assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        }
        assert!(matches!(next(&mut queue), Some(Event::Lost { count: 1, .. })));
        assert!(sender.send(message(MAX_BYTES / 2)));
        assert!(matches!(next(&mut queue), Some(Event::Message(_))));
    }

    #[test]
    fn ends_with_its_senders() {
        let (sender, mut queue) = queue();
        assert!(sender.send(message(1)));
        drop(sender);
        assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        assert!(matches!(next(&mut queue), Some(Event::Closed(_))));
    }
}
