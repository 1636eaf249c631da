//! The server side of HTTP/1.1.

use std::io::{self, Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::MESSAGE_LIMIT;

/// The maximum size of a request head, in bytes. Browsers send one or two kilobytes.
const HEAD_LIMIT: usize = 32 << 10;

/// The maximum number of header lines.
const HEADER_LIMIT: usize = 100;

/// The maximum time between requests.
const IDLE_LIMIT: Duration = Duration::from_secs(60);

/// The maximum time from the first to the last byte of a request.
const REQUEST_LIMIT: Duration = Duration::from_secs(30);

/// The interval at which a waiting connection checks whether it is still needed.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// A request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Request {
    /// The method: `GET`, `POST`.
    pub method: String,
    /// The path, without the query.
    pub path: String,
    /// The query, without the question mark.
    pub query: String,
    headers: Vec<(String, String)>,
    /// The body.
    pub body: Vec<u8>,
    is_last: bool,
}

impl Request {
    /// The value of a header. The name is in lower case.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// A query field, with escapes unchanged. The fields in use need no escapes.
    pub(crate) fn field(&self, name: &str) -> Option<&str> {
        self.query
            .split('&')
            .filter_map(|pair| pair.split_once('='))
            .find(|(key, _)| *key == name)
            .map(|pair| pair.1)
    }

    /// True if a header is a list that contains this word.
    pub(crate) fn has_word(&self, header: &str, word: &str) -> bool {
        let words = self.header(header).unwrap_or_default().split(',');
        words.map(str::trim).any(|known| known.eq_ignore_ascii_case(word))
    }
}

/// An HTTP response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Response {
    status: &'static str,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
}

impl Response {
    /// Creates a response with a body.
    pub(crate) fn new(status: &'static str, content_type: &str, body: impl Into<Vec<u8>>) -> Self {
        let headers = vec![("Content-Type", content_type.to_owned())];
        Self { status, headers, body: body.into() }
    }

    /// Creates an error response with a reason.
    pub(crate) fn refusal(status: &'static str, reason: impl Into<String>) -> Self {
        Self::new(status, "text/plain; charset=utf-8", format!("{}\n", reason.into()))
    }

    /// Adds a header.
    #[must_use]
    pub(crate) fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.headers.push((name, value.into()));
        self
    }
}

/// The result of waiting for a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Incoming {
    /// A request.
    Request(Request),
    /// An error response to an invalid request. The connection must be closed, since the start of the next request is
    /// unknown.
    Refused(Response),
    /// No request: the connection was closed, is no longer needed, or was idle for too long.
    Nothing,
}

/// The server side of a connection.
#[derive(Debug)]
pub(crate) struct Connection {
    stream: TcpStream,
    buffer: Vec<u8>,
}

impl Connection {
    /// Creates a connection from an accepted stream.
    pub(crate) fn new(stream: TcpStream) -> io::Result<Self> {
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(REQUEST_LIMIT))?;
        Ok(Self { stream, buffer: Vec::new() })
    }

    /// Waits for the next request as long as `is_wanted` returns true.
    pub(crate) fn next(&mut self, is_wanted: &dyn Fn() -> bool) -> io::Result<Incoming> {
        let mut until = Instant::now() + IDLE_LIMIT;
        if self.buffer.is_empty() && !self.read_more(until, is_wanted)? {
            return Ok(Incoming::Nothing);
        }
        until = Instant::now() + REQUEST_LIMIT;
        let (mut request, head, length) = loop {
            match parse_head(&self.buffer) {
                Head::Whole(request, head, length) => break (request, head, length),
                Head::Refused(response) => return Ok(Incoming::Refused(response)),
                Head::Partial => {}
            }
            if self.buffer.len() > HEAD_LIMIT {
                let reason = format!("the request head is longer than {HEAD_LIMIT} bytes");
                return Ok(Incoming::Refused(Response::refusal(
                    "431 Request Header Fields Too Large",
                    reason,
                )));
            }
            if !self.read_more(until, is_wanted)? {
                return Ok(Incoming::Nothing);
            }
        };
        if request.has_word("expect", "100-continue") && self.buffer.len() < head + length {
            self.stream.write_all(b"HTTP/1.1 100 Continue\r\n\r\n")?;
        }
        while self.buffer.len() < head + length {
            if !self.read_more(until, is_wanted)? {
                return Ok(Incoming::Nothing);
            }
        }
        let rest = self.buffer.split_off(head + length);
        request.body = std::mem::replace(&mut self.buffer, rest).split_off(head);
        Ok(Incoming::Request(request))
    }

    /// Sends the response to a request. Returns true if the connection stays open.
    pub(crate) fn respond(&mut self, request: Option<&Request>, response: &Response) -> io::Result<bool> {
        let is_last = request.is_none_or(|request| request.is_last);
        let mut text = format!("HTTP/1.1 {}\r\n", response.status).into_bytes();
        for (name, value) in &response.headers {
            text.extend(format!("{name}: {value}\r\n").into_bytes());
        }
        let connection = if is_last { "close" } else { "keep-alive" };
        text.extend(
            format!("Content-Length: {}\r\nConnection: {connection}\r\n\r\n", response.body.len())
                .into_bytes(),
        );
        let has_body = request.is_none_or(|request| request.method != "HEAD");
        if has_body {
            text.extend(&response.body);
        }
        self.stream.write_all(&text)?;
        Ok(!is_last)
    }

    /// The stream and the bytes after the last request, to continue with another protocol.
    pub(crate) fn into_stream(self) -> (TcpStream, Vec<u8>) {
        (self.stream, self.buffer)
    }

    /// Reads more bytes. Returns false if none arrive in time.
    fn read_more(&mut self, until: Instant, is_wanted: &dyn Fn() -> bool) -> io::Result<bool> {
        let mut piece = [0; 16 << 10];
        loop {
            let left = until.saturating_duration_since(Instant::now()).min(POLL_INTERVAL);
            if left.is_zero() || !is_wanted() {
                return Ok(false);
            }
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(&mut piece) {
                Ok(0) => return Ok(false),
                Ok(length) => {
                    self.buffer.extend_from_slice(&piece[..length]);
                    return Ok(true);
                }
                Err(error) if is_silence(&error) => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// True if an error only means that nothing arrived in time.
pub(crate) fn is_silence(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut | io::ErrorKind::Interrupted)
}

enum Head {
    Whole(Request, usize, usize),
    Refused(Response),
    Partial,
}

/// Parses the head of a request. Returns the request and the lengths of its head and body.
fn parse_head(bytes: &[u8]) -> Head {
    let mut headers = [httparse::EMPTY_HEADER; HEADER_LIMIT];
    let mut parsed = httparse::Request::new(&mut headers);
    let head = match parsed.parse(bytes) {
        Ok(httparse::Status::Complete(head)) => head,
        Ok(httparse::Status::Partial) => return Head::Partial,
        Err(error) => {
            return Head::Refused(Response::refusal(
                "400 Bad Request",
                format!("invalid HTTP request: {error}"),
            ));
        }
    };
    let target = parsed.path.unwrap_or_default();
    let (path, query) = target.split_once('?').unwrap_or((target, ""));
    let texts = parsed.headers.iter().map(|header| {
        (header.name.to_ascii_lowercase(), String::from_utf8_lossy(header.value).trim().to_owned())
    });
    let mut request = Request {
        method: parsed.method.unwrap_or_default().to_owned(),
        path: path.to_owned(),
        query: query.to_owned(),
        headers: texts.collect(),
        body: Vec::new(),
        is_last: false,
    };
    request.is_last = request.has_word("connection", "close")
        || parsed.version == Some(0) && !request.has_word("connection", "keep-alive");
    match body_length(&request) {
        Ok(length) => Head::Whole(request, head, length),
        Err(response) => Head::Refused(response),
    }
}

fn body_length(request: &Request) -> Result<usize, Response> {
    if request.header("transfer-encoding").is_some() {
        return Err(Response::refusal("411 Length Required", "the request must have a Content-Length"));
    }
    let mut lengths =
        request.headers.iter().filter(|(name, _)| name == "content-length").map(|(_, value)| value);
    let Some(length) = lengths.next() else { return Ok(0) };
    // Contradictory lengths would allow request smuggling.
    let is_number = !length.is_empty() && length.bytes().all(|byte| byte.is_ascii_digit());
    if !is_number || lengths.any(|other| other != length) {
        return Err(Response::refusal("400 Bad Request", "the Content-Length isn't a single number"));
    }
    length.parse().ok().filter(|length| *length <= MESSAGE_LIMIT).ok_or_else(|| {
        let reason = format!("the body is longer than {MESSAGE_LIMIT} bytes");
        Response::refusal("413 Content Too Large", reason)
    })
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    /// The server-side results for a client that sends these pieces and then closes its side.
    fn received(pieces: &'static [&'static [u8]]) -> Vec<Incoming> {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let client = thread::spawn(move || {
            let mut stream = TcpStream::connect(address).expect("a connection");
            for piece in pieces {
                let _ = stream.write_all(piece);
            }
            // The server may close its side first.
            let _ = stream.shutdown(std::net::Shutdown::Write);
            let _ = stream.read_to_end(&mut Vec::new());
        });
        let mut connection = Connection::new(listener.accept().expect("a client").0).expect("a connection");
        let mut all = Vec::new();
        loop {
            let incoming = connection.next(&|| true).expect("a result");
            let is_end = !matches!(incoming, Incoming::Request(_));
            all.push(incoming);
            if is_end {
                break;
            }
        }
        drop(connection);
        client.join().expect("the client ends");
        all
    }

    #[test]
    fn reads_consecutive_requests_split_anywhere() {
        let all = received(&[
            b"POST /api/v1?a=b&eio=4 HTTP/1.1\r\nHost: glider\r\nContent-Le",
            b"ngth: 4\r\n\r\nwi",
            b"ndGET / HTTP/1.1\r\nConnection: Upgrade, close\r\n\r\n",
        ]);
        let [Incoming::Request(first), Incoming::Request(second), Incoming::Nothing] = &all[..] else {
            panic!("{all:?}")
        };
        assert_eq!(
            (first.method.as_str(), first.path.as_str(), &first.body[..]),
            ("POST", "/api/v1", &b"wind"[..])
        );
        assert_eq!((first.field("eio"), first.field("b"), first.is_last), (Some("4"), None, false));
        assert!(second.is_last && second.has_word("connection", "upgrade"));
    }

    #[test]
    fn refuses_invalid_requests() {
        const CASES: [(&[&[u8]], &str); 7] = [
            (&[b"\x00\x01\x02\r\n\r\n"], "400"),
            (&[b"POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"], "400"),
            (&[b"POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\nxx"], "400"),
            (&[b"POST / HTTP/1.1\r\nContent-Length: 99999999999999999999\r\n\r\n"], "413"),
            (&[b"POST / HTTP/1.1\r\nContent-Length: 16777217\r\n\r\n"], "413"),
            (&[b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"], "411"),
            (&[b"GET / HTTP/1.1\r\nX: ", &[b'x'; 40 << 10]], "431"),
        ];
        for (bytes, status) in CASES {
            let all = received(bytes);
            let Some(Incoming::Refused(response)) = all.last() else { panic!("{all:?}") };
            assert!(response.status.starts_with(status), "{response:?}");
        }
        assert_eq!(received(&[b"POST / HTTP/1.1\r\nContent-Length: 4\r\n\r\nwi"]), [Incoming::Nothing]);
    }
}
