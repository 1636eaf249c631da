//! Tests of automatic fixes.

use std::fmt::Write as _;

use proptest::collection::vec;
use proptest::prelude::*;
use uavspec_test_definitions::extent;

use super::*;

#[test]
fn removes_an_entry_with_its_comments_and_nothing_else() {
    let text = "\
# Known failures of our gliders.
[[known]]
case = \"a\"
reason = \"first\" # as ever
# note on the first

# Separate comment.

# note on the second
  [[known]] # more
  # inside
reason = \"second\"
case = \"b\"
message = '''
b

# no comment'''
# before the third
[[known]]
case = \"c\"
reason = \"third\"";
    let names = ["a", "b", "c"];
    let fixed = |passing: &[&str]| {
        let list = list(text);
        let outcome = |name: &str| {
            if passing.contains(&name) {
                Outcome::Passed
            } else {
                failed(&format!("{name}\n\n# no comment, and more"))
            }
        };
        let checked: Vec<_> = names.iter().map(|name| case(name, outcome(name))).collect();
        let fixed = super::fixed(&list, &list.find_stale(CASE, &checked, TODAY));
        fixed.texts().collect::<String>()
    };
    assert_eq!(fixed(&names), "# Known failures of our gliders.\n\n# Separate comment.\n");
    let second = text.find("# note on the second").expect("a comment");
    let third = text.find("# before the third").expect("a comment");
    let head = "# Known failures of our gliders.\n\n# Separate comment.\n\n";
    assert_eq!(fixed(&["a", "c"]), head.to_owned() + &text[second..third]);
    assert_eq!(fixed(&["b"]), text[..second].to_owned() + &text[third..]);
    assert_eq!(fixed(&[]), text);
}

/// The text of an entry, and the results of the cases that it matches.
#[derive(Clone, Debug)]
struct Sample {
    text: String,
    is_stale: bool,
    outcomes: Vec<Outcome>,
}

fn sample() -> impl Strategy<Value = Sample> {
    let failed = vec("[a-c\"\\\\\n\u{7f}é]{0,6}", 1..3).prop_map(Outcome::Failed);
    let outcome = prop_oneof![
        Just(Outcome::Passed),
        Just(Outcome::Idle),
        Just(Outcome::NotRun),
        failed.clone(),
        failed,
    ];
    let (above, inside) = ("(# [a-z]{0,5}\n){0,2}", "(|# in\n|\n)");
    let parts = (any::<bool>(), 0..4, above, inside, "(|\n|# below\n|\n# set apart\n\n)");
    let message = proptest::option::of("[a-c]{0,2}");
    (parts, message, vec(outcome, 0..4)).prop_map(
        |((is_known, age, above, inside, below), message, outcomes)| {
            let kind = if is_known { "known" } else { "flaky" };
            let mut text = format!("{above}[[{kind}]]\ncase = \"NAME*\" # so\n{inside}reason = \"it is\"\n");
            if let Some(message) = &message {
                // Writing to a string can't fail.
                let _ = writeln!(text, "message = '{message}' # begins");
            }
            let is_over = age == 0;
            text += if is_over { "expires = 2026-05-08\n" } else { "expires = 2026-05-09\n" };
            let may_fail = |outcome: &Outcome| matches!(outcome, Outcome::Failed(_) | Outcome::NotRun);
            let may_pass = !is_known && outcomes.contains(&Outcome::Passed);
            let is_stale = is_over || !outcomes.iter().any(may_fail) && !may_pass;
            Sample { text: text + &below, is_stale, outcomes }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(extent(256, 96)))]

    /// Entries that aren't stale stay unchanged, byte for byte. Only entries that a person must fix remain stale.
    #[test]
    fn a_fixed_list_has_no_stale_entries(samples in vec(sample(), 0..6), is_dos in any::<bool>()) {
        let line_end = if is_dos { "\r\n" } else { "\n" };
        let named = |(at, sample): (usize, &Sample)| {
            sample.text.replace("NAME", &format!("case-{at}/")).replace('\n', line_end)
        };
        let texts: Vec<String> = samples.iter().enumerate().map(named).collect();
        let text = format!("# head{line_end}{line_end}{}", texts.concat());
        let outcomes = |(at, sample): (usize, &Sample)| {
            let outcomes = sample.outcomes.clone().into_iter().enumerate();
            outcomes.map(move |(number, outcome)| (format!("case-{at}/{number}"), outcome)).collect::<Vec<_>>()
        };
        let outcomes: Vec<(String, Outcome)> = samples.iter().enumerate().flat_map(outcomes).collect();
        let checked: Vec<Checked<'_>> = outcomes.iter().map(|(name, outcome)| case(name, outcome.clone())).collect();
        let list = list(&text);
        let stale = list.find_stale(CASE, &checked, TODAY);
        let fixed = fixed(&list, &stale);
        let left = fixed.find_stale(CASE, &checked, TODAY);
        prop_assert!(left.iter().all(|finding| finding.fix.is_empty()), "{:?}", left);
        prop_assert!(left.len() <= stale.iter().filter(|finding| finding.fix.is_empty()).count());
        let new: String = fixed.texts().collect();
        prop_assert_eq!(new.matches("[[").count(), samples.iter().filter(|sample| !sample.is_stale).count());
        prop_assert_eq!(new.matches("# set apart").count(), text.matches("# set apart").count());
        let is_same = stale.is_empty();
        prop_assert!(!is_same || new == text);
        let mut rest = new.as_str();
        prop_assert!(rest.starts_with("# head"));
        for (at, (text, _)) in texts.iter().zip(&samples).enumerate().filter(|(_, (_, sample))| !sample.is_stale) {
            let body = &text[text.find("[[").expect("a header")..text.find("2026").expect("a date") + 10];
            // The pattern and the message may change.
            let (before, body) = body.split_once(&format!("\"case-{at}/*\"")).expect("a pattern");
            let mut parts = vec![before];
            match body.split_once("message = '") {
                Some((before, after)) => parts.extend([before, after.split_once('\'').expect("an end").1]),
                None => parts.push(body),
            }
            for part in parts {
                let found = rest.find(part);
                prop_assert!(found.is_some(), "{part:?} of {text:?} in {new:?}");
                rest = &rest[found.unwrap_or_default() + part.len()..];
            }
        }
    }
}
