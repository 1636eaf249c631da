//! The target for baselines.

use crate::check::known::{Checked, ListError, Lists, Name, Outcome, Scope};
use crate::model::Date;
use crate::rules::px4;
use uavspec_codegen::diagnostic::Level;

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
