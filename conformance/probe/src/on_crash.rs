//! The command of the user that restarts a server that stopped serving.

use std::process::{Child, Command, Stdio};

/// A running command.
pub(super) struct OnCrash(Result<Child, String>);

impl OnCrash {
    /// Starts a command in the shell. The command may stay in the foreground, as a server does, so nothing waits for its
    /// end. Its output goes to standard error.
    pub(super) fn start(text: &str) -> Self {
        let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        let mut command = Command::new(shell);
        command.args([option, text]).stdin(Stdio::null()).stdout(std::io::stderr());
        Self(command.spawn().map_err(|error| format!("--on-crash: can't run {shell}: {error}")))
    }

    /// The problem of a command that could not be started, or that failed.
    pub(super) fn problem(&mut self) -> Option<String> {
        match &mut self.0 {
            Err(problem) => Some(problem.clone()),
            Ok(child) => {
                let status = child.try_wait().ok()?.filter(|status| !status.success())?;
                Some(format!("--on-crash: the command failed: {status}"))
            }
        }
    }
}
