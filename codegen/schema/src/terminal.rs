//! Untrusted text in terminals and logs: names and contents of files, arguments, and responses of servers.
//!
//! Such text may contain terminal sequences, direction changes, or commands that CI systems execute when they find them
//! in a log. [`shown()`] escapes a text for use within a line. [`Guard`] and [`guarded`] are the last defence for a
//! whole output: they can't escape line breaks, because line breaks are part of the output.

mod command;
mod guard;
mod parse;
mod print;
mod shown;

pub(crate) use self::command::Command;
pub use self::guard::{Guard, guarded};
pub use self::parse::{parse, parse_as};
pub use self::print::{
    error, error_with_details, finish, print, print_error, print_unguarded, stderr, stdout,
};
pub use self::shown::{MAX_SHOWN, path, shown};

/// Like `std::println`, with a guarded output.
#[doc(hidden)]
#[macro_export]
macro_rules! __println {
    ($($argument:tt)*) => {
        $crate::terminal::print(::std::format_args!("{}\n", ::std::format_args!($($argument)*)))
    };
}
#[doc(inline)]
pub use __println as println;

/// Like `std::eprintln`, with a guarded output.
#[doc(hidden)]
#[macro_export]
macro_rules! __eprintln {
    ($($argument:tt)*) => {
        $crate::terminal::print_error(::std::format_args!("{}\n", ::std::format_args!($($argument)*)))
    };
}
#[doc(inline)]
pub use __eprintln as eprintln;
