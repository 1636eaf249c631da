//! Printing to the terminal. All output of the programs passes through these functions.

use std::fmt::{self, Display, Write as _};
use std::io::{self, Write};
use std::sync::{Mutex, PoisonError};

use super::guard::{ESCAPE, Guard};
use super::shown::shown_up_to;

/// The maximum length of an error message, in characters. A message may contain several paths.
const MAX_PROBLEM: usize = 20_000;

/// The first error in printing to standard output.
static UNPRINTED: Mutex<Option<io::Error>> = Mutex::new(None);

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

/// Prints to standard output. It is not an error if the reader closes the pipe early. [`finish`] returns other errors.
pub fn print(text: fmt::Arguments<'_>) {
    let text = text.to_string();
    // Only styles must be removed.
    if text.contains(ESCAPE) {
        print_to(stdout(), &text);
    } else {
        print_to(Guard::new(io::stdout()), &text);
    }
}

/// Prints a machine-readable text to standard output, like [`print()`]. The text isn't guarded.
pub fn print_unguarded(text: &str) {
    print_to(io::stdout(), text);
}

fn print_to(mut output: impl Write, text: &str) {
    let written = output.write_all(text.as_bytes()).and_then(|()| output.flush());
    if let Err(error) = written
        && error.kind() != io::ErrorKind::BrokenPipe
    {
        UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Ends printing. A program that returns success has printed everything.
///
/// # Errors
/// Fails if a text could not be printed to standard output, for example because a disk is full.
pub fn finish() -> io::Result<()> {
    UNPRINTED.lock().unwrap_or_else(PoisonError::into_inner).take().map_or(Ok(()), Err)
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

/// Prints a problem, followed by help or by marked lines of untrusted text.
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
