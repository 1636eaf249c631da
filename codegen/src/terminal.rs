//! Untrusted text in terminals and logs: names and contents of files, arguments, and responses of servers.
//!
//! Such text may contain terminal sequences, direction changes, or commands that CI systems execute when they find them
//! in a log. [`shown()`] escapes a text for use within a line. [`Guard`] and [`guarded`] are the last defence for a whole
//! output: they can't escape line breaks, because those are part of the output.

mod command;
mod guard;
#[cfg(feature = "print")]
mod parse;
#[cfg(feature = "print")]
mod print;
mod shown;

pub(crate) use self::command::Command;
#[cfg(feature = "cli")]
pub(crate) use self::guard::GuardedLines;
pub use self::guard::{Guard, guarded};
#[cfg(feature = "print")]
pub use self::parse::{parse, parse_as};
#[cfg(feature = "print")]
pub use self::print::{error, error_with_details, print, print_error, stderr, stdout};
#[cfg(feature = "cli")]
pub(crate) use self::print::{lost_output, note_output, print_lines};
pub use self::shown::{MAX_SHOWN, path, shown};

/// Like `std::println`, with a guarded output.
#[cfg(feature = "print")]
#[doc(hidden)]
#[macro_export]
macro_rules! __println {
    ($($argument:tt)*) => {
        $crate::terminal::print(::std::format_args!("{}\n", ::std::format_args!($($argument)*)))
    };
}
#[cfg(feature = "print")]
#[doc(inline)]
pub use __println as println;

/// Like `std::eprintln`, with a guarded output.
#[cfg(feature = "print")]
#[doc(hidden)]
#[macro_export]
macro_rules! __eprintln {
    ($($argument:tt)*) => {
        $crate::terminal::print_error(::std::format_args!("{}\n", ::std::format_args!($($argument)*)))
    };
}
#[cfg(feature = "print")]
#[doc(inline)]
pub use __eprintln as eprintln;
