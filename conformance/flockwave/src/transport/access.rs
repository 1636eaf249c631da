//! The credentials of a client, and the certificates that it trusts.

use std::fmt;

use uavspec_model::json::base64;
use uavspec_model::net::tls::Trust;

use super::secrets::Secrets;

/// The credentials of a client, and the certificates that it trusts. By default, there are no credentials, and the
/// operating system's certificates are trusted.
#[derive(Clone, Default)]
pub struct Access {
    login: Option<(String, String)>,
    trust: Trust,
}

impl Access {
    /// Uses this name and password for HTTP Basic authentication, and trusts these certificates for connections over
    /// TLS.
    pub fn new(login: Option<(String, String)>, trust: Trust) -> Self {
        Self { login, trust }
    }

    /// The trusted certificates, if the connection uses TLS.
    pub(super) fn trust(&self, is_encrypted: bool) -> Option<&Trust> {
        is_encrypted.then_some(&self.trust)
    }

    /// The secrets of a connection to a path with an optional query.
    pub fn secrets(&self, path: &str) -> Secrets {
        Secrets::new(self.login.as_ref(), path)
    }

    /// The value of the header `Authorization`.
    pub(super) fn authorization(&self) -> Option<String> {
        let (name, password) = self.login.as_ref()?;
        Some(format!("Basic {}", base64::encode(format!("{name}:{password}").as_bytes())))
    }
}

impl fmt::Debug for Access {
    /// Hides the password.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.login.as_ref().map(|(name, _)| name);
        f.debug_struct("Access").field("name", &name).field("trust", &self.trust).finish_non_exhaustive()
    }
}
