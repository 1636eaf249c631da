//! The connection to the editor on standard input and output.

use std::io::{self, BufRead, ErrorKind, Read as _};
use std::panic::resume_unwind;
use std::thread::{self, JoinHandle};

use crossbeam_channel::{Receiver, Sender, bounded};
use lsp_server::{Connection, Message};
use lsp_types::LspNotificationMethod;

use crate::limits::{MAX_HEADER, MAX_MESSAGE, MAX_WAITING};

/// The threads that read and write the messages.
pub(super) struct Threads {
    reader: JoinHandle<io::Result<()>>,
    writer: JoinHandle<io::Result<()>>,
}

impl Threads {
    /// Waits until both threads end, after the connection is dropped.
    pub(super) fn join(self) -> io::Result<()> {
        [self.reader, self.writer]
            .into_iter()
            .try_for_each(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)))
    }
}

/// Connects to the editor that started the program. Also returns the threads of the connection.
pub(super) fn stdio() -> (Connection, Threads) {
    let (to_server, receiver) = bounded(MAX_WAITING);
    let (sender, to_editor) = bounded(MAX_WAITING);
    let reader = thread::spawn(move || read_all(&mut io::stdin().lock(), &to_server));
    let writer = thread::spawn(move || write_all(&to_editor));
    (Connection { sender, receiver }, Threads { reader, writer })
}

fn read_all(input: &mut impl BufRead, to_server: &Sender<Message>) -> io::Result<()> {
    while let Some(message) = read_message(input)? {
        let exit = LspNotificationMethod::Exit.as_str();
        let is_exit = matches!(&message, Message::Notification(notification) if notification.method == exit);
        if to_server.send(message).is_err() || is_exit {
            break;
        }
    }
    Ok(())
}

#[allow(clippy::disallowed_methods, reason = "JSON escapes all control characters")]
fn write_all(to_editor: &Receiver<Message>) -> io::Result<()> {
    let mut output = io::stdout().lock();
    to_editor.iter().try_for_each(|message| message.write(&mut output))
}

/// Reads a message. `None` at the end of the input.
fn read_message(input: &mut impl BufRead) -> io::Result<Option<Message>> {
    let Some(length) = read_length(input)? else { return Ok(None) };
    if length > MAX_MESSAGE {
        return Err(invalid(format!("a message of {length} bytes; the limit is {MAX_MESSAGE} bytes")));
    }
    let mut body = Vec::new();
    input.by_ref().take(length).read_to_end(&mut body)?;
    if (body.len() as u64) < length {
        return Err(ErrorKind::UnexpectedEof.into());
    }
    serde_json::from_slice(&body).map(Some).map_err(|error| invalid(format!("a malformed message: {error}")))
}

/// Reads the header of a message, and returns the length of its body.
fn read_length(input: &mut impl BufRead) -> io::Result<Option<u64>> {
    let mut length = None;
    loop {
        let mut line = Vec::new();
        input.by_ref().take(MAX_HEADER).read_until(b'\n', &mut line)?;
        if line.is_empty() {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        let Some(line) = line.strip_suffix("\r\n") else {
            return Err(invalid("a malformed header".to_owned()));
        };
        if line.is_empty() {
            return length.map(Some).ok_or_else(|| invalid("a header without Content-Length".to_owned()));
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("Content-Length")
        {
            let value = value.trim().parse();
            length = Some(value.map_err(|_| invalid("an invalid Content-Length".to_owned()))?);
        }
    }
}

fn invalid(message: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Vec<Message>, String> {
        let mut input = text.as_bytes();
        let next = || read_message(&mut input).map_err(|error| error.to_string()).transpose();
        std::iter::from_fn(next).collect()
    }

    #[test]
    fn reads_messages_with_any_header() {
        let body = r#"{"jsonrpc":"2.0","method":"exit"}"#;
        let text = format!(
            "Content-Length: {0}\r\n\r\n{body}content-length:{0}\r\nContent-Type: x\r\n\r\n{body}",
            body.len()
        );
        assert_eq!(read(&text).map(|messages| messages.len()), Ok(2));
        assert_eq!(read("").map(|messages| messages.len()), Ok(0));
    }

    /// A length without a following message causes no allocation.
    #[test]
    fn invalid_lengths_and_headers_are_errors() {
        for (text, expected) in [
            ("Content-Length: 9000000000000000000\r\n\r\n", "a message of 9000000000000000000 bytes"),
            ("Content-Length: 60000000\r\n\r\n{", "unexpected end of file"),
            ("Content-Length: 99999999999999999999\r\n\r\n", "an invalid Content-Length"),
            ("Content-Length: -1\r\n\r\n", "an invalid Content-Length"),
            ("Content-Type: x\r\n\r\n", "without Content-Length"),
            ("Content-Length: 2\n\n{}", "a malformed header"),
            ("Content-Length: 2\r\n\r\n{}", "a malformed message"),
            (&"x".repeat(100_000), "a malformed header"),
        ] {
            let error = read(text).expect_err(expected);
            assert!(error.contains(expected), "{error}");
        }
    }
}
