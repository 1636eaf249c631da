//! TCP: one message per line.

use std::io::{self, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use serde::de::IgnoredAny;
use serde_json::Value;

use super::{POLL_INTERVAL, SEND_LIMIT, Shared};
use crate::flockwave::transport::http::is_silence;
use crate::flockwave::transport::lines::{Line, Lines};
use crate::rules::flockwave::{env_25, tcp_01, tcp_02, tcp_03, tcp_04};
use crate::serve::hub::{ConnectionKind, SessionId, Sink};
use crate::serve::outbox::{Outbox, Taken};

/// The maximum number of messages per write.
const BATCH: usize = 64;

/// Sends messages as lines.
struct LineSink {
    outbox: Arc<Outbox>,
    /// True with the FW-TCP-01 bug, which splits notifications into several lines.
    is_spread: bool,
}

impl Sink for LineSink {
    fn send(&self, text: &str) {
        let spread = if self.is_spread { spread(text) } else { None };
        self.outbox.push(spread.unwrap_or_else(|| text.to_owned()) + "\n");
    }

    fn close(&self) {
        self.outbox.close();
    }
}

/// A notification with line breaks.
fn spread(text: &str) -> Option<String> {
    let message: Value = serde_json::from_str(text).ok()?;
    if message.get("refs").is_some() { None } else { serde_json::to_string_pretty(&message).ok() }
}

/// Serves a connection until it ends.
pub(super) fn serve_connection(shared: &Arc<Shared>, mut stream: TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(POLL_INTERVAL))?;
    stream.set_write_timeout(Some(SEND_LIMIT))?;
    let outbox = Arc::new(Outbox::default());
    let output = stream.try_clone()?;
    let queue = Arc::clone(&outbox);
    let writer = thread::spawn(move || write(output, &queue));
    let sink = LineSink { outbox: Arc::clone(&outbox), is_spread: shared.has_bug(&tcp_01::RULE) };
    let id = shared.open(ConnectionKind::Persistent, Arc::new(sink));
    let ending = read(shared, id, &mut stream, &writer);
    shared.close(id);
    // Requests that precede the end of the input still get responses.
    outbox.close();
    let _ = writer.join();
    ending
}

/// Writes messages until the outbox is closed and empty, and then closes the connection.
fn write(mut stream: TcpStream, outbox: &Outbox) {
    loop {
        match outbox.take(BATCH, Instant::now() + SEND_LIMIT) {
            Taken::Texts(texts) => {
                if stream.write_all(texts.concat().as_bytes()).is_err() {
                    break;
                }
            }
            Taken::Nothing => {}
            Taken::End => break,
        }
    }
    outbox.close();
    // The connection may be closed already.
    let _ = stream.shutdown(Shutdown::Both);
}

/// Reads until the client closes the connection, or until nothing more can be sent to the client.
fn read(
    shared: &Shared,
    id: SessionId,
    stream: &mut TcpStream,
    writer: &thread::JoinHandle<()>,
) -> io::Result<()> {
    let (mut lines, mut piece) = (Lines::default(), [0; 16 << 10]);
    while !writer.is_finished() {
        let length = match stream.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(length) => length,
            Err(error) if is_silence(&error) => continue,
            Err(error) => return Err(error),
        };
        lines.feed(&piece[..length]);
        let mut taken = lines.taken();
        if shared.has_bug(&env_25::RULE) {
            taken.reverse();
        }
        for line in taken {
            // A line over the length limit is dropped, because its request is unknown.
            let Line::Whole(line) = line else { continue };
            if shared.has_bug(&tcp_03::RULE) && serde_json::from_slice::<IgnoredAny>(&line).is_err() {
                return Ok(());
            }
            shared.receive(id, &line);
            if shared.has_bug(&tcp_02::RULE) {
                break;
            }
        }
        if shared.has_bug(&tcp_04::RULE) {
            lines.drop_rest();
        }
    }
    Ok(())
}
