//! Command lines, with escaped error messages.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue};
use clap::{Command, Parser};

use super::print::{finish, print, print_error};
use super::shown::shown;

/// Parses the arguments of the process. After `--help` or invalid arguments, prints the text and ends the process.
pub fn parse<P: Parser>() -> P {
    parse_as(P::command(), |_, value| value.to_owned())
}

/// Like [`parse`], for a command with changed texts. `redact` receives an argument and its invalid value, and returns
/// the value without secrets.
pub fn parse_as<P: Parser>(command: Command, redact: fn(&str, &str) -> String) -> P {
    let parsed = command.try_get_matches().and_then(|mut matches| P::from_arg_matches_mut(&mut matches));
    parsed.unwrap_or_else(|error| {
        let error = escaped(error, redact);
        let text = error.render().ansi().to_string();
        if error.use_stderr() {
            print_error(format_args!("{text}"));
        } else {
            print(format_args!("{text}"));
        }
        let code = match finish() {
            Err(error) => {
                print_error(format_args!("error: standard output: {error}\n"));
                2
            }
            Ok(()) => error.exit_code(),
        };
        std::process::exit(code)
    })
}

/// Escapes the arguments that an error message quotes, and removes secrets from invalid values.
fn escaped(mut error: clap::Error, redact: fn(&str, &str) -> String) -> clap::Error {
    let argument = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(argument)) => argument.clone(),
        _ => String::new(),
    };
    let quoted: Vec<(ContextKind, ContextValue)> = error
        .context()
        .filter_map(|(kind, value)| match value {
            ContextValue::String(text) if kind == ContextKind::InvalidValue => {
                Some((kind, ContextValue::String(shown(&redact(&argument, text)))))
            }
            ContextValue::String(text) => Some((kind, ContextValue::String(shown(text)))),
            ContextValue::Strings(texts) => {
                Some((kind, ContextValue::Strings(texts.iter().map(|text| shown(text)).collect())))
            }
            // Drop suggestions that repeat an argument with characters that can't be shown.
            ContextValue::StyledStrs(texts) => {
                let is_plain = |text: &&StyledStr| shown(&text.to_string()) == text.to_string();
                Some((kind, ContextValue::StyledStrs(texts.iter().filter(is_plain).cloned().collect())))
            }
            _ => None,
        })
        .collect();
    for (kind, value) in quoted {
        error.insert(kind, value);
    }
    error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_arguments_in_errors() {
        let command = || Command::new("uavspec").subcommand(Command::new("check"));
        for argument in ["a\n::error::b", "--\u{1b}[2J\n##[error]", "--x\u{202e}"] {
            let error = command().try_get_matches_from(["uavspec", argument]).expect_err("an error");
            let raw = error.render().ansi().to_string();
            assert!(raw.contains(argument), "the library doesn't escape: {raw:?}");
            let text = escaped(error, |_, value| value.to_owned()).render().ansi().to_string();
            assert!(
                !text.contains(['\u{202e}'])
                    && !text.contains("\u{1b}[2J")
                    && !text.contains("\n::")
                    && !text.contains("##["),
                "{text}"
            );
        }
    }
}
