//! Truncates and escapes texts from a server.

use uavspec_model::text::{shown, start_of};

/// The maximum length of a text, in characters.
const TEXT_LIMIT: usize = 80;

/// Truncates a text, and escapes its special characters, so that the terminal shows it on one line.
pub(super) fn truncated(text: &str) -> String {
    shown(&start_of(text, TEXT_LIMIT))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn truncated_text_is_short_and_harmless(text in any::<String>(), times in 1..50_usize) {
            let truncated = truncated(&text.repeat(times));
            // An escape sequence has at most ten characters.
            prop_assert!(truncated.chars().count() <= TEXT_LIMIT * 10 + 1);
            prop_assert!(!truncated.chars().any(char::is_control), "{truncated:?}");
        }
    }

    #[test]
    fn escapes_terminal_sequences() {
        assert_eq!(truncated("\u{1b}]0;glider\u{7}"), "\\u{1b}]0;glider\\u{7}");
        assert_eq!(truncated(&"é".repeat(TEXT_LIMIT + 1)), "é".repeat(TEXT_LIMIT) + "…");
    }
}
