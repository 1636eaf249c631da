//! Runs the user's command for restarting a server that has stopped serving.

use std::process::{Child, Command, Stdio};

/// A running command.
pub(super) struct OnCrash(Result<Child, String>);

impl OnCrash {
    /// Starts a shell command. Doesn't wait for it, because the command may stay in the foreground like a server. Its
    /// output goes to standard error.
    pub(super) fn start(text: &str) -> Self {
        let (shell, option) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        let mut command = Command::new(shell);
        command.args([option, text]).stdin(Stdio::null()).stdout(std::io::stderr());
        Self(command.spawn().map_err(|error| format!("--on-crash: can't run {shell}: {error}")))
    }

    /// The problem with a command that couldn't be started, or that failed. `None` if there is no problem.
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
