//! A proxy between a client and a server, with delays, packet loss, redirects, logins, TLS and lost connections.
//!
//! ```ignore
//! let (server, address) = serve(Options::default(), Transport::Http);
//! let proxy = Proxy { login: Some("pilot:secret"), ..Proxy::default() };
//! let url = format!("http://{}", proxy.start(address));
//! ```

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, IsCa, KeyPair};
use rustls::pki_types::PrivateKeyDer;
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use uavspec_model::clock::Clock;
use uavspec_test_support::Random;

use crate::server::location;

/// The time limit for a read. Afterwards, the proxy handles the other direction.
const TURN: Duration = Duration::from_millis(2);

/// The prefix of redirected paths on the same host. The proxy removes it before it forwards a request.
pub const MOVED: &str = "/moved";

/// The decision about bytes from a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// To the server.
    Forward,
    /// The bytes are lost.
    Lose,
    /// The connection is closed, and the bytes are lost.
    Cut,
}

/// Receives all bytes from clients before they are forwarded, and decides what to do with them. May block.
pub type Watch = Arc<dyn Fn(&[u8]) -> Pass + Send + Sync>;

/// Options of a proxy. The default forwards everything unchanged.
#[derive(Clone, Default)]
pub struct Proxy {
    /// The delay from the client to the server, and the delay in the opposite direction.
    pub delays: [Duration; 2],
    /// The clock for the delays. If it is simulated, another thread must advance it.
    pub clock: Clock,
    /// The percentage of UDP datagrams that are dropped in each direction. Each run drops the same datagrams.
    pub loss: u64,
    /// HTTP only: redirects each request with this status to this prefix, followed by the path and the query. The
    /// prefix is [`MOVED`] or the URL of another host.
    pub redirect: Option<(&'static str, String)>,
    /// HTTP only: the required `NAME:PASSWORD`, in base64.
    pub login: Option<&'static str>,
    /// HTTP only: answers each request with this status and this body.
    pub answer: Option<(&'static str, &'static str)>,
    /// If set, accepts only TLS connections. The connection to the server doesn't use TLS.
    pub tls: Option<Arc<ServerConfig>>,
    /// Decides which bytes from clients are forwarded.
    pub watch: Option<Watch>,
}

impl Proxy {
    /// Starts a proxy for TCP, HTTP or Socket.IO.
    pub fn start(self, server: SocketAddr) -> SocketAddr {
        let listener = TcpListener::bind(location()).expect("a port");
        let address = listener.local_addr().expect("an address");
        thread::spawn(move || {
            for client in listener.incoming().flatten() {
                let proxy = self.clone();
                // An error ends the connection.
                thread::spawn(move || proxy.serve(client, server));
            }
        });
        address
    }

    /// Starts a proxy for UDP and a single client.
    pub fn start_udp(self, server: SocketAddr) -> SocketAddr {
        let front = UdpSocket::bind(location()).expect("a port");
        let back = UdpSocket::bind(location()).expect("a port");
        back.connect(server).expect("an address");
        let address = front.local_addr().expect("an address");
        thread::spawn(move || self.forward_datagrams(&front, &back));
        address
    }

    fn forward_datagrams(&self, front: &UdpSocket, back: &UdpSocket) -> io::Result<()> {
        let mut random = Random(1);
        let (mut datagram, mut client) = (vec![0; 1 << 16], None);
        let [mut to_server, mut to_client] = self.delays.map(|delay| Delayed::new(delay, self.clock.clone()));
        front.set_read_timeout(Some(TURN))?;
        back.set_read_timeout(Some(TURN))?;
        loop {
            if let Some((length, from)) = quiet(front.recv_from(&mut datagram))? {
                client = Some(from);
                if random.below(100) >= self.loss && self.pass(&datagram[..length]) == Pass::Forward {
                    to_server.push(&datagram[..length]);
                }
            }
            while let Some(datagram) = to_server.pop() {
                back.send(&datagram)?;
            }
            if let Some(length) = quiet(back.recv(&mut datagram))?
                && random.below(100) >= self.loss
            {
                to_client.push(&datagram[..length]);
            }
            while let (Some(client), Some(datagram)) = (client, to_client.pop()) {
                front.send_to(&datagram, client)?;
            }
        }
    }

    fn serve(&self, mut client: TcpStream, server: SocketAddr) -> io::Result<()> {
        let closer = client.try_clone()?;
        client.set_nodelay(true)?;
        let server = TcpStream::connect(server)?;
        let result = match &self.tls {
            None => {
                client.set_read_timeout(Some(TURN))?;
                self.forward(client, &server)
            }
            Some(config) => {
                let mut connection = ServerConnection::new(Arc::clone(config)).expect("a configuration");
                while connection.is_handshaking() {
                    connection.complete_io(&mut client)?;
                }
                client.set_read_timeout(Some(TURN))?;
                self.forward(StreamOwned::new(connection, client), &server)
            }
        };
        // The other side may already have closed the connection.
        let _ = (server.shutdown(Shutdown::Both), closer.shutdown(Shutdown::Both));
        result
    }

    fn forward(&self, mut client: impl Read + Write, mut server: &TcpStream) -> io::Result<()> {
        let mut piece = [0; 1 << 14];
        let mut requests = Requests::default();
        let [mut to_server, mut to_client] = self.delays.map(|delay| Delayed::new(delay, self.clock.clone()));
        server.set_nodelay(true)?;
        server.set_read_timeout(Some(TURN))?;
        let (mut is_open, mut is_sending) = (true, true);
        let (mut is_finished, mut is_answered) = (false, false);
        while is_open || !to_client.waiting.is_empty() {
            if is_open && is_sending {
                match quiet(client.read(&mut piece))? {
                    // The client may still receive.
                    Some(0) => is_sending = false,
                    Some(length) if self.is_http() => match requests.take(self, &piece[..length]) {
                        Ok(forwarded) => to_server.push(&forwarded),
                        Err(answer) => {
                            to_client.push(answer.as_bytes());
                            is_answered = true;
                        }
                    },
                    Some(length) => match self.pass(&piece[..length]) {
                        Pass::Forward => to_server.push(&piece[..length]),
                        Pass::Lose => {}
                        Pass::Cut => return Ok(()),
                    },
                    None => {}
                }
            }
            while let Some(bytes) = to_server.pop() {
                server.write_all(&bytes)?;
            }
            if !is_sending && to_server.waiting.is_empty() && !std::mem::replace(&mut is_finished, true) {
                // The server may have closed the connection.
                let _ = server.shutdown(Shutdown::Write);
            }
            match quiet(server.read(&mut piece))? {
                Some(0) => is_open = false,
                Some(length) => to_client.push(&piece[..length]),
                None => {}
            }
            while let Some(bytes) = to_client.pop() {
                client.write_all(&bytes)?;
                client.flush()?;
            }
            is_open &= !is_answered;
        }
        Ok(())
    }

    fn pass(&self, bytes: &[u8]) -> Pass {
        self.watch.as_ref().map_or(Pass::Forward, |watch| watch(bytes))
    }

    fn is_http(&self) -> bool {
        self.redirect.is_some() || self.login.is_some() || self.answer.is_some()
    }

    /// The head of a request in the form in which it is forwarded to the server. The error is the answer to a request
    /// that isn't forwarded.
    fn check(&self, head: &str) -> Result<String, String> {
        if let Some((status, body)) = self.answer {
            return Err(answer(status, "", body));
        }
        let target = head.split(' ').nth(1).unwrap_or_default();
        if let Some((status, to)) = &self.redirect
            && !target.starts_with(MOVED)
        {
            return Err(answer(status, &format!("Location: {to}{target}\r\n"), "moved"));
        }
        if let Some(login) = self.login
            && !head.contains(&format!("Basic {login}\r\n"))
        {
            return Err(answer("401 Unauthorized", "WWW-Authenticate: Basic realm=\"fleet\"\r\n", "log in"));
        }
        Ok(head.replacen(MOVED, "", 1))
    }
}

fn answer(status: &str, headers: &str, body: &str) -> String {
    let length = body.len();
    format!("HTTP/1.1 {status}\r\n{headers}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}")
}

/// Splits the bytes from a client into HTTP requests.
#[derive(Default)]
struct Requests {
    head: Vec<u8>,
    /// The number of remaining bytes in the body of the current request.
    body: usize,
}

impl Requests {
    /// The bytes to forward. The error is the answer to a request that isn't forwarded.
    fn take(&mut self, proxy: &Proxy, mut bytes: &[u8]) -> Result<Vec<u8>, String> {
        let mut forwarded = Vec::new();
        loop {
            let (body, rest) = bytes.split_at(self.body.min(bytes.len()));
            forwarded.extend(body);
            self.body -= body.len();
            if rest.is_empty() {
                return Ok(forwarded);
            }
            self.head.push(rest[0]);
            bytes = &rest[1..];
            if !self.head.ends_with(b"\r\n\r\n") {
                continue;
            }
            let head = String::from_utf8(std::mem::take(&mut self.head)).expect("a head");
            let lower = head.to_ascii_lowercase();
            let length = lower.lines().find_map(|line| line.strip_prefix("content-length:"));
            self.body = match length {
                // WebSocket frames follow.
                _ if lower.contains("upgrade: websocket") => usize::MAX,
                Some(length) => length.trim().parse().expect("a length"),
                None => 0,
            };
            forwarded.extend(proxy.check(&head)?.into_bytes());
        }
    }
}

/// Bytes that will be forwarded after a delay.
struct Delayed {
    waiting: VecDeque<(Instant, Vec<u8>)>,
    delay: Duration,
    clock: Clock,
}

impl Delayed {
    fn new(delay: Duration, clock: Clock) -> Self {
        Self { waiting: VecDeque::new(), delay, clock }
    }

    fn push(&mut self, bytes: &[u8]) {
        self.waiting.push_back((self.clock.now() + self.delay, bytes.to_vec()));
    }

    fn pop(&mut self) -> Option<Vec<u8>> {
        let is_due = self.waiting.front().is_some_and(|(due, _)| *due <= self.clock.now());
        if is_due { self.waiting.pop_front().map(|(_, bytes)| bytes) } else { None }
    }
}

/// Converts a timeout and a refused datagram to `None`.
fn quiet<T>(read: io::Result<T>) -> io::Result<Option<T>> {
    match read {
        Ok(value) => Ok(Some(value)),
        // A refused datagram counts as lost.
        Err(error) if matches!(error.kind(), ErrorKind::ConnectionRefused) => Ok(None),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Creates a certificate authority. Returns its certificate in PEM form, and the configuration of a server that has a
/// certificate for these names.
pub fn certified(names: &[&str]) -> (String, Arc<ServerConfig>) {
    certified_with(names, |_| {})
}

/// Like [`certified`], but changes the parameters of the server's certificate.
pub fn certified_with(
    names: &[&str],
    change: impl FnOnce(&mut CertificateParams),
) -> (String, Arc<ServerConfig>) {
    let mut authority = CertificateParams::new(Vec::new()).expect("parameters");
    authority.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    authority.distinguished_name.push(rcgen::DnType::CommonName, "Glider authority");
    let key = KeyPair::generate().expect("a key");
    let authority = CertifiedIssuer::self_signed(authority, key).expect("an authority");
    let key = KeyPair::generate().expect("a key");
    let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let mut params = CertificateParams::new(names).expect("names");
    change(&mut params);
    let certificate = params.signed_by(&key, &authority).expect("a certificate");
    let config = ServerConfig::builder_with_provider(Arc::new(rustls::crypto::ring::default_provider()))
        .with_safe_default_protocol_versions()
        .expect("versions")
        .with_no_client_auth()
        .with_single_cert(vec![certificate.der().clone()], PrivateKeyDer::Pkcs8(key.serialize_der().into()))
        .expect("a certificate");
    (authority.pem(), Arc::new(config))
}
