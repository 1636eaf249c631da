//! Tests of the parser and its error messages.

use proptest::prelude::*;

use super::*;

const MISTAKES: &str = r#"error[baseline-key]: unknown key `title`
 --> known.toml:1:1
  |
1 | title = 1
  | ^^^^^ start each entry with `[[known]]` or `[[flaky]]`
error[baseline-type]: `flaky`: expected an array of tables
 --> known.toml:2:1
  |
2 | flaky = [{ case = "a", reason = "b" }]
  | ^^^^^ start each entry with `[[flaky]]`
error[baseline-rule]: unknown rule `PX-RANGE-1`
 --> known.toml:5:8
  |
5 | rule = "PX-RANGE-1"
  |        ^^^^^^^^^^^^ did you mean `PX-RANGE-01`?
error[baseline-key]: unknown key `subjct` in an entry
 --> known.toml:6:1
  |
6 | subjct = "x"
  | ^^^^^^ expected rule, subject, file, case, count, message, reason, link, expires
error[baseline-reason]: the entry has no `reason`
 --> known.toml:7:10
  |
7 | reason = "  "
  |          ^^^^ explain the findings, so others know when to remove the entry
error[baseline-selector]: `case` and `rule` in one entry
  --> known.toml:11:8
   |
11 | case = "decode-cdr/*"
   |        ^^^^^^^^^^^^^^ remove one of them: an entry applies to either a rule or cases
error[baseline-type]: `reason`: expected a string, found type integer
  --> known.toml:12:10
   |
12 | reason = 7
   |          ^ put the value in quotes
error[baseline-date]: `expires`: expected a date
  --> known.toml:13:11
   |
13 | expires = "2027-06-30"
   |           ^^^^^^^^^^^^ write it without quotes, e.g. 2027-06-30
error[baseline-selector]: the entry has neither `rule` nor `case`
  --> known.toml:15:1
   |
15 | [[known]]
   | ^^^^^^^^^ add a `rule`, or a `case` pattern
error[baseline-reason]: the entry has no `reason`
  --> known.toml:15:1
   |
15 | [[known]]
   | ^^^^^^^^^ explain the findings, so others know when to remove the entry
error[baseline-selector]: `subject` without `rule`
  --> known.toml:16:11
   |
16 | subject = "["
   |           ^^^ add a `rule` to the entry, or remove this key
error[baseline-pattern]: invalid pattern `[`: unclosed character class; missing ']'
  --> known.toml:16:11
   |
16 | subject = "["
   |           ^^^ to match this text literally, write `[[]`
error[baseline-selector]: `file` without `rule`
  --> known.toml:17:8
   |
17 | file = "*.ulg"
   |        ^^^^^^^ add a `rule` to the entry, or remove this key
error[baseline-pattern]: invalid pattern `decode-[/px4`: unclosed character class; missing ']'
  --> known.toml:21:8
   |
21 | case = "decode-[/px4"
   |        ^^^^^^^^^^^^^^ to match this text literally, write `decode-[[]/px4`
error[baseline-date]: `expires`: expected a date
  --> known.toml:23:11
   |
23 | expires = 2027-06-30T10:00:00Z
   |           ^^^^^^^^^^^^^^^^^^^^ write it without quotes, e.g. 2027-06-30
error[baseline-selector]: `count` is only for rules of `lint` and `breaking`
  --> known.toml:24:9
   |
24 | count = -1
   |         ^^ remove this key
error[baseline-type]: `count`: expected a number of findings
  --> known.toml:24:9
   |
24 | count = -1
   |         ^^ write a number without quotes"#;

/// Every error has a location and a fix.
#[test]
fn reports_all_mistakes_together() {
    let text = "\
title = 1
flaky = [{ case = \"a\", reason = \"b\" }]

[[known]]
rule = \"PX-RANGE-1\"
subjct = \"x\"
reason = \"  \"

[[known]]
rule = \"PX-RANGE-01\"
case = \"decode-cdr/*\"
reason = 7
expires = \"2027-06-30\"

[[known]]
subject = \"[\"
file = \"*.ulg\"
link = \"a\\nb\"

[[known]]
case = \"decode-[/px4\"
reason = \"a\\u001b[31m\"
expires = 2027-06-30T10:00:00Z
count = -1
";
    let error = parse(text).expect_err("mistakes").to_string();
    assert_eq!(error, MISTAKES);
}

/// Reads lists that `check` wrote, lists that `lint` wrote, and lists with entries for both.
#[test]
fn lists_of_all_commands_are_read() {
    let rule = "[[known]]\nrule = \"PX-RANGE-01\"\nreason = \"old\"\n";
    let lint =
        "[[known]]\nrule = \"unit-missing\"\nsubject = \"px4/*\"\ncount = 0x1\nreason = '''\ntwo\nlines'''\n";
    let changes = "[[known]]\nrule = \"field-removed\"\nreason = \"old\"\nlink = \"a\\nb\"\n";
    let case = "[[flaky]]\ncase = \"a\"\nreason = \"odd\"\n";
    let lists = list(&[rule, lint, changes, case].concat());
    let reason = |name: &Name<'_>| reason_of(&lists, name, &[]);
    assert_eq!(reason(&Name::case("a")), Some("odd"));
    let forms = vec!["px4/Wind".into()];
    assert_eq!(reason(&Name { forms, ..Name::rule("unit-missing", "Wind.msg") }), Some("two lines"));
    let found = lists.find(&Name::rule("field-removed", ""), &[]).map(|entry| entry.link.as_deref());
    assert_eq!(found, Some(Some("a b")));
    // A program that only reads definitions doesn't know the rules of captures.
    let parse = |text: &str| Lists::parse([("known.toml".to_owned(), text.as_bytes().to_vec())], &[]);
    assert!(parse(rule).is_ok());
    let mistakes = parse(&lint.replace("missing", "mising")).expect_err("an unknown rule").to_string();
    assert!(mistakes.contains("did you mean `unit-missing`?"), "{mistakes}");
    let mistakes = parse(&lint.replace("unit-missing", "x")).expect_err("an unknown rule").to_string();
    assert!(mistakes.contains("unknown rule `x`") && mistakes.contains("`uavspec rules`"), "{mistakes}");
}

#[test]
fn reports_invalid_toml_with_its_location() {
    let error = parse("[[known]]\nrule = \nreason = \"a\nexpires = 2027-02-30\n").expect_err("mistakes");
    assert_eq!(
        error.to_string(),
        r#"error[baseline-syntax]: string values must be quoted, expected literal string
 --> known.toml:2:8
  |
2 | rule = 
  |        ^ correct the TOML syntax
error[baseline-syntax]: invalid basic string, expected `"`
 --> known.toml:3:12
  |
3 | reason = "a
  |            ^ correct the TOML syntax
error[baseline-syntax]: invalid date, expected day between 01 and 28
 --> known.toml:4:11
  |
4 | expires = 2027-02-30
  |           ^^^^^^^^^^ correct the TOML syntax"#
    );
    let invalid =
        Lists::parse([("known.toml".to_owned(), b"\xff".to_vec())], RULES).expect_err("invalid UTF-8");
    assert!(invalid.to_string().contains("save the file as UTF-8"), "{invalid}");
}

proptest! {
    /// Arbitrary text causes no panic, and every error has a location.
    #[test]
    fn any_text_is_parsed_or_rejected(text in "([\\[\\]=\"'#{},.\n a-z0-9-]|known|flaky|rule|case|reason|expires){0,40}") {
        if let Err(error) = parse(&text) {
            prop_assert!(error.to_string().starts_with("error["), "{}", error);
        }
    }
}
