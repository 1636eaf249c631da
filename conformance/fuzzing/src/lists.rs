//! The targets for baselines.

use uavspec_check::baseline::{finding_name, rule_ids};
use uavspec_lint::baseline::{Lists, Name, Outcome};
use uavspec_rules::px4;
use uavspec_schema::Date;
use uavspec_schema::finding::Finding;

use super::definitions::grammar::{self, Table};

/// The date on which all runs take place.
const TODAY: Date = Date { year: 2026, month: 5, day: 9 };

/// Reads a baseline. Each reported mistake must be within the baseline. An updated baseline must be valid, and have
/// nothing left to fix.
pub(super) fn baseline(data: &[u8]) {
    let lists = match Lists::parse([("known.toml".to_owned(), data.to_vec())], &rule_ids()) {
        Ok(lists) => lists,
        Err(mistakes) => {
            assert!(!mistakes.findings.is_empty() && !mistakes.to_string().is_empty());
            for finding in mistakes.findings.iter().filter(|_| std::str::from_utf8(data).is_ok()) {
                assert!(mistakes.sources.contains(finding.span), "{finding:?}");
            }
            return;
        }
    };
    let results = [
        (Name::case("decode-cdr/px4/Event/typical"), Outcome::Passed),
        (Name::case("decode-cdr/px4/Event/null"), failure()),
        (finding_name(&px4::DATA_01.rule, "event".into(), "a/b.ulg"), failure()),
        (Name { forms: vec!["px4/Wind".into()], ..Name::rule("unit-missing", "Wind.msg") }, failure()),
    ];
    for results in [&results[..], &[]] {
        let stale = |lists: &Lists| {
            let mut stale = lists.find_stale(&|_| true, results, TODAY);
            stale.retain(|finding| !finding.fix.is_empty());
            stale
        };
        let update = |lists: &Lists, stale: &[Finding]| {
            lists.updated(stale).unwrap_or_else(|error| panic!("the fix is invalid: {error}"))
        };
        let mut found = stale(&lists);
        let mut fixed = update(&lists, &found);
        // If an entry is removed, its findings may count for an entry with a count.
        for _ in 0..data.len() {
            found = stale(&fixed);
            if found.is_empty() {
                break;
            }
            fixed = update(&fixed, &found);
        }
        assert!(found.is_empty(), "{found:?} is left");
        assert!(!results.is_empty() || fixed.is_empty());
    }
}

/// A key of an entry, with its possible values. The first value is valid.
type Key = (&'static str, &'static [&'static str]);

const RULE: Key =
    ("rule", &["\"unit-missing\"", "\"PX-DATA-01\"", "\"field-removed\"", "\"PX-DATA-99\"", "\"\"", "7"]);

const SUBJECT: Key =
    ("subject", &["\"event\"", "\"*\"", "'px4/{Wind,Mark}[12].x?'", "\"[\"", "\"\\\\\"", "\"\"", "7"]);

const COUNT: Key = ("count", &["1", "0", "-1", "0x10", "99999999999999999999", "\"1\""]);

const FILE: Key = ("file", &["\"a/*.ulg\"", "\"**\"", "'a\\b.ulg'", "\"{\"", "true"]);

const CASE: Key = (
    "case",
    &["\"decode-cdr/px4/Event/null\"", "\"decode-*/px4/Event/*\"", "\"*\"", "\"[a-\"", "\"\"", "[]"],
);

const REASON: Key = ("reason", &["\"wind\"", "'''\nwind'''", "\"[[known]]\"", "\" \"", "\"\\u0007\"", "{}"]);

const LINK: Key = ("link", &["\"https://hill.invalid\"", "\"\\n\"", "7"]);

const EXPIRES: Key = (
    "expires",
    &["2027-06-30", "2020-01-01", "0000-01-01", "2027-06-30T00:00:00Z", "07:32:00", "\"2027-06-30\""],
);

const MESSAGE: Key = ("message", &["\"/flaps\"", "\"/wings\"", "\"\"", "\"é𝄞\"", "7"]);

/// Possible entries. The first entries are valid if all of their values are.
const ENTRIES: [Table; 7] = [
    ("[[known]]", &[RULE, SUBJECT, COUNT, REASON]),
    ("# wind\n\n  [[known]]", &[RULE, REASON, EXPIRES, SUBJECT, FILE, LINK, MESSAGE]),
    ("[[flaky]] # [[known]]", &[CASE, REASON, MESSAGE, EXPIRES, LINK]),
    ("[[known]]\r", &[CASE, REASON]),
    ("[[known]]", &[MESSAGE, REASON, RULE]),
    ("[[odd]]", &[RULE, CASE, REASON, SUBJECT]),
    ("[known]", &[CASE, REASON]),
];

/// Reads a baseline that follows the grammar, like [`baseline`].
pub(super) fn grammar(data: &[u8]) {
    baseline(grammar::text(&ENTRIES, data).as_bytes());
}

fn failure() -> Outcome {
    Outcome::Failed(vec!["/flaps/0: expected NaN".to_owned()])
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let texts = [
        "# a list\n[[known]]\ncase = \"decode-*/px4/Event/*\"\nreason = \"flaps\"\nexpires = 2027-06-30\n",
        "[[flaky]]\nrule = \"PX-DATA-01\"\nsubject = \"event\"\nfile = \"*/b.ulg\"\nreason = \"wind\"\nmessage = \"/flaps\"\n",
        "[[known]]\nrule = \"PX-DATA-01\"\nreason = \"wind\"\nlink = \"https://example.org\"\n\n[[known]]\ncase = \"a\"\n",
        "[[known]]\nrule = \"unit-missing\"\nsubject = \"px4/*\"\ncount = 2\nreason = \"old\"\n",
        "[[known]]\ncase = 'decode-cdr/px4/Event/null'\nreason = 'x'\nmessage = '/flaps/1'\nexpires = 2020-01-01\n",
    ];
    texts.map(|text| text.as_bytes().to_vec()).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_values_of_the_grammar_are_valid() {
        for (at, (_, keys)) in (0..3).zip(ENTRIES) {
            // The first byte selects the entry. The other bytes select the first value of each key.
            let mut data = vec![64; 1 + keys.len()];
            data[0] = at;
            let text = grammar::text(&ENTRIES, &data);
            let lists = Lists::parse([("known.toml".to_owned(), text.clone().into_bytes())], &rule_ids());
            assert!(lists.is_ok_and(|lists| !lists.is_empty()), "{text}");
        }
    }
}
