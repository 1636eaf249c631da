//! Network addresses.

use std::fmt;
use std::str::FromStr;

/// A host and a TCP port: `localhost:7700`, `192.0.2.7:7700` or `[2001:db8::7]:7700`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Address {
    /// A name, or an address without brackets.
    pub host: String,
    /// The port.
    pub port: u16,
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains(|character: char| character.is_control() || character.is_whitespace()) {
            return Err("an address contains neither spaces nor control characters".to_owned());
        }
        let (host, port) = text.rsplit_once(':').ok_or("no port: expected HOST:PORT, e.g. localhost:7700")?;
        let port = port.parse().ok().filter(|port| *port != 0);
        let port = port.ok_or("expected a port from 1 to 65535")?;
        let host = match host.strip_prefix('[').and_then(|host| host.strip_suffix(']')) {
            Some(host) => host,
            None if host.contains(':') => {
                return Err(format!("an IPv6 address needs brackets: write [{host}]:{port}"));
            }
            None => host,
        };
        if host.is_empty() {
            return Err(format!("no host: write localhost:{port} for this machine"));
        }
        Ok(Self { host: host.to_owned(), port })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { host, port } = self;
        if host.contains(':') { write!(f, "[{host}]:{port}") } else { write!(f, "{host}:{port}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_and_prints_addresses() {
        for (text, host, port) in [
            ("localhost:7700", "localhost", 7700),
            ("192.0.2.7:1", "192.0.2.7", 1),
            ("[2001:db8::7]:65535", "2001:db8::7", 65535),
        ] {
            let address: Address = text.parse().expect(text);
            assert_eq!((address.host.as_str(), address.port), (host, port));
            assert_eq!(address.to_string(), text);
        }
        for (text, expected) in [
            ("localhost", "no port"),
            ("local host:1", "neither spaces"),
            ("localhost\n:1", "neither spaces"),
            ("localhost:", "1 to 65535"),
            ("localhost:0", "1 to 65535"),
            ("localhost:70000", "1 to 65535"),
            (":7700", "no host"),
            ("[]:7700", "no host"),
            ("2001:db8::7:7700", "[2001:db8::7]:7700"),
        ] {
            let text = text.parse::<Address>().expect_err(text);
            assert!(text.contains(expected), "{text}");
        }
    }
}
