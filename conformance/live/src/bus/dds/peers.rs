//! Discovery without multicast.
//!
//! rustdds announces its participant by multicast, and to this computer. The announcer also sends this announcement
//! (SPDP) to peers. A peer then announces itself to us, and rustdds does the rest.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddrV4, UdpSocket};

use rustdds::Timestamp;

/// The maximum number of participants that can be found on a peer.
const PARTICIPANTS: u16 = 10;

/// The time after which a peer discards the announcement, in seconds.
const LEASE: u64 = 60;

/// The endpoints that every participant has: for participants, publishers, subscribers and liveliness.
const ENDPOINTS: u32 = 0x0c3f;

/// The identity of a participant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    /// The domain.
    pub domain: u16,
    /// The index on this computer, which determines the ports.
    pub index: u16,
    /// The GUID.
    pub guid: [u8; 16],
}

/// Announces a participant to peers.
#[derive(Debug)]
pub(crate) struct Announcer {
    identity: Identity,
    /// The addresses of the peers, each with the local address to which the peer replies.
    peers: Vec<(Ipv4Addr, Ipv4Addr)>,
    socket: UdpSocket,
    sequence: u32,
}

impl Announcer {
    pub(crate) fn new(identity: Identity, peers: &[Ipv4Addr]) -> Result<Self, String> {
        let local = |peer: &Ipv4Addr| match local_address(*peer) {
            Ok(local) => Ok((*peer, local)),
            Err(error) => Err(format!("peer {peer}: {error}")),
        };
        let peers = peers.iter().map(local).collect::<Result<_, _>>()?;
        let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0));
        let socket = socket.map_err(|error| format!("can't open a UDP socket: {error}"))?;
        Ok(Self { identity, peers, socket, sequence: 1 })
    }

    /// Sends an announcement to each peer.
    pub(crate) fn announce(&mut self) {
        for (peer, local) in &self.peers {
            let announcement = announcement(&self.identity, *local, self.sequence);
            for port in (0..PARTICIPANTS).filter_map(|index| discovery_port(self.identity.domain, index)) {
                // Ports without a participant reject the datagram.
                let _ = self.socket.send_to(&announcement, SocketAddrV4::new(*peer, port));
            }
        }
        self.sequence += 1;
    }
}

/// The address of this computer from which it sends datagrams to a peer. Sends nothing.
fn local_address(peer: Ipv4Addr) -> io::Result<Ipv4Addr> {
    let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
    socket.connect((peer, 7400))?;
    match socket.local_addr()?.ip() {
        IpAddr::V4(address) => Ok(address),
        IpAddr::V6(_) => Err(io::Error::other("expected an IPv4 route")),
    }
}

/// The unicast port for discovery (RTPS 2.5, 9.6.2).
fn discovery_port(domain: u16, index: u16) -> Option<u16> {
    u16::try_from(7410 + 250 * u32::from(domain) + 2 * u32::from(index)).ok()
}

/// An RTPS message with a timestamp and an announcement.
fn announcement(identity: &Identity, local: Ipv4Addr, sequence: u32) -> Vec<u8> {
    let mut bytes = b"RTPS\x02\x04\x01\x12".to_vec();
    bytes.extend_from_slice(&identity.guid[..12]);
    submessage(&mut bytes, 0x09, 0x01, &timestamp());
    let mut data = vec![0, 0, 16, 0];
    // From the writer of participant announcements to its readers.
    data.extend_from_slice(&[0, 1, 0, 0xc7, 0, 1, 0, 0xc2]);
    data.extend_from_slice(&0_u32.to_le_bytes());
    data.extend_from_slice(&sequence.to_le_bytes());
    // A list of parameters.
    data.extend_from_slice(&[0, 3, 0, 0]);
    parameters(&mut data, identity, local);
    submessage(&mut bytes, 0x15, 0x05, &data);
    bytes
}

/// The current time, in seconds and fractions of 2^-32 s.
fn timestamp() -> [u8; 8] {
    Timestamp::now().to_ticks().rotate_left(32).to_le_bytes()
}

fn parameters(bytes: &mut Vec<u8>, identity: &Identity, local: Ipv4Addr) {
    let port = discovery_port(identity.domain, identity.index).unwrap_or(0);
    let version = [2, 4, 0, 0];
    let vendor = [1, 0x12, 0, 0];
    parameter(bytes, 0x15, &version);
    parameter(bytes, 0x16, &vendor);
    parameter(bytes, 0x50, &identity.guid);
    // The ports for discovery and for messages.
    parameter(bytes, 0x32, &locator(local, port));
    parameter(bytes, 0x31, &locator(local, port.saturating_add(1)));
    parameter(bytes, 0x02, &LEASE.to_le_bytes());
    parameter(bytes, 0x58, &ENDPOINTS.to_le_bytes());
    parameter(bytes, 0x01, &[]);
}

fn submessage(bytes: &mut Vec<u8>, id: u8, flags: u8, content: &[u8]) {
    bytes.extend_from_slice(&[id, flags]);
    bytes.extend_from_slice(&length(content));
    bytes.extend_from_slice(content);
}

/// Appends a parameter. The length of the value must be a multiple of 4.
fn parameter(bytes: &mut Vec<u8>, id: u16, value: &[u8]) {
    bytes.extend_from_slice(&id.to_le_bytes());
    bytes.extend_from_slice(&length(value));
    bytes.extend_from_slice(value);
}

/// The length of a content, which must be short.
fn length(content: &[u8]) -> [u8; 2] {
    u16::try_from(content.len()).unwrap_or(u16::MAX).to_le_bytes()
}

/// A UDP address: the kind 1, the port, and the IPv4 address at the end of 16 bytes.
fn locator(address: Ipv4Addr, port: u16) -> [u8; 24] {
    let mut bytes = [0; 24];
    bytes[0] = 1;
    bytes[4..6].copy_from_slice(&port.to_le_bytes());
    bytes[20..].copy_from_slice(&address.octets());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ports_are_those_of_the_standard() {
        assert_eq!(discovery_port(0, 0), Some(7410));
        assert_eq!(discovery_port(1, 2), Some(7664));
        assert_eq!(discovery_port(300, 0), None);
    }

    #[test]
    fn submessages_fill_the_announcement() {
        let bytes = announcement(&Identity { domain: 0, index: 0, guid: [7; 16] }, Ipv4Addr::LOCALHOST, 1);
        let mut position = 20;
        while position < bytes.len() {
            position += 4 + usize::from(u16::from_le_bytes([bytes[position + 2], bytes[position + 3]]));
        }
        assert_eq!(position, bytes.len());
    }
}
