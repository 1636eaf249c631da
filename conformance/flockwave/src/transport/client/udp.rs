//! UDP: one message in each datagram. Lost datagrams are not noticed here.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::Instant;

use uavspec_model::clock::Clock;
use uavspec_model::net::{Address, explain, is_silence, resolve};

use super::{Client, Received};
use crate::transport::endpoint::ServerAddress;

/// The maximum size of a datagram, in bytes.
const DATAGRAM_LIMIT: usize = 64 << 10;

pub(super) struct Udp {
    socket: UdpSocket,
    address: Address,
    /// Further addresses of the host, which are tried if the first one refuses the first datagrams.
    others: Vec<SocketAddr>,
    /// The last datagram, until the server has answered.
    last: Vec<u8>,
    /// True if the system reported a refused datagram.
    is_refused: bool,
}

impl Udp {
    pub(super) fn connect(address: &ServerAddress, until: Instant) -> io::Result<Self> {
        let address = address.address();
        let mut others = resolve(&address, until)?;
        others.reverse();
        let socket = open_next(&mut others)
            .ok_or_else(|| io::Error::new(ErrorKind::NotFound, format!("host not found: {}", address.host)))?
            .map_err(|error| explain(&address, error))?;
        Ok(Self { socket, address, others, last: Vec::new(), is_refused: false })
    }

    /// Sends the last datagram to the next address of the host. Returns false if there is none.
    fn try_next(&mut self) -> io::Result<bool> {
        let Some(socket) = open_next(&mut self.others) else { return Ok(false) };
        self.socket = socket?;
        self.socket.send(&self.last)?;
        Ok(true)
    }

    fn refused(&self) -> io::Error {
        explain(&self.address, ErrorKind::ConnectionRefused.into())
    }
}

impl Client for Udp {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        self.send_raw(message)
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.last = bytes.to_vec();
        match self.socket.send(bytes) {
            // The error is about an earlier datagram. `receive` reports it.
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => {
                self.is_refused = true;
                self.socket.send(bytes).map(|_| ())
            }
            sent => sent.map(|_| ()),
        }
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        let mut datagram = vec![0; DATAGRAM_LIMIT];
        loop {
            if std::mem::take(&mut self.is_refused) && !self.try_next()? {
                return Err(self.refused());
            }
            let left = Clock::real().left(until);
            if left.is_zero() {
                return Ok(Received::Silence);
            }
            self.socket.set_read_timeout(Some(left))?;
            match self.socket.recv(&mut datagram) {
                Ok(length) => {
                    self.others.clear();
                    datagram.truncate(length);
                    return Ok(Received::Message(datagram));
                }
                Err(error) if is_silence(&error) => {}
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => self.is_refused = true,
                Err(error) => return Err(error),
            }
        }
    }
}

/// Opens a socket for the last reachable address in the list. Removes this address and all addresses after it. If none
/// can be reached, returns the last error.
fn open_next(addresses: &mut Vec<SocketAddr>) -> Option<io::Result<UdpSocket>> {
    let mut opened = None;
    while !matches!(opened, Some(Ok(_)))
        && let Some(address) = addresses.pop()
    {
        opened = Some(open(address));
    }
    opened
}

/// Opens a socket that only exchanges datagrams with this address.
fn open(address: SocketAddr) -> io::Result<UdpSocket> {
    let local: SocketAddr = match address {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    };
    let socket = UdpSocket::bind(local)?;
    socket.connect(address)?;
    Ok(socket)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tries_all_addresses_of_a_host() {
        let closed = UdpSocket::bind("127.0.0.1:0").and_then(|socket| socket.local_addr()).expect("a port");
        let server = UdpSocket::bind("127.0.0.1:0").expect("a port");
        let mut client = Udp {
            socket: open(closed).expect("a socket"),
            address: closed.to_string().parse().expect("an address"),
            others: vec![server.local_addr().expect("an address")],
            last: Vec::new(),
            is_refused: false,
        };
        client.send(b"wind").expect("sent");
        // The system reports the refusal at the next attempt to receive.
        while !client.others.is_empty() {
            client
                .receive(Clock::real().now() + std::time::Duration::from_millis(10))
                .expect("no error while there are other addresses");
        }
        let mut datagram = [0; 10];
        let (length, from) = server.recv_from(&mut datagram).expect("a datagram");
        assert_eq!(&datagram[..length], b"wind");
        server.send_to(b"calm", from).expect("sent");
        let until = uavspec_test_support::deadline();
        assert_eq!(client.receive(until).expect("a datagram"), Received::Message(b"calm".to_vec()));
    }
}
