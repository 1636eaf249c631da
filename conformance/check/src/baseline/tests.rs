//! Tests of excused failures and stale entries.

mod fix;
mod read;

use uavspec_rules::{RULES, rule};
use uavspec_schema::Date;

use super::*;

const TODAY: Date = Date { year: 2026, month: 5, day: 9 };

pub(super) fn list(text: &str) -> Lists {
    parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn parse(text: &str) -> Result<Lists, ListError> {
    Lists::parse([("known.toml".to_owned(), text.as_bytes().to_vec())])
}

fn case(name: &str, outcome: Outcome) -> Checked<'_> {
    Checked { name: Name::Case(name), outcome }
}

fn of_rule<'r>(id: &str, subject: &'r str, file: &'r str, outcome: Outcome) -> Checked<'r> {
    let rule = rule(id).expect("a rule");
    Checked { name: Name::Rule { rule, subject: subject.into(), file }, outcome }
}

fn failed(message: &str) -> Outcome {
    Outcome::Failed(vec![message.to_owned()])
}

fn reasons(lists: &Lists, scope: Scope, checked: &[Checked<'_>]) -> Vec<StaleReason> {
    lists.find_stale(scope, checked, TODAY).into_iter().map(|stale| stale.reason).collect()
}

const CASES: &str = "\
[[known]]
case = \"decode-*/soaring/Glider/*\"
reason = \"flaps come in the wrong order\"
";

#[test]
fn a_listed_failure_is_excused_and_its_entry_is_not_stale() {
    let list = list(CASES);
    let checked = [
        case("decode-cdr/soaring/Glider/flaps-nan", failed("/flaps/0: expected NaN")),
        case("decode-uorb/soaring/Glider/flaps-nan", Outcome::Idle),
        case("decode-cdr/soaring/Mark/typical", failed("/height: expected 1")),
    ];
    assert_eq!(reasons(&list, Scope::Cases, &checked), []);
    let excuse = |checked: &Checked<'_>| match &checked.outcome {
        Outcome::Failed(messages) => list.excuse(checked.name, messages).map(ToString::to_string),
        _ => None,
    };
    let excuses = checked.iter().map(excuse).collect::<Vec<_>>();
    assert_eq!(excuses, [Some("flaps come in the wrong order".to_owned()), None, None]);
}

#[test]
fn an_entry_is_stale_if_nothing_fails_matches_or_was_checked() {
    let list = list(CASES);
    let name = "decode-cdr/soaring/Glider/typical";
    assert_eq!(reasons(&list, Scope::Cases, &[case(name, Outcome::Passed)]), [StaleReason::Passes]);
    assert_eq!(reasons(&list, Scope::Cases, &[case(name, Outcome::Idle)]), [StaleReason::Idle]);
    let other = case("layout/soaring/Glider/typical", failed("x"));
    assert_eq!(reasons(&list, Scope::Cases, &[other]), [StaleReason::MatchesNothing]);
    // A case that wasn't run might fail.
    assert_eq!(reasons(&list, Scope::Cases, &[case(name, Outcome::NotRun)]), []);
    let second = case("decode-cdr/soaring/Glider/other", Outcome::NotRun);
    assert_eq!(reasons(&list, Scope::Cases, &[case(name, Outcome::Passed), second]), []);
    // The results of another command don't matter.
    assert_eq!(reasons(&list, Scope::Rules, &[]), []);
}

#[test]
fn an_entry_is_stale_if_a_case_passes_and_is_fixed_to_match_the_others() {
    let name = |id: &str| format!("decode-cdr/soaring/Glider/{id}");
    let names = ["flaps-nan", "typical", "zero"].map(name);
    let [nan, typical, zero] = &names;
    let checked = [case(nan, failed("x")), case(typical, Outcome::Passed), case(zero, failed("y"))];
    let list = list(CASES);
    let stale = list.find_stale(Scope::Cases, &checked, TODAY);
    assert_eq!(
        list.render(&stale, Level::Error, false),
        "\
error[baseline-passes]: 1 of 3 matching cases pass; the first is decode-cdr/soaring/Glider/typical
 --> known.toml:2:8
  |
2 | case = \"decode-*/soaring/Glider/*\"
  |        ^^^^^^^^^^^^^^^^^^^^^^^^^^^ match only the cases that fail; use `[[flaky]]` for cases that sometimes pass
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    let expected = CASES.replace("decode-*/soaring/Glider/*", "decode-cdr/soaring/Glider/{flaps-nan,zero}");
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(fixed.find_stale(Scope::Cases, &checked, TODAY), []);
    assert_eq!(fixed.excuse(Name::Case(typical), &[]), None);
}

#[test]
fn an_entry_is_stale_if_the_message_differs() {
    let text = CASES.to_owned() + "message = \"/flaps/0: expected NaN\"\n";
    let list = list(&text);
    let name = "decode-cdr/soaring/Glider/flaps-nan";
    assert_eq!(reasons(&list, Scope::Cases, &[case(name, failed("/flaps/0: expected NaN, got 0"))]), []);
    let other = ["/flaps/0: expected 1, got 0".to_owned(), "/flaps/0: expected 1, got 2".to_owned()];
    assert_eq!(list.excuse(Name::Case(name), &other), None, "the message differs");
    let checked = [case(name, Outcome::Failed(other.to_vec()))];
    let stale = list.find_stale(Scope::Cases, &checked, TODAY);
    let common = "/flaps/0: expected 1, got ".to_owned();
    assert_eq!(stale[0].reason, StaleReason::FailsOtherwise { found: other[0].clone(), common });
    assert_eq!(
        list.render(&stale, Level::Error, false),
        "\
error[baseline-fails-otherwise]: the message differs: expected \"/flaps/0: expected NaN\" at the start, found \"/flaps/0: expected 1, got 0\"
 --> known.toml:4:11
  |
4 | message = \"/flaps/0: expected NaN\"
  |           ^^^^^^^^^^^^^^^^^^^^^^^^ investigate the failure; if the new failure is known too, update the message
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    let expected = CASES.to_owned() + "message = \"/flaps/0: expected 1, got \"\n";
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(fixed.find_stale(Scope::Cases, &checked, TODAY), []);
}

#[test]
fn an_entry_is_valid_through_its_expiry_date() {
    let name = "decode-cdr/soaring/Glider/typical";
    let checked = [case(name, failed("x"))];
    for (date, expected) in [("2026-05-09", vec![]), ("2026-05-08", vec![StaleReason::Expired])] {
        let list = list(&format!("{CASES}expires = {date}\n"));
        assert_eq!(reasons(&list, Scope::Cases, &checked), expected);
        assert!(
            list.excuse(Name::Case(name), &["x".to_owned()]).is_some(),
            "an expired entry still excuses its failures"
        );
    }
}

#[test]
fn a_flaky_entry_may_pass_but_must_match_and_not_expire() {
    let text = CASES.replace("known", "flaky") + "message = \"/flaps\"\nexpires = 2026-05-10\n";
    let flaky = list(&text);
    let name = "decode-cdr/soaring/Glider/typical";
    for outcome in [Outcome::Passed, failed("/flaps/0"), failed("/speed")] {
        assert_eq!(reasons(&flaky, Scope::Cases, &[case(name, outcome)]), []);
    }
    assert!(flaky.excuse(Name::Case(name), &["/flaps/0".to_owned()]).is_some());
    assert_eq!(flaky.excuse(Name::Case(name), &["/speed".to_owned()]), None);
    assert_eq!(reasons(&flaky, Scope::Cases, &[]), [StaleReason::MatchesNothing]);
    let over = list(&text.replace("05-10", "05-08"));
    assert_eq!(reasons(&over, Scope::Cases, &[case(name, Outcome::Passed)]), [StaleReason::Expired]);
}

#[test]
fn an_entry_can_restrict_a_rule_by_subject_and_file() {
    let list = list(
        "[[known]]\nrule = \"PX-RANGE-01\"\nsubject = \"glider.flaps\"\nfile = \"old/*.ulg\"\nreason = \"no matter\"\n",
    );
    let violation = |subject, file| of_rule("PX-RANGE-01", subject, file, failed("2 is outside"));
    let passed = |file| of_rule("PX-RANGE-01", "", file, Outcome::Passed);
    assert_eq!(
        reasons(&list, Scope::Rules, &[passed("old/a.ulg"), violation("glider.flaps", "./old/a.ulg")]),
        []
    );
    // A different subject, file or rule doesn't match.
    let others = [violation("glider.speed", "old/a.ulg"), violation("glider.flaps", "new/a.ulg")];
    for other in &others {
        assert_eq!(list.excuse(other.name, &[]), None);
    }
    assert_eq!(reasons(&list, Scope::Rules, &others), [StaleReason::MatchesNothing]);
    let [speed, flaps] = others;
    assert_eq!(reasons(&list, Scope::Rules, &[passed("old/a.ulg"), speed, flaps]), [StaleReason::Passes]);
    let idle = of_rule("PX-RANGE-01", "", "old/a.ulg", Outcome::Idle);
    assert_eq!(reasons(&list, Scope::Rules, &[idle]), [StaleReason::Idle]);
    let unread = unread_outcome("old/a.ulg").collect::<Vec<_>>();
    assert_eq!(unread.len(), RULES.len());
    assert_eq!(reasons(&list, Scope::Rules, &unread), []);
}

#[test]
fn reports_stale_entries_with_their_line() {
    let text = "\
# Gliders

[[known]]
rule = \"PX-RANGE-01\"
reason = \"no matter\"

[[known]]
rule = \"PX-BOOL-01\"
reason = \"a byte that is never written\"
expires = 2026-05-08
";
    let list = list(text);
    let stale = list.find_stale(Scope::Rules, &[of_rule("PX-RANGE-01", "", "a.ulg", Outcome::Passed)], TODAY);
    assert_eq!(
        list.render(&stale, Level::Error, false),
        "\
error[baseline-passes]: this rule matches only passing results
 --> known.toml:4:8
  |
4 | rule = \"PX-RANGE-01\"
  |        ^^^^^^^^^^^^^ remove the entry
error[baseline-expired]: the entry expired on 2026-05-08
  --> known.toml:10:11
   |
10 | expires = 2026-05-08
   |           ^^^^^^^^^^ remove the entry, or set a later date if the reason still applies
error[baseline-unmatched]: nothing in this run matches this rule
 --> known.toml:8:8
  |
8 | rule = \"PX-BOOL-01\"
  |        ^^^^^^^^^^^^ correct the pattern, or remove the entry
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    assert_eq!(fixed.texts().collect::<Vec<_>>(), ["# Gliders\n"]);
}
