//! The address and transport of a live server.

use std::fmt;
use std::str::FromStr;

use uavspec_model::net::Address;
use uavspec_model::text::without_query;

use super::engine::Revision;
use super::{ONE_SHOT_PATH, SOCKET_IO_PATH};

/// A transport and an address, in the form of a URL. With TLS, the scheme ends in `s`: `tcps`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// `tcp://localhost:5001`
    Tcp(ServerAddress),
    /// `udp://localhost:5001`
    Udp(ServerAddress),
    /// `http://localhost:5000/api/v1`
    Http {
        /// The host and port.
        address: ServerAddress,
        /// The path and the query, with a leading slash.
        path: String,
    },
    /// `socketio://localhost:5000?protocol=5&transport=websocket`
    SocketIo {
        /// The host and port.
        address: ServerAddress,
        /// The Engine.IO and Socket.IO revision; the newer revision by default.
        revision: Revision,
        /// The carrier of packets; WebSocket by default.
        carrier: Carrier,
    },
}

/// The host and port of a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerAddress {
    /// A name, or an address without brackets.
    pub host: String,
    /// The port.
    pub port: u16,
    /// True if the connection uses TLS.
    pub is_encrypted: bool,
}

impl ServerAddress {
    /// Parses `HOST:PORT`. Without a default, the port is mandatory.
    pub(super) fn parse(text: &str, is_encrypted: bool, default_port: Option<u16>) -> Result<Self, String> {
        if text.contains('@') {
            return Err("a URL must not contain a login: use --login NAME:PASSWORD".to_owned());
        }
        let has_port = text.rfind(':') > text.rfind(']');
        let parsed: Address = match default_port {
            Some(port) if !has_port && !text.is_empty() => format!("{text}:{port}").parse()?,
            _ => text.parse()?,
        };
        Ok(Self { host: parsed.host, port: parsed.port, is_encrypted })
    }

    /// The host and port, without the encryption flag.
    pub(crate) fn address(&self) -> Address {
        Address { host: self.host.clone(), port: self.port }
    }
}

impl fmt::Display for ServerAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.address().fmt(f)
    }
}

/// The carrier of Socket.IO packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Carrier {
    /// WebSocket from the start.
    #[default]
    WebSocket,
    /// Long polling throughout.
    Polling,
}

impl Endpoint {
    /// The URL scheme without the final `s` that denotes TLS: `tcp` for both `tcp` and `tcps`.
    pub fn scheme(&self) -> &'static str {
        match self {
            Self::Tcp(_) => "tcp",
            Self::Udp(_) => "udp",
            Self::Http { .. } => "http",
            Self::SocketIo { .. } => "socketio",
        }
    }

    /// The host and port.
    pub fn address(&self) -> &ServerAddress {
        match self {
            Self::Tcp(address)
            | Self::Udp(address)
            | Self::Http { address, .. }
            | Self::SocketIo { address, .. } => address,
        }
    }

    /// The path and the query of an HTTP URL; empty for other URLs.
    pub fn path(&self) -> &str {
        if let Self::Http { path, .. } = self { path } else { "" }
    }

    /// Returns the endpoint with this carrier of Socket.IO packets.
    #[must_use]
    pub fn by(&self, carrier: Carrier) -> Self {
        match self {
            Self::SocketIo { address, revision, .. } => {
                Self::SocketIo { address: address.clone(), revision: *revision, carrier }
            }
            other => other.clone(),
        }
    }
}

impl FromStr for Endpoint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // Line breaks would add headers to HTTP requests.
        if text.contains(|character: char| character.is_control() || character.is_whitespace()) {
            return Err("a URL contains neither spaces nor control characters".to_owned());
        }
        let (scheme, rest) =
            text.split_once("://").ok_or("missing transport: expected a URL, e.g. tcp://localhost:5001")?;
        match scheme {
            "tcp" | "tcps" => Ok(Self::Tcp(bare(rest, scheme == "tcps", None)?)),
            "udp" => Ok(Self::Udp(bare(rest, false, None)?)),
            "http" | "https" => {
                let (address, path) = rest.find('/').map_or((rest, ""), |slash| rest.split_at(slash));
                let path = match without_query(path) {
                    "" | "/" => format!("{ONE_SHOT_PATH}{}", path.trim_start_matches('/')),
                    _ => path.to_owned(),
                };
                let address = ServerAddress::parse(address, scheme == "https", default_port(scheme))?;
                Ok(Self::Http { address, path })
            }
            "socketio" | "socketios" => socket_io(rest, scheme == "socketios", None),
            "ws" | "wss" => socket_io(rest, scheme == "wss", default_port(scheme)),
            other => Err(format!(
                "unknown transport {other}: expected tcp, udp, http or socketio, or with TLS tcps, https or socketios"
            )),
        }
    }
}

impl fmt::Display for Endpoint {
    /// Writes the URL without the query of a path, which may be a secret.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let scheme = self.scheme();
        let suffix = if self.address().is_encrypted { "s" } else { "" };
        write!(f, "{scheme}{suffix}://{}", self.address())?;
        match self {
            Self::Tcp(_) | Self::Udp(_) => Ok(()),
            Self::Http { path, .. } => f.write_str(without_query(path)),
            Self::SocketIo { revision, carrier, .. } => {
                let transport = match carrier {
                    Carrier::WebSocket => "websocket",
                    Carrier::Polling => "polling",
                };
                write!(f, "?protocol={}&transport={transport}", revision.socket_io())
            }
        }
    }
}

/// The port that applies if a URL with this scheme contains none.
pub(super) fn default_port(scheme: &str) -> Option<u16> {
    match scheme {
        "http" | "ws" => Some(80),
        "https" | "wss" => Some(443),
        _ => None,
    }
}

/// Parses an address that may be followed by a slash.
fn bare(text: &str, is_encrypted: bool, default_port: Option<u16>) -> Result<ServerAddress, String> {
    ServerAddress::parse(text.strip_suffix('/').unwrap_or(text), is_encrypted, default_port)
}

/// Parses a Socket.IO URL. Also accepts the path and the Engine.IO number of a WebSocket URL, as browsers show it.
fn socket_io(text: &str, is_encrypted: bool, default_port: Option<u16>) -> Result<Endpoint, String> {
    let (address, query) = text.split_once('?').unwrap_or((text, ""));
    let address = address.strip_suffix(SOCKET_IO_PATH).unwrap_or(address);
    let (mut revision, mut carrier) = (Revision::Four, Carrier::default());
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        match pair {
            "protocol=4" | "EIO=3" => revision = Revision::Three,
            "protocol=5" | "EIO=4" => revision = Revision::Four,
            "transport=websocket" => carrier = Carrier::WebSocket,
            "transport=polling" => carrier = Carrier::Polling,
            other => {
                let name = other.split('=').next().unwrap_or(other);
                return Err(format!(
                    "unknown option {name}: expected protocol=4, protocol=5, transport=websocket or transport=polling"
                ));
            }
        }
    }
    Ok(Endpoint::SocketIo { address: bare(address, is_encrypted, default_port)?, revision, carrier })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_and_prints_endpoints() {
        for (text, full) in [
            ("tcp://localhost:5001", "tcp://localhost:5001"),
            ("tcp://[::1]:5001/", "tcp://[::1]:5001"),
            ("udp://192.0.2.7:5001", "udp://192.0.2.7:5001"),
            ("http://localhost:5000", "http://localhost:5000/api/v1"),
            ("http://localhost:5000/fleet", "http://localhost:5000/fleet"),
            ("https://localhost", "https://localhost:443/api/v1"),
            ("http://[::1]/fleet", "http://[::1]:80/fleet"),
            ("tcps://[::1]:5001/", "tcps://[::1]:5001"),
            ("wss://localhost", "socketios://localhost:443?protocol=5&transport=websocket"),
            (
                "ws://localhost:5000/socket.io/?EIO=3&transport=websocket",
                "socketio://localhost:5000?protocol=4&transport=websocket",
            ),
            ("socketio://localhost:5000", "socketio://localhost:5000?protocol=5&transport=websocket"),
            (
                "socketio://localhost:5000/?transport=polling&protocol=4",
                "socketio://localhost:5000?protocol=4&transport=polling",
            ),
        ] {
            let endpoint: Endpoint = text.parse().expect(text);
            assert_eq!(endpoint.to_string(), full);
            assert_eq!(full.parse(), Ok(endpoint));
        }
    }

    #[test]
    fn printed_endpoints_contain_no_queries() {
        let endpoint: Endpoint = "http://localhost:5000/fleet?token=secret".parse().expect("a URL");
        assert_eq!(endpoint.to_string(), "http://localhost:5000/fleet");
        assert!(matches!(endpoint, Endpoint::Http { path, .. } if path == "/fleet?token=secret"));
        let endpoint: Endpoint = "http://localhost:5000/?token=secret".parse().expect("a URL");
        assert_eq!(endpoint.to_string(), "http://localhost:5000/api/v1");
        assert_eq!(endpoint.path(), "/api/v1?token=secret");
    }

    #[test]
    fn reports_why_an_endpoint_is_invalid() {
        for (text, expected) in [
            ("localhost:5001", "tcp://localhost:5001"),
            ("ftp://localhost:5001", "socketio"),
            ("tcp://localhost", "no port"),
            ("http:///fleet", "no port"),
            ("socketios://localhost", "no port"),
            ("udps://localhost:5001", "unknown transport udps"),
            ("https://pilot:secret@localhost", "--login"),
            ("socketio://localhost:5000?protocol=3", "unknown option protocol"),
            ("socketio://localhost:5000?token=secret", "unknown option token:"),
        ] {
            let text = text.parse::<Endpoint>().expect_err(text);
            assert!(text.contains(expected), "{text}");
        }
    }
}
