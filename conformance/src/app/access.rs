//! The options for logins and certificates.

use std::path::{Path, PathBuf};

use clap::Args;
use uavspec_model::net::tls::Trust;
use uavspec_model::text::terminal;

use super::serve::login;
use super::{Status, first_given};

/// Arguments of commands that connect to a server.
#[derive(Args, Debug)]
pub(super) struct AccessArgs {
    /// Log in with HTTP Basic and with AUTH-REQ, method basic.
    #[arg(long, value_name = "NAME:PASSWORD", value_parser = login)]
    pub(super) login: Option<(String, String)>,
    /// Also trust the certificates in this PEM file.
    ///
    /// The certificates of the operating system are always trusted.
    #[arg(long, value_name = "FILE")]
    ca: Option<PathBuf>,
    /// Accept any certificate.
    ///
    /// Anyone on the network can then read and change all messages, including the login.
    #[arg(long)]
    insecure: bool,
}

impl AccessArgs {
    /// The files that these arguments name.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.ca.as_deref().into_iter()
    }

    /// The first of these options that is given.
    pub(super) fn given(&self) -> Option<&'static str> {
        first_given(&[
            ("--login", self.login.is_some()),
            ("--ca", self.ca.is_some()),
            ("--insecure", self.insecure),
        ])
    }

    /// The trusted certificates. Prints errors.
    pub(super) fn trust(&self) -> Result<Trust, Status> {
        if self.insecure {
            terminal::eprintln!("warning: any certificate is accepted (--insecure)");
        }
        Trust::new(self.ca.as_deref(), self.insecure).map_err(|error| Status::Usage.because(error))
    }
}
