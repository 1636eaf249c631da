//! Whether lists hold true for what came of a run.

mod fix;
mod read;

use super::*;
use crate::rules::{RULES, rule};

use crate::model::Date;

const TODAY: Date = Date { year: 2026, month: 5, day: 9 };

fn list(text: &str) -> Lists {
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
    Checked { name: Name::Rule { rule, subject, file }, outcome }
}

fn failed(message: &str) -> Outcome {
    Outcome::Failed(vec![message.to_owned()])
}

fn whys(lists: &Lists, scope: Scope, checked: &[Checked<'_>]) -> Vec<StaleReason> {
    lists.find_stale(scope, checked, TODAY).into_iter().map(|stale| stale.reason).collect()
}

const CASES: &str = "\
[[known]]
case = \"decode-*/soaring/Glider/*\"
reason = \"flaps come in the wrong order\"
";

#[test]
fn what_is_listed_is_excused_and_the_list_holds_true() {
    let list = list(CASES);
    let checked = [
        case("decode-cdr/soaring/Glider/flaps-nan", failed("/flaps/0: expected NaN")),
        case("decode-uorb/soaring/Glider/flaps-nan", Outcome::Idle),
        case("decode-cdr/soaring/Mark/typical", failed("/height: expected 1")),
    ];
    assert_eq!(whys(&list, Scope::Cases, &checked), []);
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
    assert_eq!(whys(&list, Scope::Cases, &[case(name, Outcome::Passed)]), [StaleReason::Passes]);
    assert_eq!(whys(&list, Scope::Cases, &[case(name, Outcome::Idle)]), [StaleReason::Idle]);
    let other = case("layout/soaring/Glider/typical", failed("x"));
    assert_eq!(whys(&list, Scope::Cases, &[other]), [StaleReason::MatchesNothing]);
    // What wasn't run might fail.
    assert_eq!(whys(&list, Scope::Cases, &[case(name, Outcome::NotRun)]), []);
    let second = case("decode-cdr/soaring/Glider/other", Outcome::NotRun);
    assert_eq!(whys(&list, Scope::Cases, &[case(name, Outcome::Passed), second]), []);
    // Another command's results say nothing of it.
    assert_eq!(whys(&list, Scope::Rules, &[]), []);
}

#[test]
fn an_entry_is_stale_when_a_case_passes_and_then_names_the_others() {
    let name = |id: &str| format!("decode-cdr/soaring/Glider/{id}");
    let names = ["flaps-nan", "typical", "zero"].map(name);
    let [nan, typical, zero] = &names;
    let checked = [case(nan, failed("x")), case(typical, Outcome::Passed), case(zero, failed("y"))];
    let list = list(CASES);
    let stale = list.find_stale(Scope::Cases, &checked, TODAY);
    assert_eq!(
        list.render(&stale, Level::Error, false),
        "\
error[known-passes]: 1 of the 3 cases that this names pass: the first is decode-cdr/soaring/Glider/typical
 --> known.toml:2:8
  |
2 | case = \"decode-*/soaring/Glider/*\"
  |        ^^^^^^^^^^^^^^^^^^^^^^^^^^^ name only those that fail; what may fail or pass is flaky
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    let expected = CASES.replace("decode-*/soaring/Glider/*", "decode-cdr/soaring/Glider/{flaps-nan,zero}");
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(fixed.find_stale(Scope::Cases, &checked, TODAY), []);
    assert_eq!(fixed.excuse(Name::Case(typical), &[]), None);
}

#[test]
fn an_entry_is_stale_when_it_fails_otherwise() {
    let text = CASES.to_owned() + "message = \"/flaps/0: expected NaN\"\n";
    let list = list(&text);
    let name = "decode-cdr/soaring/Glider/flaps-nan";
    assert_eq!(whys(&list, Scope::Cases, &[case(name, failed("/flaps/0: expected NaN, got 0"))]), []);
    let other = ["/flaps/0: expected 1, got 0".to_owned(), "/flaps/0: expected 1, got 2".to_owned()];
    assert_eq!(list.excuse(Name::Case(name), &other), None, "that is another failure");
    let checked = [case(name, Outcome::Failed(other.to_vec()))];
    let stale = list.find_stale(Scope::Cases, &checked, TODAY);
    let common = "/flaps/0: expected 1, got ".to_owned();
    assert_eq!(stale[0].reason, StaleReason::FailsOtherwise { found: other[0].clone(), common });
    assert_eq!(
        list.render(&stale, Level::Error, false),
        "\
error[known-fails-otherwise]: it fails otherwise: expected \"/flaps/0: expected NaN\" and more, found \"/flaps/0: expected 1, got 0\"
 --> known.toml:4:11
  |
4 | message = \"/flaps/0: expected NaN\"
  |           ^^^^^^^^^^^^^^^^^^^^^^^^ look into it; where it is known too, correct the message
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    let expected = CASES.to_owned() + "message = \"/flaps/0: expected 1, got \"\n";
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(fixed.find_stale(Scope::Cases, &checked, TODAY), []);
}

#[test]
fn an_entry_holds_through_its_last_day() {
    let name = "decode-cdr/soaring/Glider/typical";
    let checked = [case(name, failed("x"))];
    for (date, expected) in [("2026-05-09", vec![]), ("2026-05-08", vec![StaleReason::Expired])] {
        let list = list(&format!("{CASES}expires = {date}\n"));
        assert_eq!(whys(&list, Scope::Cases, &checked), expected);
        assert!(
            list.excuse(Name::Case(name), &["x".to_owned()]).is_some(),
            "the list is at fault, not the run"
        );
    }
}

#[test]
fn a_flaky_entry_may_pass_and_is_stale_for_all_other_reasons() {
    let text = CASES.replace("known", "flaky") + "message = \"/flaps\"\nexpires = 2026-05-10\n";
    let flaky = list(&text);
    let name = "decode-cdr/soaring/Glider/typical";
    for outcome in [Outcome::Passed, failed("/flaps/0"), failed("/speed")] {
        assert_eq!(whys(&flaky, Scope::Cases, &[case(name, outcome)]), []);
    }
    assert!(flaky.excuse(Name::Case(name), &["/flaps/0".to_owned()]).is_some());
    assert_eq!(flaky.excuse(Name::Case(name), &["/speed".to_owned()]), None);
    assert_eq!(whys(&flaky, Scope::Cases, &[]), [StaleReason::MatchesNothing]);
    let over = list(&text.replace("05-10", "05-08"));
    assert_eq!(whys(&over, Scope::Cases, &[case(name, Outcome::Passed)]), [StaleReason::Expired]);
}

#[test]
fn a_rule_is_narrowed_down_by_subject_and_file() {
    let list = list(
        "[[known]]\nrule = \"PX-RANGE-01\"\nsubject = \"glider.flaps\"\nfile = \"old/*.ulg\"\nreason = \"no matter\"\n",
    );
    let violation = |subject, file| of_rule("PX-RANGE-01", subject, file, failed("2 is outside"));
    let passed = |file| of_rule("PX-RANGE-01", "", file, Outcome::Passed);
    assert_eq!(
        whys(&list, Scope::Rules, &[passed("old/a.ulg"), violation("glider.flaps", "./old/a.ulg")]),
        []
    );
    // Another subject, file or rule is none of its business.
    let others = [violation("glider.speed", "old/a.ulg"), violation("glider.flaps", "new/a.ulg")];
    for other in &others {
        assert_eq!(list.excuse(other.name, &[]), None);
    }
    assert_eq!(whys(&list, Scope::Rules, &others), [StaleReason::MatchesNothing]);
    let [speed, flaps] = others;
    assert_eq!(whys(&list, Scope::Rules, &[passed("old/a.ulg"), speed, flaps]), [StaleReason::Passes]);
    let idle = of_rule("PX-RANGE-01", "", "old/a.ulg", Outcome::Idle);
    assert_eq!(whys(&list, Scope::Rules, &[idle]), [StaleReason::Idle]);
    let unread = unread_outcome("old/a.ulg").collect::<Vec<_>>();
    assert_eq!(unread.len(), RULES.len());
    assert_eq!(whys(&list, Scope::Rules, &unread), []);
}

#[test]
fn reports_stale_entries_with_their_line() {
    let text = "\
# Of the gliders

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
error[known-passes]: nothing that this rule names fails any more
 --> known.toml:4:8
  |
4 | rule = \"PX-RANGE-01\"
  |        ^^^^^^^^^^^^^ remove the entry
error[known-expired]: the entry expired on 2026-05-08
  --> known.toml:10:11
   |
10 | expires = 2026-05-08
   |           ^^^^^^^^^^ remove it; or, where its reason still holds, give it another date
error[known-matches-nothing]: this rule names nothing in this run
 --> known.toml:8:8
  |
8 | rule = \"PX-BOOL-01\"
  |        ^^^^^^^^^^^^ correct the pattern, or remove the entry
"
    );
    let fixed = list.fixed(&stale).expect("a list");
    assert_eq!(fixed.texts().collect::<Vec<_>>(), ["# Of the gliders\n"]);
}
