//! The target of an HTTP request, which redirects can change.

use std::fmt;

use uavspec_model::text::shown_url;

use crate::transport::endpoint::{ServerAddress, default_port};

/// The server, path and query of an HTTP request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Target {
    pub(super) address: ServerAddress,
    /// The path and the query.
    pub(super) path: String,
}

impl Target {
    pub(super) fn new(address: &ServerAddress, path: impl Into<String>) -> Self {
        Self { address: address.clone(), path: path.into() }
    }

    /// The URL of a request.
    pub(super) fn url(&self) -> String {
        let scheme = if self.address.is_encrypted { "https" } else { "http" };
        format!("{scheme}://{}{}", self.address, self.path)
    }

    /// The URL of the WebSocket.
    pub(super) fn web_socket_url(&self) -> String {
        let scheme = if self.address.is_encrypted { "wss" } else { "ws" };
        format!("{scheme}://{}{}", self.address, self.path)
    }

    /// The target of a redirect. `None` if it is on another host or without TLS, or isn't a valid URL.
    ///
    /// Requests contain credentials, so only the host that the user named may receive them.
    pub(super) fn redirected(&self, location: &str) -> Option<Self> {
        let location = location.split('#').next().unwrap_or(location);
        let (is_encrypted, rest) = match location.split_once("://") {
            Some(("http" | "ws", rest)) => (false, rest),
            Some(("https" | "wss", rest)) => (true, rest),
            Some((scheme, _)) if !scheme.contains(['/', '?']) => return None,
            _ => match location.strip_prefix("//") {
                Some(rest) => (self.address.is_encrypted, rest),
                None => return Some(Self { path: self.joined(location), ..self.clone() }),
            },
        };
        let (authority, path) = rest.find(['/', '?']).map_or((rest, "/"), |at| rest.split_at(at));
        let port = default_port(if is_encrypted { "https" } else { "http" });
        let address = ServerAddress::parse(authority, is_encrypted, port).ok()?;
        let is_same_host = address.host.eq_ignore_ascii_case(&self.address.host);
        let is_as_safe = address.is_encrypted || !self.address.is_encrypted;
        let path = if path.starts_with('/') { path.to_owned() } else { format!("/{path}") };
        (is_same_host && is_as_safe).then_some(Self { address, path })
    }

    /// The path that a relative URL denotes.
    fn joined(&self, relative: &str) -> String {
        if relative.starts_with('/') {
            return relative.to_owned();
        }
        let path = self.path.split('?').next().unwrap_or(&self.path);
        if relative.starts_with('?') {
            return format!("{path}{relative}");
        }
        let folder = path.rfind('/').map_or("/", |slash| &path[..=slash]);
        format!("{folder}{relative}")
    }
}

impl fmt::Display for Target {
    /// Writes the URL without its query.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&shown_url(&self.url()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn follows_redirects_on_the_same_host_only() {
        let address = |is_encrypted| ServerAddress { host: "glider".to_owned(), port: 5000, is_encrypted };
        let plain = Target::new(&address(false), "/api/v1?a=b");
        for (location, expected) in [
            ("/fleet?c=d", Some("http://glider:5000/fleet?c=d")),
            ("fleet", Some("http://glider:5000/api/fleet")),
            ("?c=d", Some("http://glider:5000/api/v1?c=d")),
            ("http://GLIDER:5001/fleet#top", Some("http://GLIDER:5001/fleet")),
            ("https://glider?c=d", Some("https://glider:443/?c=d")),
            ("//glider:7/x", Some("http://glider:7/x")),
            ("http://kite:5000/api/v1", None),
            ("http://pilot:secret@glider/", None),
            ("ftp://glider/fleet", None),
            ("/login?from=http://kite/", Some("http://glider:5000/login?from=http://kite/")),
        ] {
            let found = plain.redirected(location).map(|target| target.url());
            assert_eq!(found.as_deref(), expected, "{location}");
        }
        let encrypted = Target::new(&address(true), "/");
        assert_eq!(encrypted.redirected("http://glider:5000/"), None);
        assert_eq!(
            encrypted.redirected("/x").map(|target| target.url()).as_deref(),
            Some("https://glider:5000/x")
        );
    }
}
