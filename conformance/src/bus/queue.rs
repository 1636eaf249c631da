//! The queue between the threads of a transport and the thread that reads its events.

use std::collections::BTreeMap;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use super::Event;

/// The maximum number of waiting events.
const MAX_EVENTS: usize = 1 << 14;

/// The maximum total size of the waiting payloads, in bytes.
const MAX_BYTES: usize = 256 << 20;

/// Messages that found no space, by topic, and the size of the waiting payloads.
#[derive(Debug, Default)]
struct State {
    lost: BTreeMap<Arc<str>, u64>,
    bytes: usize,
}

/// The end of the queue that the threads of a transport use.
#[derive(Clone, Debug)]
pub(crate) struct Sender {
    events: SyncSender<Event>,
    state: Arc<Mutex<State>>,
}

/// The end of the queue that returns the events.
#[derive(Debug)]
pub(crate) struct Queue {
    events: Receiver<Event>,
    state: Arc<Mutex<State>>,
    /// The number of events that are received before losses are reported.
    until_losses: usize,
}

/// Creates a queue.
pub(crate) fn queue() -> (Sender, Queue) {
    let (sender, events) = mpsc::sync_channel(MAX_EVENTS);
    let state = Arc::default();
    (Sender { events: sender, state: Arc::clone(&state) }, Queue { events, state, until_losses: 0 })
}

impl Sender {
    /// Adds an event. If there is no space, a message is dropped and counted as lost; the thread waits with any other
    /// event. Returns false if nothing reads the queue any more.
    pub(crate) fn send(&self, event: Event) -> bool {
        let Event::Message(message) = &event else { return self.events.send(event).is_ok() };
        let (topic, size) = (Arc::clone(&message.topic.name), message.payload.len());
        {
            let mut state = locked(&self.state);
            if state.bytes + size > MAX_BYTES {
                *state.lost.entry(topic).or_default() += 1;
                return true;
            }
            state.bytes += size;
        }
        match self.events.try_send(event) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                let mut state = locked(&self.state);
                state.bytes -= size;
                *state.lost.entry(topic).or_default() += 1;
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

impl Queue {
    /// The next event. Waits until the deadline if there is none.
    pub(crate) fn receive(&mut self, deadline: Instant) -> Option<Event> {
        if self.until_losses == 0
            && let Some((topic, count)) = locked(&self.state).lost.pop_first()
        {
            return Some(Event::Lost { topic, count });
        }
        let event = match self.events.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(event) => event,
            Err(RecvTimeoutError::Timeout) => return self.lost(),
            Err(RecvTimeoutError::Disconnected) => {
                return self.lost().or_else(|| Some(Event::Closed("the connection ended".to_owned())));
            }
        };
        self.until_losses = self.until_losses.checked_sub(1).unwrap_or(MAX_EVENTS);
        if let Event::Message(message) = &event {
            locked(&self.state).bytes -= message.payload.len();
        }
        Some(event)
    }

    fn lost(&mut self) -> Option<Event> {
        self.until_losses = 0;
        locked(&self.state).lost.pop_first().map(|(topic, count)| Event::Lost { topic, count })
    }
}

fn locked(state: &Mutex<State>) -> std::sync::MutexGuard<'_, State> {
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::bus::{Encoding, Received, Topic};

    fn message(size: usize) -> Event {
        let topic = Topic { name: "/wind".into(), type_name: "sky_msgs/msg/Wind".into(), type_hash: None };
        let payload = vec![0; size];
        Event::Message(Received {
            topic,
            schema: None,
            encoding: Encoding::Cdr,
            time: 1,
            payload,
            is_own: false,
        })
    }

    fn next(queue: &mut Queue) -> Option<Event> {
        queue.receive(Instant::now() + Duration::from_millis(1))
    }

    #[test]
    fn counts_messages_without_space() {
        let (sender, mut queue) = queue();
        for _ in 0..MAX_EVENTS + 3 {
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
    fn limits_the_size_of_waiting_payloads() {
        let (sender, mut queue) = queue();
        for _ in 0..3 {
            assert!(sender.send(message(MAX_BYTES / 2)));
        }
        assert!(matches!(next(&mut queue), Some(Event::Lost { count: 1, .. })));
        for _ in 0..2 {
            assert!(matches!(next(&mut queue), Some(Event::Message(_))));
        }
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
