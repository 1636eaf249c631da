//! A thread that receives from a server, sends requests, and reconnects if the connection is lost.

use std::time::Duration;
use std::{io, thread};

use uavspec_flockwave::transport::access::Access;
use uavspec_flockwave::transport::client::{Client, Received, connect_with};
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::clock::Clock;

use super::message::{Content, Message};
use super::poller::Poller;

/// The maximum time to connect.
const CONNECT_LIMIT: Duration = Duration::from_secs(10);

/// The time without a message after which the connection counts as lost. It is long enough, because the client sends
/// requests every few seconds.
const SILENCE_LIMIT: Duration = Duration::from_secs(15);

/// The interval between checks for due requests.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// The pause before the first attempt to reconnect. It doubles with each attempt.
const FIRST_PAUSE: Duration = Duration::from_secs(1);

/// The maximum pause between attempts to reconnect.
const LAST_PAUSE: Duration = Duration::from_secs(30);

/// An event of the connection.
#[derive(Debug)]
pub enum Event {
    /// A message was received.
    Received(Message),
    /// The connection was lost or refused.
    Lost {
        /// The reason.
        reason: String,
        /// The pause before the next attempt.
        pause: Duration,
    },
}

/// Watches a server in another thread, until `on_event` returns false. While `on_event` blocks, no messages are received.
pub fn start(endpoint: Endpoint, access: Access, mut on_event: impl FnMut(Event) -> bool + Send + 'static) {
    thread::spawn(move || {
        let clock = Clock::real();
        let mut pause = FIRST_PAUSE;
        loop {
            let reason = match connect_with(&endpoint, &access, clock.now() + CONNECT_LIMIT) {
                Ok(mut client) => {
                    let poller = Poller::new(matches!(endpoint, Endpoint::Http { .. }), clock.now());
                    let on_message = |message| {
                        pause = FIRST_PAUSE;
                        on_event(Event::Received(message))
                    };
                    let Some(reason) = run_connection(&mut *client, poller, on_message) else { return };
                    reason
                }
                Err(error) => error.to_string(),
            };
            if !on_event(Event::Lost { reason, pause }) {
                return;
            }
            clock.sleep(pause);
            pause = (pause * 2).min(LAST_PAUSE);
        }
    });
}

/// Exchanges messages until the connection ends, and returns the reason. Returns `None` if `on_message` returned false.
fn run_connection(
    client: &mut dyn Client,
    mut poller: Poller,
    mut on_message: impl FnMut(Message) -> bool,
) -> Option<String> {
    let clock = Clock::real();
    let mut last = clock.now();
    let mut close_reason = None;
    loop {
        let message = match exchange(client, &mut poller) {
            Ok(Received::Message(bytes)) => Message::read(&bytes),
            Ok(Received::OtherEvent(_)) => continue,
            Ok(Received::TooLong) => Message { refs: None, content: Content::Unreadable },
            Ok(Received::Silence) if clock.now() < last + SILENCE_LIMIT => continue,
            Ok(Received::Silence) => return Some(format!("no message for {} s", SILENCE_LIMIT.as_secs())),
            Ok(Received::End) => {
                return Some(close_reason.unwrap_or_else(|| "the server closed the connection".to_owned()));
            }
            Err(error) => return Some(close_reason.unwrap_or_else(|| error.to_string())),
        };
        last = clock.now();
        poller.take(&message, last);
        if let Content::Closing(reason) = &message.content {
            close_reason = Some(format!("the server closed the connection: {reason}"));
        }
        if !on_message(message) {
            return None;
        }
    }
}

/// Sends the due requests, and waits for a message.
fn exchange(client: &mut dyn Client, poller: &mut Poller) -> io::Result<Received> {
    while let Some(request) = poller.next(Clock::real().now()) {
        client.send(request.as_bytes())?;
    }
    client.receive(Clock::real().now() + POLL_INTERVAL)
}
