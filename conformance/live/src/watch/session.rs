//! A thread that receives from a server, sends requests, and reconnects if the connection is lost.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
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

/// The connection counts as lost after this time without a message. This is long enough, because the client sends
/// requests every few seconds.
const SILENCE_LIMIT: Duration = Duration::from_secs(15);

/// The interval between checks for due requests and for the end of the session.
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

/// A thread that watches a server. The thread ends when the session is dropped.
pub struct Session {
    _end: Sender<()>,
}

impl Session {
    /// Watches a server. The thread ends if `on_event` returns false. While `on_event` blocks, no messages are
    /// received.
    pub fn start(
        endpoint: Endpoint,
        access: Access,
        on_event: impl FnMut(Event) -> bool + Send + 'static,
    ) -> Self {
        let (end, ended) = channel::<()>();
        let is_over = move |pause| ended.recv_timeout(pause) == Err(RecvTimeoutError::Disconnected);
        thread::spawn(move || {
            let (on_event, is_over) = (Box::new(on_event), Box::new(is_over));
            let mut watch = Watch { endpoint, access, on_event, is_over };
            // The only possible error is that the session has ended.
            let _ = watch.run();
        });
        Self { _end: end }
    }
}

/// The session has ended.
struct Closed;

struct Watch {
    endpoint: Endpoint,
    access: Access,
    on_event: Box<dyn FnMut(Event) -> bool + Send>,
    /// Waits for some time, and returns true if the session has ended.
    is_over: Box<dyn Fn(Duration) -> bool + Send>,
}

impl Watch {
    fn run(&mut self) -> Result<(), Closed> {
        let mut pause = FIRST_PAUSE;
        loop {
            let mut has_received = false;
            let reason = match connect_with(&self.endpoint, &self.access, Clock::real().now() + CONNECT_LIMIT)
            {
                Ok(mut client) => self.run_connection(&mut *client, &mut has_received)?,
                Err(error) => error.to_string(),
            };
            if has_received {
                pause = FIRST_PAUSE;
            }
            self.emit(Event::Lost { reason, pause })?;
            if (self.is_over)(pause) {
                return Err(Closed);
            }
            pause = (pause * 2).min(LAST_PAUSE);
        }
    }

    /// Exchanges messages until the connection ends, and returns the reason.
    fn run_connection(&mut self, client: &mut dyn Client, has_received: &mut bool) -> Result<String, Closed> {
        let mut poller = Poller::new(matches!(self.endpoint, Endpoint::Http { .. }), Clock::real().now());
        let mut last = Clock::real().now();
        let mut close_reason = None;
        loop {
            if (self.is_over)(Duration::ZERO) {
                return Err(Closed);
            }
            let message = match exchange(client, &mut poller) {
                Ok(Received::Message(bytes)) => Message::read(&bytes),
                Ok(Received::OtherEvent(_)) => continue,
                Ok(Received::TooLong) => Message { refs: None, content: Content::Unreadable },
                Ok(Received::Silence) if Clock::real().now() < last + SILENCE_LIMIT => continue,
                Ok(Received::Silence) => {
                    return Ok(format!("no message for {} s", SILENCE_LIMIT.as_secs()));
                }
                Ok(Received::End) => {
                    return Ok(close_reason.unwrap_or_else(|| "the server closed the connection".to_owned()));
                }
                Err(error) => return Ok(close_reason.unwrap_or_else(|| error.to_string())),
            };
            last = Clock::real().now();
            *has_received = true;
            poller.take(&message, last);
            if let Content::Closing(reason) = &message.content {
                close_reason = Some(format!("the server closed the connection: {reason}"));
            }
            self.emit(Event::Received(message))?;
        }
    }

    fn emit(&mut self, event: Event) -> Result<(), Closed> {
        if (self.on_event)(event) { Ok(()) } else { Err(Closed) }
    }
}

/// Sends the due requests, and waits for a message.
fn exchange(client: &mut dyn Client, poller: &mut Poller) -> io::Result<Received> {
    while let Some(request) = poller.next(Clock::real().now()) {
        client.send(request.as_bytes())?;
    }
    client.receive(Clock::real().now() + POLL_INTERVAL)
}
