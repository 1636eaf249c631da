//! HTTP statuses other than success.

use std::io;

use uavspec_model::text::{shown, shown_url, start_of, without_query};
use ureq::http::{HeaderMap, StatusCode, header};

use super::target::Target;
use crate::limits::REDIRECT_LIMIT;
use crate::transport::access::Access;

/// The maximum length of the excerpt of a body, in characters.
const EXCERPT: usize = 200;

const REFUSED_LOGIN: &str = "the server refused the login: check the name and the password in --login";

/// The error for a response with an unexpected status.
#[derive(Debug)]
struct StatusError {
    status: u16,
    text: String,
}

impl std::error::Error for StatusError {}

impl std::fmt::Display for StatusError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// The HTTP status that caused an error. If the client refused to follow a redirect, this is the status of the
/// redirect.
pub fn http_status(error: &io::Error) -> Option<u16> {
    Some(error.get_ref()?.downcast_ref::<StatusError>()?.status)
}

/// A response without a message.
pub(super) struct Refusal<'r> {
    pub(super) target: &'r Target,
    pub(super) status: StatusCode,
    pub(super) headers: &'r HeaderMap,
    pub(super) body: &'r [u8],
    pub(super) access: &'r Access,
}

impl Refusal<'_> {
    /// An error that names the status, its cause and the remedy.
    pub(super) fn error(&self) -> io::Error {
        let (explanation, excerpt) = (self.explanation(), self.excerpt());
        if excerpt.is_empty() {
            error(self.status, &explanation)
        } else {
            error(self.status, &format!("{explanation}; the server says: {excerpt}"))
        }
    }

    fn explanation(&self) -> String {
        let target = self.target;
        match self.status.as_u16() {
            200..=299 => format!("the server doesn't open a WebSocket at {target}"),
            401 => self.unauthorized(),
            403 if self.has_login() => format!("{REFUSED_LOGIN}, and whether it may access {target}"),
            403 => format!("the server refuses access to {target}"),
            404 => format!("no service at {target}: check the host, the port and the path in the URL"),
            405 => format!("wrong service at {target}: check the path in the URL"),
            407 => "a proxy requires a login: connect to the server directly".to_owned(),
            502..=504 => "the server is not available at the moment".to_owned(),
            _ => format!("unexpected response from {target}"),
        }
    }

    fn unauthorized(&self) -> String {
        let challenges = self.headers.get_all(header::WWW_AUTHENTICATE);
        let methods: Vec<&str> = challenges
            .iter()
            .filter_map(|value| value.to_str().ok()?.split_ascii_whitespace().next())
            .collect();
        if !methods.is_empty() && !methods.iter().any(|method| method.eq_ignore_ascii_case("basic")) {
            return format!(
                "the server requires a login with {}, but only Basic is supported",
                methods.join(" or ")
            );
        }
        if self.has_login() {
            REFUSED_LOGIN.to_owned()
        } else {
            "the server requires a login: use --login NAME:PASSWORD".to_owned()
        }
    }

    fn has_login(&self) -> bool {
        self.access.authorization().is_some()
    }

    /// The start of the body, on one line.
    fn excerpt(&self) -> String {
        let body = String::from_utf8_lossy(self.body);
        let line = self
            .access
            .secrets(&self.target.path)
            .hide(&body)
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        shown(&start_of(&line, EXCERPT))
    }
}

/// The next target, if the response is a redirect. Fails if the redirect leads to another host.
pub(super) fn redirected(
    target: &Target,
    status: StatusCode,
    headers: &HeaderMap,
) -> io::Result<Option<Target>> {
    if !matches!(status.as_u16(), 301 | 302 | 303 | 307 | 308) {
        return Ok(None);
    }
    let Some(location) = headers.get(header::LOCATION) else { return Ok(None) };
    let location = String::from_utf8_lossy(location.as_bytes());
    match target.redirected(&location) {
        Some(next) => Ok(Some(next)),
        None => Err(error(
            status,
            &format!(
                "the server redirects to {}: use that URL instead",
                shown(&shown_url(without_query(&location)))
            ),
        )),
    }
}

/// The error for a request that is redirected too many times.
pub(super) fn too_many_redirects(target: &Target) -> io::Error {
    let text = format!("more than {REDIRECT_LIMIT} redirects, the last one to {target}");
    io::Error::new(io::ErrorKind::InvalidData, text)
}

fn error(status: StatusCode, text: &str) -> io::Error {
    let text = format!("HTTP status {status}: {text}");
    io::Error::new(io::ErrorKind::InvalidData, StatusError { status: status.as_u16(), text })
}
