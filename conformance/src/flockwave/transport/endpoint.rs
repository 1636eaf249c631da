//! Where a live server is found, and over which transport.

use std::fmt;
use std::str::FromStr;

use super::ONE_SHOT_PATH;
use super::engine::Revision;
use crate::net::Address;

/// A transport and an address, written as a URL.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Endpoint {
    /// `tcp://localhost:5001`
    Tcp(Address),
    /// `udp://localhost:5001`
    Udp(Address),
    /// `http://localhost:5000/api/v1`
    Http {
        /// Host and port.
        address: Address,
        /// The path, with a slash before it.
        path: String,
    },
    /// `socketio://localhost:5000?protocol=5&transport=websocket`
    SocketIo {
        /// Host and port.
        address: Address,
        /// Which revision of the protocols to speak; the newer one, where nothing is said.
        revision: Revision,
        /// How packets travel; over a WebSocket, where nothing is said.
        carrier: Carrier,
    },
}

/// How packets of Socket.IO travel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Carrier {
    /// Over a WebSocket, from the beginning.
    #[default]
    WebSocket,
    /// By long polling, to the end.
    Polling,
}

impl Endpoint {
    /// The transport, as URLs name it.
    pub fn scheme(&self) -> &'static str {
        match self {
            Self::Tcp(_) => "tcp",
            Self::Udp(_) => "udp",
            Self::Http { .. } => "http",
            Self::SocketIo { .. } => "socketio",
        }
    }

    /// The same server, with packets of Socket.IO that travel in this way.
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
        let (scheme, rest) = text.split_once("://").ok_or("no transport: write tcp://localhost:5001")?;
        match scheme {
            "tcp" => Ok(Self::Tcp(bare(rest)?)),
            "udp" => Ok(Self::Udp(bare(rest)?)),
            "http" => {
                let (address, path) = rest.find('/').map_or((rest, ""), |slash| rest.split_at(slash));
                let path = if path.is_empty() || path == "/" { ONE_SHOT_PATH } else { path };
                Ok(Self::Http { address: address.parse()?, path: path.to_owned() })
            }
            "socketio" => socket_io(rest),
            other => Err(format!("no transport has the name {other}: there are tcp, udp, http and socketio")),
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

/// An address with at most a slash after it.
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
                    "{other}: only protocol=4 or 5 and transport=websocket or polling can be said"
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
    fn endpoints_are_read_and_printed() {
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
        for (text, wrong) in [
            ("localhost:5001", "tcp://localhost:5001"),
            ("ftp://localhost:5001", "socketio"),
            ("tcp://localhost", "no port"),
            ("http:///fleet", "no port"),
            ("socketio://localhost:5000?protocol=3", "protocol=3"),
        ] {
            let text = text.parse::<Endpoint>().expect_err(text);
            assert!(text.contains(wrong), "{text}");
        }
    }
}
