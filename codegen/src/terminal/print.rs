//! Printing to the terminal. All output of the programs passes through these functions.

use std::fmt::{self, Display, Write as _};
use std::io::{self, Write as _};
use std::sync::OnceLock;

#[cfg(feature = "cli")]
use super::guard::GuardedLines;
use super::guard::{ESCAPE, Guard};
use super::shown::shown_up_to;

/// The maximum length of an error message, in characters. It may contain several paths.
const MAX_PROBLEM: usize = 20_000;

/// Standard output, with colours if the terminal supports them.
#[allow(clippy::disallowed_methods, reason = "it is guarded here")]
pub fn stdout() -> Guard<anstream::AutoStream<io::Stdout>> {
    Guard::new(anstream::stdout())
}

/// Standard error, with colours if the terminal supports them.
#[allow(clippy::disallowed_methods, reason = "it is guarded here")]
pub fn stderr() -> Guard<anstream::AutoStream<io::Stderr>> {
    Guard::new(anstream::stderr())
}

/// The first error of standard output in this process.
static LOST: OnceLock<String> = OnceLock::new();

/// Prints to standard output. [`lost_output`] returns the error.
pub fn print(text: fmt::Arguments<'_>) {
    let text = text.to_string();
    // Only styles must be removed.
    note_output(if text.contains(ESCAPE) {
        stdout().write_all(text.as_bytes())
    } else {
        Guard::new(io::stdout()).write_all(text.as_bytes())
    });
}

/// Keeps the error of a write to standard output. It is not an error if the reader closes the pipe early.
pub(crate) fn note_output(written: io::Result<()>) {
    if let Err(error) = written
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        let _ = LOST.set(error.to_string());
    }
}

/// The error if a part of the output of this process is lost, for example because the disk is full.
#[cfg(feature = "cli")]
pub(crate) fn lost_output() -> Option<&'static str> {
    note_output(io::stdout().flush());
    LOST.get().map(String::as_str)
}

/// Prints guarded lines to standard output, like [`print`].
#[cfg(feature = "cli")]
#[allow(clippy::disallowed_methods, reason = "the lines are guarded")]
pub(crate) fn print_lines(parts: &[GuardedLines]) {
    let write =
        |to: &mut dyn io::Write| parts.iter().try_for_each(|part| to.write_all(part.text().as_bytes()));
    // Only styles must be removed.
    note_output(if parts.iter().any(|part| part.text().contains(ESCAPE)) {
        write(&mut anstream::stdout())
    } else {
        write(&mut io::stdout())
    });
}

/// Prints to standard error. A message that can't be printed is lost.
pub fn print_error(text: fmt::Arguments<'_>) {
    let _ = stderr().write_all(text.to_string().as_bytes());
}

/// Prints a problem to standard error, and the help for it on a second line. Both may contain untrusted text.
pub fn error(problem: impl Display, help: Option<&str>) {
    let mut text = format!("error: {}\n", shown_up_to(MAX_PROBLEM, &problem.to_string()));
    if let Some(help) = help {
        // Writing to a `String` can't fail.
        let _ = writeln!(text, "  help: {}", shown_up_to(MAX_PROBLEM, help));
    }
    print_error(format_args!("{text}"));
}

/// Prints a problem with help or with lines of untrusted text below it, which are marked.
pub fn error_with_details(problem: impl Display) {
    let problem = problem.to_string();
    let lines = problem.lines().enumerate().map(|(index, line)| {
        let start = match index {
            0 => "error: ",
            _ if line.starts_with("  help: ") => "",
            _ => "  | ",
        };
        format!("{start}{}\n", shown_up_to(MAX_PROBLEM, line))
    });
    print_error(format_args!("{}", lines.collect::<String>()));
}
