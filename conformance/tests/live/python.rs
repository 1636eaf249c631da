//! Peers that are written in Python, and the probe.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;

/// The packages of the peers.
const REQUIREMENTS: &str = include_str!("requirements.txt");

/// A Python installation with the packages of the peers. The folder also contains a peer written in Rust.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        uavspec_test_support::python::python("live-peers", &REQUIREMENTS.lines().collect::<Vec<_>>())
    })
}

/// A running peer. Dropping it ends the peer.
pub(crate) struct Peer(Child);

impl Peer {
    /// Runs a script of `tests/live/peers` with these arguments and environment variables.
    pub(crate) fn start(script: &str, arguments: &[&str], environment: &[(&str, &str)]) -> Self {
        Self::run(&mut Self::command(script, arguments, environment))
    }

    /// The command that runs a script of `tests/live/peers`.
    pub(crate) fn command(script: &str, arguments: &[&str], environment: &[(&str, &str)]) -> Command {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live/peers").join(script);
        let mut command = Command::new(python());
        command.arg(path).args(arguments).envs(environment.iter().copied());
        command
    }

    /// Runs a program.
    pub(crate) fn run(command: &mut Command) -> Self {
        let child = command.stdin(Stdio::null()).spawn();
        Self(child.unwrap_or_else(|error| panic!("{command:?}: {error}")))
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
