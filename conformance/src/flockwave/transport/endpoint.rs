//! The address and transport of a live server.

use std::fmt;
use std::str::FromStr;

use super::ONE_SHOT_PATH;
use super::engine::Revision;
use crate::net::Address;

/// A transport and an address, in the form of a URL.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// `tcp://localhost:5001`
    Tcp(Address),
    /// `udp://localhost:5001`
    Udp(Address),
    /// `http://localhost:5000/api/v1`
    Http {
        /// The host and port.
        address: Address,
        /// The path, with a leading slash.
        path: String,
    },
    /// `socketio://localhost:5000?protocol=5&transport=websocket`
    SocketIo {
        /// The host and port.
        address: Address,
        /// The Engine.IO and Socket.IO revision; the newer revision by default.
        revision: Revision,
        /// The carrier of packets; WebSocket by default.
        carrier: Carrier,
    },
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
    /// The scheme in the URL.
    pub fn scheme(&self) -> &'static str {
        match self {
            Self::Tcp(_) => "tcp",
            Self::Udp(_) => "udp",
            Self::Http { .. } => "http",
            Self::SocketIo { .. } => "socketio",
        }
    }

    /// Sets the carrier of Socket.IO packets.
    #[must_use]
    pub(crate) fn by(&self, carrier: Carrier) -> Self {
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
        let (scheme, rest) =
            text.split_once("://").ok_or("missing transport: expected a URL, e.g. tcp://localhost:5001")?;
        match scheme {
            "tcp" => Ok(Self::Tcp(bare(rest)?)),
            "udp" => Ok(Self::Udp(bare(rest)?)),
            "http" => {
                let (address, path) = rest.find('/').map_or((rest, ""), |slash| rest.split_at(slash));
                let path = if path.is_empty() || path == "/" { ONE_SHOT_PATH } else { path };
                Ok(Self::Http { address: address.parse()?, path: path.to_owned() })
            }
            "socketio" => socket_io(rest),
            other => Err(format!("unknown transport {other}: expected tcp, udp, http or socketio")),
        }
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tcp(address) => write!(f, "tcp://{address}"),
            Self::Udp(address) => write!(f, "udp://{address}"),
            Self::Http { address, path } => write!(f, "http://{address}{path}"),
            Self::SocketIo { address, revision, carrier } => {
                let transport = match carrier {
                    Carrier::WebSocket => "websocket",
                    Carrier::Polling => "polling",
                };
                write!(f, "socketio://{address}?protocol={}&transport={transport}", revision.socket_io())
            }
        }
    }
}

/// An address, optionally followed by a slash.
fn bare(text: &str) -> Result<Address, String> {
    text.strip_suffix('/').unwrap_or(text).parse()
}

fn socket_io(text: &str) -> Result<Endpoint, String> {
    let (address, query) = text.split_once('?').unwrap_or((text, ""));
    let (mut revision, mut carrier) = (Revision::Four, Carrier::default());
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        match pair {
            "protocol=4" => revision = Revision::Three,
            "protocol=5" => revision = Revision::Four,
            "transport=websocket" => carrier = Carrier::WebSocket,
            "transport=polling" => carrier = Carrier::Polling,
            other => {
                return Err(format!(
                    "unknown option {other}: expected protocol=4, protocol=5, transport=websocket or transport=polling"
                ));
            }
        }
    }
    Ok(Endpoint::SocketIo { address: bare(address)?, revision, carrier })
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
    fn reports_why_an_endpoint_is_invalid() {
        for (text, expected) in [
            ("localhost:5001", "tcp://localhost:5001"),
            ("ftp://localhost:5001", "socketio"),
            ("tcp://localhost", "no port"),
            ("http:///fleet", "no port"),
            ("socketio://localhost:5000?protocol=3", "protocol=3"),
        ] {
            let text = text.parse::<Endpoint>().expect_err(text);
            assert!(text.contains(expected), "{text}");
        }
    }
}
