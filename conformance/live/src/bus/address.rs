//! The addresses of buses.

use std::fmt;
use std::str::FromStr;

use uavspec_model::net;

/// The highest DDS domain that has valid RTPS port numbers.
const MAX_DOMAIN: u16 = 232;

/// The address of a bus, such as `dds://0` or `zenoh://127.0.0.1:7447`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Address {
    /// A DDS domain.
    Dds {
        /// The number of the domain.
        domain: u16,
    },
    /// A server.
    Server {
        /// The protocol.
        scheme: Scheme,
        /// The host and the port.
        address: net::Address,
        /// The ROS domain.
        domain: u16,
    },
}

/// The protocol of a server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// A Zenoh router or peer.
    Zenoh,
    /// A server of the Foxglove protocol.
    Foxglove,
    /// A server of the rosbridge protocol.
    Rosbridge,
}

impl Scheme {
    const ALL: [Self; 3] = [Self::Zenoh, Self::Foxglove, Self::Rosbridge];

    /// The name in an address.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Zenoh => "zenoh",
            Self::Foxglove => "foxglove",
            Self::Rosbridge => "rosbridge",
        }
    }

    fn default_port(self) -> u16 {
        match self {
            Self::Zenoh => 7447,
            Self::Foxglove => 8765,
            Self::Rosbridge => 9090,
        }
    }
}

impl Address {
    /// The scheme, which is also the name of the transport's feature.
    pub(crate) fn scheme(&self) -> &'static str {
        match self {
            Self::Dds { .. } => "dds",
            Self::Server { scheme, .. } => scheme.name(),
        }
    }

    /// True for a DDS domain. The participants exchange messages only if their quality-of-service settings are
    /// compatible. rustdds doesn't announce type hashes, and writes its own encapsulation headers.
    pub fn is_dds(&self) -> bool {
        matches!(self, Self::Dds { .. })
    }

    /// True if a text is meant as the address of a bus, even if it is invalid.
    pub fn is_meant(text: &str) -> bool {
        let scheme = text.split_once("://").map_or(text, |(scheme, _)| scheme);
        scheme == "dds" || Scheme::ALL.iter().any(|known| known.name() == scheme)
    }
}

impl FromStr for Address {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains('@') {
            return Err("an address must not contain a login".to_owned());
        }
        let (scheme, rest) = text.split_once("://").ok_or("expected an address such as dds://0")?;
        if scheme == "dds" {
            let domain = rest.parse().ok().filter(|domain| *domain <= MAX_DOMAIN);
            let error =
                || format!("expected a DDS domain from 0 to {MAX_DOMAIN}, such as dds://0, found `{rest}`");
            return domain.map(|domain| Self::Dds { domain }).ok_or_else(error);
        }
        let scheme = Scheme::ALL.into_iter().find(|known| known.name() == scheme);
        let scheme = scheme.ok_or("expected dds://, zenoh://, foxglove:// or rosbridge://")?;
        let (authority, query) = rest.split_once('?').unwrap_or((rest, ""));
        let domain = domain(query)?;
        let address = server(authority.trim_end_matches('/'), scheme)?;
        Ok(Self::Server { scheme, address, domain })
    }
}

/// The ROS domain in a query: `domain=3`.
fn domain(query: &str) -> Result<u16, String> {
    if query.is_empty() {
        return Ok(0);
    }
    let domain = query.strip_prefix("domain=").and_then(|text| text.parse().ok());
    domain.ok_or_else(|| format!("expected `domain=NUMBER` after `?`, found `{query}`"))
}

/// Parses the host, and the port if there is one.
fn server(text: &str, scheme: Scheme) -> Result<net::Address, String> {
    let (name, port) = (scheme.name(), scheme.default_port());
    let has_port = text.rfind(':') > text.rfind(']');
    let address = if has_port { text.parse() } else { format!("{text}:{port}").parse() };
    address.map_err(|error| {
        format!("expected a host, such as {name}://127.0.0.1:{port}, found `{text}`: {error}")
    })
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dds { domain } => write!(formatter, "dds://{domain}"),
            Self::Server { scheme, address, domain } => {
                write!(formatter, "{}://{address}", scheme.name())?;
                if *domain > 0 { write!(formatter, "?domain={domain}") } else { Ok(()) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_have_one_form() {
        for (text, shown) in [
            ("dds://0", "dds://0"),
            ("zenoh://localhost", "zenoh://localhost:7447"),
            ("zenoh://[::1]:7448?domain=3", "zenoh://[::1]:7448?domain=3"),
            ("foxglove://127.0.0.1/", "foxglove://127.0.0.1:8765"),
            ("rosbridge://127.0.0.1:9091", "rosbridge://127.0.0.1:9091"),
        ] {
            let address: Address = text.parse().expect("an address");
            assert_eq!(address.to_string(), shown);
            assert_eq!(shown.parse(), Ok(address));
        }
    }

    #[test]
    fn errors_name_the_expected_form() {
        for (text, part) in [
            ("dds://300", "from 0 to 232"),
            ("dds://x", "found `x`"),
            ("zenoh://", "a host"),
            ("zenoh://a:99999", "found `a:99999`"),
            ("zenoh://a?x=1", "`domain=NUMBER`"),
            ("mqtt://a", "zenoh://"),
            ("0", "dds://0"),
        ] {
            let error = text.parse::<Address>().expect_err("an error");
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
