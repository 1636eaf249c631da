//! `uavspec explain`.

mod word;

use clap::Args;

use self::word::explain_words;
use super::{Format, Status};

/// Arguments of `explain`.
#[derive(Args, Debug)]
#[command(after_help = word::EXAMPLES, after_long_help = format!("{}\n\n{}", word::EXAMPLES, word::STATUS))]
pub(super) struct ExplainArgs {
    /// Words to explain.
    ///
    /// A word is an error code or its abbreviation, a topic, a message, a field, a value of a field, a constant, a
    /// uORB message hash, a ROS type hash, or a rule. A name that several messages use lists all of them.
    #[arg(required = true, value_name = "WHAT")]
    what: Vec<String>,
    /// Explain by one release only, such as px4@1.16 (default: all).
    #[arg(long, value_name = "RELEASE")]
    release: Option<String>,
    /// Output format: text or json.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: Format,
}

/// Runs `uavspec explain`.
pub(super) fn explain(args: &ExplainArgs) -> Status {
    explain_words(&args.what, args.release.as_deref(), args.format)
}
