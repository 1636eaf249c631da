//! The options that affect the outcome.

use clap::Args;
use uavspec_report::Settings;

/// Arguments of commands that check captures or sessions.
#[derive(Args, Debug)]
pub(super) struct OutcomeArgs {
    /// Violations that make the run fail: `error` for MUST rules, `warning` for SHOULD rules as well.
    #[arg(long, value_name = "LEVEL", default_value = "error", value_parser = ["warning", "error"], hide_possible_values = true)]
    deny: String,
    /// Minimum coverage, such as 90%.
    ///
    /// If a smaller percentage of the topics or types in a file is fully checked, the outcome of this file is incomplete.
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    min_coverage: Option<f64>,
    /// Exit with status 0 instead of 6 if the outcome is incomplete.
    ///
    /// The reports still contain the reasons.
    #[arg(long)]
    allow_incomplete: bool,
}

/// Parses a percentage from 0 to 100.
fn percent(text: &str) -> Result<f64, &'static str> {
    let number: Option<f64> = text.strip_suffix('%').unwrap_or(text).parse().ok();
    let percent = number.filter(|percent| (0.0..=100.0).contains(percent));
    percent.ok_or("expected a percentage from 0 to 100, such as 90%")
}

impl OutcomeArgs {
    /// The settings of reports.
    pub(super) fn settings(&self) -> Settings {
        Settings {
            are_warnings_denied: self.deny == "warning",
            min_coverage: self.min_coverage,
            allows_incomplete: self.allow_incomplete,
            ..Settings::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_percentages() {
        for (text, expected) in [("90%", 90.0), ("0", 0.0), ("99.5%", 99.5), ("100%", 100.0)] {
            assert_eq!(percent(text), Ok(expected), "{text}");
        }
        for wrong in ["", "%", "101", "-1%", "NaN", "much"] {
            assert!(percent(wrong).is_err(), "{wrong}");
        }
    }
}
