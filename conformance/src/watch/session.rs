//! Hears a server in a thread, asks it what there is to ask, and connects again when it is gone.

use std::io;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::asker::Asker;
use super::message::{Message, News};
use crate::flockwave::transport::client::{Client, Heard, connect};
use crate::flockwave::transport::endpoint::Endpoint;

/// How long a connection may take to open.
const CONNECT_LIMIT: Duration = Duration::from_secs(10);

/// How long a server may say nothing at all, though it is asked every few seconds, until it counts as gone.
const PATIENCE: Duration = Duration::from_secs(15);

/// How often it is looked whether there is something to ask, and whether anybody still wants to know.
const LOOK: Duration = Duration::from_millis(100);

/// How long it is waited before a server that is gone is tried again: each time twice as long, up to the last.
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LAST_PAUSE: Duration = Duration::from_secs(30);

/// What happens.
#[derive(Debug)]
pub(crate) enum Event {
    /// The server said something.
    Heard(Message),
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
    /// Watches a server. `tell` takes what happens, and says whether anybody wants to know more; while it waits,
    /// nothing more is heard.
    pub(crate) fn start(endpoint: Endpoint, tell: impl FnMut(Event) -> bool + Send + 'static) -> Self {
        let (wanted, end) = channel::<()>();
        let is_over = move |pause| end.recv_timeout(pause) == Err(RecvTimeoutError::Disconnected);
        thread::spawn(move || {
            let mut watch = Watch { endpoint, tell: Box::new(tell), is_over: Box::new(is_over) };
            // It ends when nobody wants to know more.
            let _ = watch.run();
        });
        Self { _wanted: wanted }
    }
}

/// Nobody wants to know more.
struct Over;

struct Watch {
    endpoint: Endpoint,
    tell: Box<dyn FnMut(Event) -> bool + Send>,
    /// Waits for some time; whether it is all over.
    is_over: Box<dyn Fn(Duration) -> bool + Send>,
}

impl Watch {
    fn run(&mut self) -> Result<(), Over> {
        let mut pause = FIRST_PAUSE;
        loop {
            let mut has_heard = false;
            let reason = match connect(&self.endpoint, Instant::now() + CONNECT_LIMIT) {
                Ok(mut client) => self.talk(&mut *client, &mut has_heard)?,
                Err(error) => error.to_string(),
            };
            if has_heard {
                pause = FIRST_PAUSE;
            }
            self.say(Event::Lost { reason, pause })?;
            if (self.is_over)(pause) {
                return Err(Over);
            }
            pause = (pause * 2).min(LAST_PAUSE);
        }
    }

    /// Talks with the server until the connection ends; why it ended.
    fn talk(&mut self, client: &mut dyn Client, has_heard: &mut bool) -> Result<String, Over> {
        let mut asker = Asker::new(matches!(self.endpoint, Endpoint::Http { .. }), Instant::now());
        let mut last = Instant::now();
        let mut farewell = None;
        loop {
            if (self.is_over)(Duration::ZERO) {
                return Err(Over);
            }
            let message = match exchange(client, &mut asker) {
                Ok(Heard::Message(bytes)) => Message::read(&bytes),
                Ok(Heard::TooLong) => Message { refs: None, news: News::Unreadable },
                Ok(Heard::Silence) if last.elapsed() < PATIENCE => continue,
                Ok(Heard::Silence) => return Ok(format!("it has said nothing for {} s", PATIENCE.as_secs())),
                Ok(Heard::End) => return Ok(farewell.unwrap_or_else(|| "it ended the connection".to_owned())),
                Err(error) => return Ok(farewell.unwrap_or_else(|| error.to_string())),
            };
            last = Instant::now();
            *has_heard = true;
            asker.take(&message, last);
            if let News::Closing(reason) = &message.news {
                farewell = Some(format!("it said farewell: {reason}"));
            }
            self.say(Event::Heard(message))?;
        }
    }

    fn say(&mut self, event: Event) -> Result<(), Over> {
        if (self.tell)(event) { Ok(()) } else { Err(Over) }
    }
}

/// Asks what is due, and hears what comes.
fn exchange(client: &mut dyn Client, asker: &mut Asker) -> io::Result<Heard> {
    while let Some(request) = asker.next(Instant::now()) {
        client.send(request.as_bytes())?;
    }
    client.hear(Instant::now() + LOOK)
}
