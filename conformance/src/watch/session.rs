//! Hears a server in a thread, asks it what there is to ask, and connects again when it is gone.

use std::io;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::message::{Message, News};
use super::poller::Poller;
use crate::flockwave::transport::client::{Client, Received, connect};
use crate::flockwave::transport::endpoint::Endpoint;

/// How long a connection may take to open.
const CONNECT_LIMIT: Duration = Duration::from_secs(10);

/// How long a server may say nothing at all, though it is asked every few seconds, until it counts as gone.
const SILENCE_LIMIT: Duration = Duration::from_secs(15);

/// How often it is looked whether there is something to ask, and whether anybody still wants to know.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// How long it is waited before a server that is gone is tried again: each time twice as long, up to the last.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LAST_PAUSE: Duration = Duration::from_secs(30);

/// What happens.
#[derive(Debug)]
pub(crate) enum Event {
    /// The server said something.
    Received(Message),
    /// The server is gone, or was never there.
    Lost {
        /// Why.
        reason: String,
        /// How long it is waited before it is tried again.
        pause: Duration,
    },
}

/// A thread that watches a server. Nothing more is asked when this is dropped.
pub(crate) struct Session {
    _wanted: Sender<()>,
}

impl Session {
    /// Watches a server. `on_event` takes what happens, and says whether anybody wants to know more; while it waits,
    /// nothing more is heard.
    pub(crate) fn start(endpoint: Endpoint, on_event: impl FnMut(Event) -> bool + Send + 'static) -> Self {
        let (wanted, end) = channel::<()>();
        let is_over = move |pause| end.recv_timeout(pause) == Err(RecvTimeoutError::Disconnected);
        thread::spawn(move || {
            let mut watch = Watch { endpoint, on_event: Box::new(on_event), is_over: Box::new(is_over) };
            // It ends when nobody wants to know more.
            let _ = watch.run();
        });
        Self { _wanted: wanted }
    }
}

/// Nobody wants to know more.
struct Closed;

struct Watch {
    endpoint: Endpoint,
    on_event: Box<dyn FnMut(Event) -> bool + Send>,
    /// Waits for some time; whether it is all over.
    is_over: Box<dyn Fn(Duration) -> bool + Send>,
}

impl Watch {
    fn run(&mut self) -> Result<(), Closed> {
        let mut pause = FIRST_PAUSE;
        loop {
            let mut has_received = false;
            let reason = match connect(&self.endpoint, Instant::now() + CONNECT_LIMIT) {
                Ok(mut client) => self.talk(&mut *client, &mut has_received)?,
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

    /// Talks with the server until the connection ends; why it ended.
    fn talk(&mut self, client: &mut dyn Client, has_received: &mut bool) -> Result<String, Closed> {
        let mut poller = Poller::new(matches!(self.endpoint, Endpoint::Http { .. }), Instant::now());
        let mut last = Instant::now();
        let mut farewell = None;
        loop {
            if (self.is_over)(Duration::ZERO) {
                return Err(Closed);
            }
            let message = match exchange(client, &mut poller) {
                Ok(Received::Message(bytes)) => Message::read(&bytes),
                Ok(Received::TooLong) => Message { refs: None, news: News::Unreadable },
                Ok(Received::Silence) if last.elapsed() < SILENCE_LIMIT => continue,
                Ok(Received::Silence) => {
                    return Ok(format!("it has said nothing for {} s", SILENCE_LIMIT.as_secs()));
                }
                Ok(Received::End) => {
                    return Ok(farewell.unwrap_or_else(|| "it ended the connection".to_owned()));
                }
                Err(error) => return Ok(farewell.unwrap_or_else(|| error.to_string())),
            };
            last = Instant::now();
            *has_received = true;
            poller.take(&message, last);
            if let News::Closing(reason) = &message.news {
                farewell = Some(format!("it said farewell: {reason}"));
            }
            self.emit(Event::Received(message))?;
        }
    }

    fn emit(&mut self, event: Event) -> Result<(), Closed> {
        if (self.on_event)(event) { Ok(()) } else { Err(Closed) }
    }
}

/// Asks what is due, and hears what comes.
fn exchange(client: &mut dyn Client, poller: &mut Poller) -> io::Result<Received> {
    while let Some(request) = poller.next(Instant::now()) {
        client.send(request.as_bytes())?;
    }
    client.receive(Instant::now() + POLL_INTERVAL)
}
