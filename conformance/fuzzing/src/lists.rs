//! The targets for baselines.

use uavspec_check::baseline::{Checked, ListError, Lists, Name, Outcome, Scope};
use uavspec_rules::px4;
use uavspec_schema::Date;
use uavspec_schema::diagnostic::Level;

use super::Choices;

/// The day of all runs.
const TODAY: Date = Date { year: 2026, month: 5, day: 9 };

/// Reads a list. Each finding must be within the list, and a fixed list must be valid and have nothing left to fix.
pub(super) fn known_failures(data: &[u8]) {
    let lists = match Lists::parse([("known.toml".to_owned(), data.to_vec())]) {
        Ok(lists) => lists,
        Err(ListError::Mistaken(findings, sources)) => {
            assert!(!findings.is_empty());
            for finding in findings.iter().filter(|_| std::str::from_utf8(data).is_ok()) {
                let source = sources.source_of(finding.span);
                assert!(
                    sources.span(source).start <= finding.span.start
                        && finding.span.end <= sources.span(source).end
                );
                // Panics within a character.
                let _ = sources.slice(finding.span);
            }
            assert!(!ListError::Mistaken(findings, sources).to_string().is_empty());
            return;
        }
        Err(error) => panic!("{error}"),
    };
    let checked = [
        Checked { name: Name::Case("decode-cdr/px4/Event/typical"), outcome: Outcome::Passed },
        Checked { name: Name::Case("decode-cdr/px4/Event/null"), outcome: failure() },
        Checked {
            name: Name::Rule { rule: &px4::DATA_01.rule, subject: "event".into(), file: "a/b.ulg" },
            outcome: failure(),
        },
    ];
    for scope in [Scope::Cases, Scope::Rules] {
        let stale = lists.find_stale(scope, &checked, TODAY);
        assert_eq!(lists.reasons(&stale).len(), stale.len());
        assert_eq!(lists.render(&stale, Level::Error, false).is_empty(), stale.is_empty());
        let fixed = lists.fixed(&stale).unwrap_or_else(|error| panic!("the fix is invalid: {error}"));
        let left = fixed.find_stale(scope, &checked, TODAY);
        assert!(left.iter().all(|stale| !stale.is_fixable()), "{left:?} is left");
    }
}

/// The keys of an entry, each with values. The first value of each key is valid.
const KEYS: [(&str, &[&str]); 8] = [
    ("rule", &["\"PX-DATA-01\"", "\"FW-ENV-18\"", "\"PX-DATA-99\"", "\"\"", "7"]),
    ("subject", &["\"event\"", "\"*\"", "'/kite/{event,wind}[12].x?'", "\"[\"", "\"\"", "7"]),
    ("file", &["\"a/*.ulg\"", "\"**\"", "'a\\b.ulg'", "\"{\"", "true"]),
    (
        "case",
        &["\"decode-cdr/px4/Event/null\"", "\"decode-*/px4/Event/*\"", "\"*\"", "\"[a-\"", "\"\"", "[]"],
    ),
    ("reason", &["\"wind\"", "'''\nwind'''", "\"[[known]]\"", "\" \"", "\"\\u0007\"", "{}"]),
    ("link", &["\"https://hill.invalid\"", "\"\\n\"", "7"]),
    (
        "expires",
        &["2027-06-30", "2020-01-01", "0000-01-01", "2027-06-30T00:00:00Z", "07:32:00", "\"2027-06-30\""],
    ),
    ("message", &["\"/flaps\"", "\"/wings\"", "\"\"", "\"é𝄞\"", "7"]),
];

/// The keys of entries. Most entries name their results in one way.
const ENTRIES: [&[&str]; 5] = [
    &["rule", "reason", "expires", "subject", "file", "link", "message"],
    &["case", "reason", "message", "expires", "link"],
    &["case", "reason"],
    &["message", "reason", "rule"],
    &["rule", "case", "reason", "subject"],
];

/// A list that the bytes select. Keys may be missing or have invalid values.
fn written(data: &[u8]) -> String {
    let mut choices = Choices::new(data);
    let mut text = String::new();
    for _ in 0..=choices.below(4) {
        let header = choices.of(&["[[known]]", "[[flaky]]", "# wind\n\n  [[known]]", "[known]", "[[odd]]"]);
        let end = choices.of(&["\n", "\n", " # [[known]]\n", "\r\n"]);
        text = text + header + end;
        let names = choices.of(&ENTRIES);
        for (key, values) in names.iter().flat_map(|name| KEYS.iter().filter(move |(key, _)| key == name)) {
            let value = match choices.below(8) {
                0..=4 => values[0],
                5 => continue,
                _ => choices.of(values),
            };
            text = text + key + " = " + value + end;
        }
    }
    text
}

/// Reads a list that follows the grammar, like [`known_failures`].
pub(super) fn grammar(data: &[u8]) {
    known_failures(written(data).as_bytes());
}

fn failure() -> Outcome {
    Outcome::Failed(vec!["/flaps/0: expected NaN".to_owned()])
}

pub(super) fn known_failure_seeds() -> Vec<Vec<u8>> {
    let texts = [
        "# a list\n[[known]]\ncase = \"decode-*/px4/Event/*\"\nreason = \"flaps\"\nexpires = 2027-06-30\n",
        "[[flaky]]\nrule = \"PX-DATA-01\"\nsubject = \"event\"\nfile = \"*/b.ulg\"\nreason = \"wind\"\nmessage = \"/flaps\"\n",
        "[[known]]\nrule = \"PX-DATA-01\"\nreason = \"wind\"\nlink = \"https://example.org\"\n\n[[known]]\ncase = \"a\"\n",
        "[[known]]\ncase = 'decode-cdr/px4/Event/null'\nreason = 'x'\nmessage = '/flaps/1'\nexpires = 2020-01-01\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_first_values_of_the_grammar_are_valid() {
        for entry in 0..2 {
            let text = written(&[0, 0, 0, entry]);
            let lists = Lists::parse([("known.toml".to_owned(), text.clone().into_bytes())]);
            assert!(lists.is_ok_and(|lists| !lists.is_empty()), "{text}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn random_baselines_have_nothing_left_to_fix(data in prop::collection::vec(any::<u8>(), 0..60)) {
            grammar(&data);
        }
    }
}
