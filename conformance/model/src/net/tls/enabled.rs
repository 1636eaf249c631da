//! TLS with rustls.

use std::fmt;
use std::io::{self, Read, Write};
use std::path::Path;
use std::sync::{Arc, OnceLock};

use rustls::crypto::ring::default_provider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{CertificateError, ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use ureq::tls::{Certificate, RootCerts, TlsConfig};

use super::verifier::AcceptAll;
use crate::net::timed::Timed;
use crate::text::terminal;

/// The certificates that a client trusts: the certificates of the operating system, and the certificates in a file.
#[derive(Clone, Default)]
pub struct Trust {
    authorities: Vec<CertificateDer<'static>>,
    is_insecure: bool,
    /// Loaded for the first connection, because this takes some time.
    roots: Arc<OnceLock<Vec<CertificateDer<'static>>>>,
    config: Arc<OnceLock<Arc<ClientConfig>>>,
}

impl Trust {
    /// Trusts the certificates of a PEM file, or any certificate, in addition to the operating system's certificates.
    pub fn new(authorities: Option<&Path>, is_insecure: bool) -> Result<Self, String> {
        let authorities = authorities.map(read).transpose()?.unwrap_or_default();
        Ok(Self { authorities, is_insecure, ..Self::default() })
    }

    /// The trusted certificates.
    fn roots(&self) -> &[CertificateDer<'static>] {
        self.roots.get_or_init(|| {
            // A certificate that can't be read is not trusted.
            let mut roots = rustls_native_certs::load_native_certs().certs;
            roots.extend(self.authorities.iter().cloned());
            roots
        })
    }

    /// The configuration of an HTTP agent.
    pub fn agent_config(&self) -> TlsConfig {
        let config = TlsConfig::builder().unversioned_rustls_crypto_provider(Arc::new(default_provider()));
        if self.is_insecure {
            return config.disable_verification(true).build();
        }
        let roots = self.roots().iter().map(|root| Certificate::from_der(root).to_owned());
        config.root_certs(RootCerts::from(roots)).build()
    }

    fn config(&self) -> io::Result<Arc<ClientConfig>> {
        if let Some(config) = self.config.get() {
            return Ok(Arc::clone(config));
        }
        let config = Arc::new(self.new_config().map_err(io::Error::other)?);
        Ok(Arc::clone(self.config.get_or_init(|| config)))
    }

    fn new_config(&self) -> Result<ClientConfig, rustls::Error> {
        let provider = Arc::new(default_provider());
        let builder = ClientConfig::builder_with_provider(Arc::clone(&provider))
            .with_safe_default_protocol_versions()?;
        let builder = if self.is_insecure {
            let verifier = AcceptAll(provider.signature_verification_algorithms);
            builder.dangerous().with_custom_certificate_verifier(Arc::new(verifier))
        } else {
            let mut store = RootCertStore::empty();
            store.add_parsable_certificates(self.roots().iter().cloned());
            builder.with_root_certificates(store)
        };
        Ok(builder.with_no_client_auth())
    }
}

impl fmt::Debug for Trust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = self.authorities.len();
        let mut shown = f.debug_struct("Trust");
        shown.field("authorities", &count).field("is_insecure", &self.is_insecure).finish_non_exhaustive()
    }
}

/// Reads the certificates of a PEM file.
fn read(path: &Path) -> Result<Vec<CertificateDer<'static>>, String> {
    let shown = terminal::path(path);
    let text =
        std::fs::read(path).map_err(|error| format!("{shown}: can't read the certificates: {error}"))?;
    let certificates: Result<Vec<_>, _> = CertificateDer::pem_slice_iter(&text).collect();
    let certificates = certificates.map_err(|error| format!("{shown}: invalid PEM: {error}"))?;
    if certificates.is_empty() {
        return Err(format!("{shown}: expected PEM certificates (BEGIN CERTIFICATE), found none"));
    }
    let mut store = RootCertStore::empty();
    for certificate in &certificates {
        store.add(certificate.clone()).map_err(|error| format!("{shown}: invalid certificate: {error}"))?;
    }
    Ok(certificates)
}

/// A connection over TLS.
pub(in crate::net) struct Wrapped(StreamOwned<ClientConnection, Timed>);

impl Wrapped {
    pub(in crate::net) fn timed(&mut self) -> &mut Timed {
        &mut self.0.sock
    }

    /// Tells the server that nothing more will be sent.
    pub(in crate::net) fn finish(&mut self) -> io::Result<()> {
        self.0.conn.send_close_notify();
        self.0.flush()
    }
}

impl Read for Wrapped {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.0.read(buffer) {
            // Many servers close a connection without the closing message of TLS.
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(0),
            read => read.map_err(explain),
        }
    }
}

impl Write for Wrapped {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(explain)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(explain)
    }
}

/// Completes the TLS handshake.
pub(in crate::net) fn wrap(mut timed: Timed, host: &str, trust: &Trust) -> io::Result<Wrapped> {
    let name = ServerName::try_from(host.to_owned()).map_err(|_| {
        io::Error::new(io::ErrorKind::InvalidInput, format!("{host} is not a valid host name for TLS"))
    })?;
    let mut connection = ClientConnection::new(trust.config()?, name).map_err(io::Error::other)?;
    while connection.is_handshaking() {
        connection.complete_io(&mut timed).map_err(|error| match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => io::Error::new(
                io::ErrorKind::TimedOut,
                "timed out: no TLS handshake in time; if the server doesn't use TLS, use a URL without it",
            ),
            io::ErrorKind::UnexpectedEof | io::ErrorKind::ConnectionReset => io::Error::new(
                io::ErrorKind::InvalidData,
                "the server ended the TLS handshake; if the server doesn't use TLS, use a URL without it",
            ),
            _ => explain(error),
        })?;
    }
    Ok(Wrapped(StreamOwned::new(connection, timed)))
}

/// Adds the cause and the remedy to a TLS error. Returns other errors unchanged.
pub fn explain(error: io::Error) -> io::Error {
    let Some(found) = error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) else {
        return error;
    };
    let text = match found {
        rustls::Error::InvalidCertificate(certificate) => explain_certificate(certificate),
        rustls::Error::InvalidMessage(_) => {
            "the server doesn't use TLS on this port: use a URL without TLS (tcp, http, socketio, ws)"
                .to_owned()
        }
        rustls::Error::AlertReceived(alert) => format!("the server refused the TLS handshake: {alert:?}"),
        other => format!("TLS error: {other}"),
    };
    io::Error::new(io::ErrorKind::InvalidData, text)
}

fn explain_certificate(error: &CertificateError) -> String {
    const IGNORE: &str = "or accept any certificate with --insecure";
    match error {
        CertificateError::UnknownIssuer => format!(
            "the server's certificate has an unknown issuer: name the issuer's certificate with --ca FILE, {IGNORE}"
        ),
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => format!(
            "the server's certificate has expired: renew it, check the clock of this computer, {IGNORE} ({error})"
        ),
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => format!(
            "the server's certificate is not valid yet: check the clock of this computer, {IGNORE} ({error})"
        ),
        CertificateError::NotValidForName => {
            format!("the server's certificate has another host name: use that name in the URL, {IGNORE}")
        }
        CertificateError::NotValidForNameContext { expected, presented } => format!(
            "the server's certificate is for {}, not for {}: use that name in the URL, {IGNORE}",
            if presented.is_empty() { "no host".to_owned() } else { presented.join(", ") },
            expected.to_str()
        ),
        other if format!("{other:?}").contains("CaUsedAsEndEntity") => format!(
            "the server's certificate is a CA certificate: create a certificate without CA:TRUE, {IGNORE}"
        ),
        other => format!("the server's certificate is invalid: {other}; correct it, {IGNORE}"),
    }
}
