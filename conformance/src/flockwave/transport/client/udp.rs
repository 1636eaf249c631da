//! UDP: one message in each datagram.

use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::Instant;

use super::{Client, Received};
use crate::flockwave::transport::http::is_silence;
use crate::net::{Address, resolve};

/// The maximum size of a datagram, in bytes.
const DATAGRAM_LIMIT: usize = 64 << 10;

pub(super) struct Udp(UdpSocket);

impl Udp {
    pub(super) fn connect(address: &Address, until: Instant) -> io::Result<Self> {
        let found = resolve(address, until)?.into_iter().next();
        let found =
            found.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the host has no address"))?;
        let local: SocketAddr = match found {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(local)?;
        // A connected socket only receives datagrams from this server.
        socket.connect(found)?;
        Ok(Self(socket))
    }
}

impl Client for Udp {
    fn send(&mut self, message: &[u8]) -> io::Result<()> {
        self.send_raw(message)
    }

    fn send_raw(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.send(bytes).map(|_| ())
    }

    fn receive(&mut self, until: Instant) -> io::Result<Received> {
        let mut datagram = vec![0; DATAGRAM_LIMIT];
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(Received::Silence);
            }
            self.0.set_read_timeout(Some(left))?;
            match self.0.recv(&mut datagram) {
                Ok(length) => {
                    datagram.truncate(length);
                    return Ok(Received::Message(datagram));
                }
                Err(error) if is_silence(&error) => {}
                // The server doesn't listen on this port.
                Err(error) if error.kind() == io::ErrorKind::ConnectionRefused => return Ok(Received::End),
                Err(error) => return Err(error),
            }
        }
    }
}
