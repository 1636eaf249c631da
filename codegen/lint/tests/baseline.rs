//! Tests of baselines: known failures, stale entries, mistakes, and edits of the text.

mod fix;
mod read;

use uavspec_lint::baseline::{Lists, Mistakes, Name, Outcome, Scope};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::finding::Finding;
use uavspec_schema::{Date, render};

const TODAY: Date = Date { year: 2026, month: 5, day: 9 };

/// The rules of captures.
const RULES: &[&str] = &["PX-BOOL-01", "PX-RANGE-01"];

/// The entries about cases.
const CASE: Scope<'_> = &|rule| rule.is_none();

/// The entries about rules.
const RULE: Scope<'_> = &|rule| rule.is_some();

fn list(text: &str) -> Lists {
    parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn parse(text: &str) -> Result<Lists, Mistakes> {
    Lists::parse([("known.toml".to_owned(), text.as_bytes().to_vec())], RULES)
}

/// The name of a result, and the result.
type Checked<'n> = (Name<'n>, Outcome);

fn case(name: &str, outcome: Outcome) -> Checked<'_> {
    (Name::case(name), outcome)
}

/// The result of a rule. A failed result has a subject.
fn of_rule<'r>(id: &'r str, subject: &'r str, file: &'r str, outcome: Outcome) -> Checked<'r> {
    let forms = matches!(outcome, Outcome::Failed(_)).then(|| subject.into());
    (Name { forms: forms.into_iter().collect(), ..Name::rule(id, file) }, outcome)
}

fn failed(message: &str) -> Outcome {
    Outcome::Failed(vec![message.to_owned()])
}

/// The ids and messages of stale entries.
fn reasons(lists: &Lists, scope: Scope<'_>, checked: &[Checked<'_>]) -> Vec<String> {
    let stale = lists.find_stale(scope, checked, TODAY).into_iter();
    stale.map(|finding| format!("{}: {}", finding.rule, finding.message)).collect()
}

fn reason_of<'l>(lists: &'l Lists, name: &Name<'_>, messages: &[&str]) -> Option<&'l str> {
    let messages: Vec<String> = messages.iter().map(|message| (*message).to_owned()).collect();
    lists.find(name, &messages).map(|entry| entry.reason.as_str())
}

fn rendered(lists: &Lists, stale: &[Finding]) -> String {
    render::findings(stale, lists.sources(), false)
}

fn fixed(lists: &Lists, stale: &[Finding]) -> Lists {
    lists.updated(stale).unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

const NO_REASON: [String; 0] = [];

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
    assert_eq!(reasons(&list, CASE, &checked), NO_REASON);
    let known = checked.iter().map(|checked| reason_of(&list, &checked.0, &["x"])).collect::<Vec<_>>();
    let reason = Some("flaps come in the wrong order");
    assert_eq!(known, [reason, reason, None]);
}

#[test]
fn an_entry_is_stale_if_nothing_fails_matches_or_was_checked() {
    let list = list(CASES);
    let name = "decode-cdr/soaring/Glider/typical";
    assert_eq!(
        reasons(&list, CASE, &[case(name, Outcome::Passed)]),
        ["baseline-passes: this case matches only passing results"]
    );
    assert_eq!(
        reasons(&list, CASE, &[case(name, Outcome::Idle)]),
        ["baseline-unmatched: there was nothing to check for this case"]
    );
    let other = case("layout/soaring/Glider/typical", failed("x"));
    assert_eq!(reasons(&list, CASE, &[other]), ["baseline-unmatched: nothing in this run matches this case"]);
    // A case that wasn't run might fail, so its entry isn't stale.
    assert_eq!(reasons(&list, CASE, &[case(name, Outcome::NotRun)]), NO_REASON);
    let second = case("decode-cdr/soaring/Glider/other", Outcome::NotRun);
    assert_eq!(reasons(&list, CASE, &[case(name, Outcome::Passed), second]), NO_REASON);
    // The results of another command don't make the entry stale.
    assert_eq!(reasons(&list, RULE, &[]), NO_REASON);
}

#[test]
fn an_entry_is_stale_if_a_case_passes_and_is_fixed_to_match_the_others() {
    let name = |id: &str| format!("decode-cdr/soaring/Glider/{id}");
    let names = ["flaps-nan", "typical", "zero"].map(name);
    let [nan, typical, zero] = &names;
    let checked = [case(nan, failed("x")), case(typical, Outcome::Passed), case(zero, failed("y"))];
    let list = list(CASES);
    let stale = list.find_stale(CASE, &checked, TODAY);
    assert_eq!(
        rendered(&list, &stale),
        "\
error[baseline-passes]: 1 of 3 matching cases pass; the first is decode-cdr/soaring/Glider/typical
 --> known.toml:2:8
  |
2 | case = \"decode-*/soaring/Glider/*\"
  |        ^^^^^^^^^^^^^^^^^^^^^^^^^^^ match only the cases that fail; use `[[flaky]]` for cases that sometimes pass
"
    );
    let fixed = fixed(&list, &stale);
    let expected = CASES.replace("decode-*/soaring/Glider/*", "decode-cdr/soaring/Glider/{flaps-nan,zero}");
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(reasons(&fixed, CASE, &checked), NO_REASON);
    assert_eq!(reason_of(&fixed, &Name::case(typical), &[]), None);
}

#[test]
fn an_entry_is_stale_if_the_message_differs() {
    let text = CASES.to_owned() + "message = \"/flaps/0: expected NaN\"\n";
    let list = list(&text);
    let name = "decode-cdr/soaring/Glider/flaps-nan";
    assert_eq!(reasons(&list, CASE, &[case(name, failed("/flaps/0: expected NaN, got 0"))]), NO_REASON);
    let other = ["/flaps/0: expected 1, got 0".to_owned(), "/flaps/0: expected 1, got 2".to_owned()];
    assert!(list.find(&Name::case(name), &other).is_none(), "the message differs");
    let checked = [case(name, Outcome::Failed(other.to_vec()))];
    let stale = list.find_stale(CASE, &checked, TODAY);
    assert_eq!(
        rendered(&list, &stale),
        "\
error[baseline-fails-otherwise]: the message differs: expected \"/flaps/0: expected NaN\" at the start, found \"/flaps/0: expected 1, got 0\"
 --> known.toml:4:11
  |
4 | message = \"/flaps/0: expected NaN\"
  |           ^^^^^^^^^^^^^^^^^^^^^^^^ investigate the failure; if the new failure is known too, update the message
"
    );
    let fixed = fixed(&list, &stale);
    let expected = CASES.to_owned() + "message = \"/flaps/0: expected 1, got \"\n";
    assert_eq!(fixed.texts().collect::<Vec<_>>(), [expected]);
    assert_eq!(reasons(&fixed, CASE, &checked), NO_REASON);
}

#[test]
fn an_entry_is_valid_through_its_expiry_date() {
    let name = "decode-cdr/soaring/Glider/typical";
    let checked = [case(name, failed("x"))];
    for (date, expected) in
        [("2026-05-09", vec![]), ("2026-05-08", vec!["baseline-expired: the entry expired on 2026-05-08"])]
    {
        let list = list(&format!("{CASES}expires = {date}\n"));
        assert_eq!(reasons(&list, CASE, &checked), expected);
        assert!(
            reason_of(&list, &Name::case(name), &["x"]).is_some(),
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
        assert_eq!(reasons(&flaky, CASE, &[case(name, outcome)]), NO_REASON);
    }
    assert!(reason_of(&flaky, &Name::case(name), &["/flaps/0"]).is_some());
    assert_eq!(reason_of(&flaky, &Name::case(name), &["/speed"]), None);
    assert_eq!(reasons(&flaky, CASE, &[]), ["baseline-unmatched: nothing in this run matches this case"]);
    let over = list(&text.replace("05-10", "05-08"));
    assert_eq!(
        reasons(&over, CASE, &[case(name, Outcome::Passed)]),
        ["baseline-expired: the entry expired on 2026-05-08"]
    );
}

#[test]
fn an_entry_can_restrict_a_rule_by_subject_and_file() {
    let list = list(
        "[[known]]\nrule = \"PX-RANGE-01\"\nsubject = \"glider.flaps\"\nfile = \"old/*.ulg\"\nreason = \"no matter\"\n",
    );
    let violation = |subject, file| of_rule("PX-RANGE-01", subject, file, failed("2 is outside"));
    let passed = |file| of_rule("PX-RANGE-01", "", file, Outcome::Passed);
    assert_eq!(
        reasons(&list, RULE, &[passed("old/a.ulg"), violation("glider.flaps", "./old/a.ulg")]),
        NO_REASON
    );
    // A different subject, file or rule doesn't match.
    let others = [violation("glider.speed", "old/a.ulg"), violation("glider.flaps", "new/a.ulg")];
    for other in &others {
        assert_eq!(reason_of(&list, &other.0, &[]), None);
    }
    assert_eq!(
        reasons(&list, RULE, &others),
        ["baseline-unmatched: nothing in this run matches this subject of `PX-RANGE-01`"]
    );
    let [speed, flaps] = others;
    assert_eq!(
        reasons(&list, RULE, &[passed("old/a.ulg"), speed, flaps]),
        ["baseline-passes: this subject of `PX-RANGE-01` matches only passing results"]
    );
    let idle = of_rule("PX-RANGE-01", "", "old/a.ulg", Outcome::Idle);
    assert_eq!(
        reasons(&list, RULE, &[idle]),
        ["baseline-unmatched: there was nothing to check for this subject of `PX-RANGE-01`"]
    );
    let unread = of_rule("PX-RANGE-01", "", "old/a.ulg", Outcome::NotRun);
    assert_eq!(reasons(&list, RULE, &[unread]), NO_REASON);
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
    let stale = list.find_stale(RULE, &[of_rule("PX-RANGE-01", "", "a.ulg", Outcome::Passed)], TODAY);
    assert_eq!(
        rendered(&list, &stale),
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
    let fixed = fixed(&list, &stale);
    assert_eq!(fixed.texts().collect::<Vec<_>>(), ["# Gliders\n"]);
}

#[test]
fn a_count_covers_only_as_many_findings() {
    let list = list(
        "[[known]]\nrule = \"unit-missing\"\nsubject = \"px4/*\"\ncount = 2\nreason = \"old\"\n\n\
         [[known]]\nrule = \"unit-missing\"\nsubject = \"px4/Wind.speed\"\ncount = 1\nreason = \"odd\"\n",
    );
    let found = |subject, count| {
        of_rule("unit-missing", subject, "Wind.msg", Outcome::Failed(vec!["no unit".to_owned(); count]))
    };
    // The entry with the exact subject covers its findings, although the pattern matches them as well.
    assert_eq!(reason_of(&list, &found("px4/Wind.speed", 1).0, &["no unit"]), Some("odd"));
    assert_eq!(reasons(&list, RULE, &[found("px4/Wind.speed", 1), found("px4/Wind.gust", 2)]), NO_REASON);
    let checked = [found("px4/Wind.speed", 3), found("px4/Wind.gust", 1)];
    let stale = list.find_stale(RULE, &checked, TODAY);
    assert_eq!(stale.iter().map(|finding| finding.level).collect::<Vec<_>>(), [Level::Error, Level::Note]);
    let text = rendered(&list, &stale);
    assert!(text.contains("this subject of `unit-missing` has 1 finding instead of 2"), "{text}");
    let fixed = fixed(&list, &stale);
    assert_eq!(reasons(&fixed, RULE, &checked), NO_REASON);
    let text: String = fixed.texts().collect();
    assert!(text.contains("px4/*\"\ncount = 1\n") && text.contains("speed\"\ncount = 3\n"), "{text}");
    let unmatched = "baseline-unmatched: nothing in this run matches this subject of `unit-missing`";
    assert_eq!(reasons(&list, RULE, &[]), [unmatched, unmatched]);
}

#[test]
fn a_star_stops_at_slashes_in_paths_only() {
    let is_match = |key: &str, pattern: &str, name: &Name<'_>| {
        let selector = if key == "case" { "" } else { "rule = \"PX-BOOL-01\"\n" };
        let list = list(&format!("[[known]]\n{selector}{key} = \"{pattern}\"\nreason = \"x\"\n"));
        list.find(name, &[]).is_some()
    };
    let case = |pattern, name| is_match("case", pattern, &Name::case(name));
    assert!(case("decode-*/px4/Event/*", "decode-cdr/px4/Event/typical"));
    assert!(!case("decode-*/px4/Event/*", "encode-cdr/px4/Event/typical"));
    let subject = |pattern, subject| {
        is_match("subject", pattern, &of_rule("PX-BOOL-01", subject, "a.ulg", failed("x")).0)
    };
    assert!(subject("glider.*", "glider.marks.height"));
    let file = |pattern, path| is_match("file", pattern, &of_rule("PX-BOOL-01", "", path, failed("x")).0);
    assert!(file("logs/2019-*.ulg", "logs/2019-07.ulg") && file("logs/2019-*.ulg", "./logs/2019-07.ulg"));
    assert!(
        !file("logs/2019-*.ulg", "logs/2019-07/a.ulg") && !file("logs/2019-*.ulg", "old/logs/2019-07.ulg")
    );
    assert!(file("./**/*.ulg", "old/logs/2019-07.ulg") && file("./a.ulg", "a.ulg"));
}

#[test]
fn a_narrowed_pattern_matches_only_the_failing_cases() {
    let narrowed = |failing: &[&str]| {
        let list = list("[[known]]\ncase = \"*\"\nreason = \"x\"\n");
        let failing = failing.iter().map(|name| case(name, failed("x")));
        let checked: Vec<_> = failing.chain([case("other", Outcome::Passed)]).collect();
        fixed(&list, &list.find_stale(CASE, &checked, TODAY))
    };
    let pattern_of = |failing: &[&str]| {
        let text: String = narrowed(failing).texts().collect();
        text.lines().nth(1).map(str::to_owned)
    };
    let case_of = |pattern: &str| Some(format!("case = \"{pattern}\""));
    assert_eq!(pattern_of(&["hash-cdr/px4/Glider/hash"]), case_of("hash-cdr/px4/Glider/hash"));
    assert_eq!(pattern_of(&["a/Glider/x", "a/Glider/x-y"]), case_of("a/Glider/{x,x-y}"));
    let three = ["a/Glider/x", "a/Mark/x", "a/Glider/y"];
    assert_eq!(pattern_of(&three), case_of("a/{Glider/x,Mark/x,Glider/y}"));
    let odd = ["a/b,c", "a/[0]*", "a/{x}", "b"];
    let list = narrowed(&odd);
    let is_known = |name: &&str| list.find(&Name::case(name), &[]).is_some();
    assert!(odd.iter().all(&is_known));
    assert!(!["a/b", "a/c", "c", "a/0", "a/x", "a/"].iter().any(is_known));
}

#[test]
fn added_entries_name_exactly_their_findings() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("known.toml");
    let read = |target| Lists::read(&[], target, RULES).expect("a list");
    let mut lists = read(Some(&path));
    let subjects = ["UAV-INF", "odd [*] \"subject\"", "wind\tvane", ""];
    let found = |subject| of_rule("PX-BOOL-01", subject, "a.ulg", failed("x")).0;
    let case = "decode-cdr/px4/Event/{a,b}";
    let names: Vec<Name<'_>> = subjects.map(found).into_iter().chain([Name::case(case)]).collect();
    for name in &names {
        assert!(lists.find(name, &[]).is_none());
        for _ in 0..2 {
            assert!(lists.find_or_add(name, &["any message".to_owned()], None).is_some());
        }
    }
    assert_eq!(lists.added().map(|(_, count)| count), Some(names.len()));
    fixed(&lists, &[]).write(&lists).expect("written");
    assert!(read(None).find_or_add(&names[0], &[], None).is_none(), "no list was named");
    let lists = read(Some(&path));
    assert!(names.iter().all(|name| lists.find(name, &["any message".to_owned()]).is_some()));
    assert!(lists.find(&found("odd a \"subject\""), &[]).is_none());
    assert!(lists.find(&of_rule("PX-RANGE-01", "UAV-INF", "a.ulg", failed("x")).0, &[]).is_none());
    assert!(lists.find(&Name::case("decode-cdr/px4/Event/a"), &[]).is_none());
    // Nothing was added, so the file stays unchanged.
    assert_eq!(fixed(&lists, &[]).texts().collect::<String>(), lists.texts().collect::<String>());
}
