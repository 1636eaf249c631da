//! The server side of HTTP/1.1.

use crate::limits::{HEAD_LIMIT, HEADER_LIMIT};

/// A request.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// The method: `GET`, `POST`.
    pub method: String,
    /// The path, without the query.
    pub path: String,
    /// The query, without the question mark.
    pub query: String,
    headers: Vec<(String, String)>,
    /// The body.
    pub body: Vec<u8>,
    /// True if the connection ends after the response.
    pub is_last: bool,
}

impl Request {
    /// The value of a header. The name is in lower case.
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// A query field, with escapes unchanged. The fields in use need no escapes.
    pub fn field(&self, name: &str) -> Option<&str> {
        self.query
            .split('&')
            .filter_map(|pair| pair.split_once('='))
            .find(|(key, _)| *key == name)
            .map(|pair| pair.1)
    }

    /// True if a header is a list that contains this word.
    pub fn has_word(&self, header: &str, word: &str) -> bool {
        let words = self.header(header).unwrap_or_default().split(',');
        words.map(str::trim).any(|known| known.eq_ignore_ascii_case(word))
    }
}

/// An HTTP response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    status: &'static str,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
}

impl Response {
    /// Creates a response with a body.
    pub fn new(status: &'static str, content_type: &str, body: impl Into<Vec<u8>>) -> Self {
        let headers = vec![("Content-Type", content_type.to_owned())];
        Self { status, headers, body: body.into() }
    }

    /// Creates an error response with a reason.
    pub fn refusal(status: &'static str, reason: impl Into<String>) -> Self {
        Self::new(status, "text/plain; charset=utf-8", format!("{}\n", reason.into()))
    }

    /// The bytes to send as the response to a request.
    pub fn to_bytes(&self, request: Option<&Request>) -> Vec<u8> {
        let headers = self.headers.iter().map(|(name, value)| format!("{name}: {value}\r\n"));
        let headers: String = headers.collect();
        let is_last = request.is_none_or(|request| request.is_last);
        let connection = if is_last { "close" } else { "keep-alive" };
        let mut bytes = format!(
            "HTTP/1.1 {}\r\n{headers}Content-Length: {}\r\nConnection: {connection}\r\n\r\n",
            self.status,
            self.body.len()
        )
        .into_bytes();
        if request.is_none_or(|request| request.method != "HEAD") {
            bytes.extend(&self.body);
        }
        bytes
    }

    /// True if the status reports a success.
    pub fn is_success(&self) -> bool {
        self.status.starts_with('2')
    }

    /// Adds a header.
    #[must_use]
    pub fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.headers.push((name, value.into()));
        self
    }
}

/// A result of parsing received bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Incoming {
    /// A request.
    Request(Request),
    /// The head of a request whose client waits for a `100 Continue` before it sends the body.
    Expectation,
    /// An error response to an invalid request. The connection must be closed, since the start of the next request is
    /// unknown.
    Refused(Response),
}

/// Splits a stream into requests.
#[derive(Debug)]
pub struct Requests {
    /// The maximum length of a body.
    limit: usize,
    buffer: Vec<u8>,
    /// The head of the next request, the length of the head, and the length of the body.
    head: Option<(Request, usize, usize)>,
}

impl Requests {
    /// Creates an empty buffer for requests with bodies up to this length.
    pub fn new(limit: usize) -> Self {
        Self { limit, buffer: Vec::new(), head: None }
    }

    /// Adds received bytes.
    pub fn feed(&mut self, bytes: &[u8]) {
        self.buffer.extend_from_slice(bytes);
    }

    /// The next complete request.
    pub fn take(&mut self) -> Option<Incoming> {
        if self.head.is_none() {
            let (request, head, length) = match parse_head(&self.buffer, self.limit) {
                Head::Whole(request, head, length) => (request, head, length),
                Head::Refused(response) => return Some(Incoming::Refused(response)),
                Head::Partial => return self.long_head(),
            };
            let is_expecting =
                request.has_word("expect", "100-continue") && self.buffer.len() < head + length;
            self.head = Some((request, head, length));
            if is_expecting {
                return Some(Incoming::Expectation);
            }
        }
        let (mut request, head, length) =
            self.head.take_if(|(_, head, length)| self.buffer.len() >= *head + *length)?;
        let rest = self.buffer.split_off(head + length);
        request.body = std::mem::replace(&mut self.buffer, rest).split_off(head);
        Some(Incoming::Request(request))
    }

    /// The refusal of a head that is too long.
    fn long_head(&self) -> Option<Incoming> {
        let reason = || format!("the request head is longer than {HEAD_LIMIT} bytes");
        let refusal = || Response::refusal("431 Request Header Fields Too Large", reason());
        (self.buffer.len() > HEAD_LIMIT).then(|| Incoming::Refused(refusal()))
    }

    /// The memory of the buffer, in bytes.
    pub fn capacity(&self) -> usize {
        self.buffer.capacity()
    }

    /// The bytes after the last request, to continue with another protocol.
    pub fn into_rest(self) -> Vec<u8> {
        self.buffer
    }
}

enum Head {
    Whole(Request, usize, usize),
    Refused(Response),
    Partial,
}

/// Parses the head of a request. Returns the request and the lengths of its head and body.
fn parse_head(bytes: &[u8], limit: usize) -> Head {
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
    match body_length(&request, limit) {
        Ok(length) => Head::Whole(request, head, length),
        Err(response) => Head::Refused(response),
    }
}

fn body_length(request: &Request, limit: usize) -> Result<usize, Response> {
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
    length.parse().ok().filter(|length| *length <= limit).ok_or_else(|| {
        let reason = format!("the body is longer than {limit} bytes");
        Response::refusal("413 Content Too Large", reason)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: usize = 1 << 20;

    /// The results of parsing these received pieces.
    fn received(pieces: &[&[u8]]) -> Vec<Incoming> {
        let mut requests = Requests::new(LIMIT);
        let mut all = Vec::new();
        for piece in pieces {
            requests.feed(piece);
            while let Some(incoming) = requests.take() {
                let is_refused = matches!(incoming, Incoming::Refused(_));
                all.push(incoming);
                if is_refused {
                    return all;
                }
            }
        }
        all
    }

    #[test]
    fn reads_consecutive_requests_split_anywhere() {
        let all = received(&[
            b"POST /api/v1?a=b&eio=4 HTTP/1.1\r\nHost: glider\r\nContent-Le",
            b"ngth: 4\r\n\r\nwi",
            b"ndGET / HTTP/1.1\r\nConnection: Upgrade, close\r\n\r\n",
        ]);
        let [Incoming::Request(first), Incoming::Request(second)] = &all[..] else { panic!("{all:?}") };
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
            (&[b"POST / HTTP/1.1\r\nContent-Length: 1048577\r\n\r\n"], "413"),
            (&[b"POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"], "411"),
            (&[b"GET / HTTP/1.1\r\nX: ", &[b'x'; 40 << 10]], "431"),
        ];
        for (bytes, status) in CASES {
            let all = received(bytes);
            let Some(Incoming::Refused(response)) = all.last() else { panic!("{all:?}") };
            assert!(response.status.starts_with(status), "{response:?}");
        }
        assert_eq!(received(&[b"POST / HTTP/1.1\r\nContent-Length: 4\r\n\r\nwi"]), []);
    }

    #[test]
    fn announces_clients_that_wait_before_they_send_the_body() {
        let head = b"POST / HTTP/1.1\r\nExpect: 100-continue\r\nContent-Length: 2\r\n\r\n";
        assert_eq!(received(&[head]), [Incoming::Expectation]);
        let all = received(&[head, b"hi"]);
        assert!(matches!(&all[..], [Incoming::Expectation, Incoming::Request(_)]), "{all:?}");
        let all = received(&[&[&head[..], b"hi"].concat()]);
        assert!(matches!(&all[..], [Incoming::Request(_)]), "{all:?}");
    }
}
