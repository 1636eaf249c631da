//! Lists and mistakes in them.

use proptest::prelude::*;

use super::*;

const MISTAKES: &str = r#"error[known-key]: a list has no `title`
 --> known.toml:1:1
  |
1 | title = 1
  | ^^^^^ start each entry with `[[known]]` or `[[flaky]]`
error[known-type]: `flaky` is no list of tables
 --> known.toml:2:1
  |
2 | flaky = [{ case = "a", reason = "b" }]
  | ^^^^^ start each entry with a line `[[flaky]]`
error[known-rule]: no rule `PX-RANGE-1`
 --> known.toml:5:8
  |
5 | rule = "PX-RANGE-1"
  |        ^^^^^^^^^^^^ `uavspec rules` lists all
error[known-key]: an entry has no `subjct`
 --> known.toml:6:1
  |
6 | subjct = "x"
  | ^^^^^^ keys are rule, subject, file or case, and reason, link, expires, message
error[known-reason]: the entry has no `reason`
 --> known.toml:7:10
  |
7 | reason = "  "
  |          ^^^^ say why, so that others can tell when it no longer holds
error[known-selector]: `case` beside `rule`
  --> known.toml:11:8
   |
11 | case = "decode-cdr/*"
   |        ^^^^^^^^^^^^^^ leave one of them out: an entry names a rule or cases
error[known-type]: `reason` is a string, not this integer
  --> known.toml:12:10
   |
12 | reason = 7
   |          ^ put it in quotes
error[known-date]: `expires` is a date
  --> known.toml:13:11
   |
13 | expires = "2027-06-30"
   |           ^^^^^^^^^^^^ write it without quotes, as 2027-06-30
error[known-selector]: the entry names nothing
  --> known.toml:15:1
   |
15 | [[known]]
   | ^^^^^^^^^ name a `rule`, or `case`s by a pattern
error[known-reason]: the entry has no `reason`
  --> known.toml:15:1
   |
15 | [[known]]
   | ^^^^^^^^^ say why, so that others can tell when it no longer holds
error[known-selector]: `subject` without `rule`
  --> known.toml:16:11
   |
16 | subject = "["
   |           ^^^ it narrows a rule down: name the rule, or remove it
error[known-selector]: `file` without `rule`
  --> known.toml:17:8
   |
17 | file = "*.ulg"
   |        ^^^^^^^ it narrows a rule down: name the rule, or remove it
error[known-type]: `link` has a line break or another control character
  --> known.toml:18:8
   |
18 | link = "a\nb"
   |        ^^^^^^ write it in one line
error[known-pattern]: `decode-[/px4` is no pattern: unclosed character class; missing ']'
  --> known.toml:21:8
   |
21 | case = "decode-[/px4"
   |        ^^^^^^^^^^^^^^ for the characters themselves write `decode-[[]/px4`
error[known-type]: `reason` has a line break or another control character
  --> known.toml:22:10
   |
22 | reason = "a\u001b[31m"
   |          ^^^^^^^^^^^^^ write it in one line
error[known-date]: `expires` is a date
  --> known.toml:23:11
   |
23 | expires = 2027-06-30T10:00:00Z
   |           ^^^^^^^^^^^^^^^^^^^^ write it without quotes, as 2027-06-30"#;

/// Every mistake is told at once, with its place and what to do.
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
";
    let error = parse(text).expect_err("mistakes").to_string();
    assert_eq!(error, MISTAKES);
}

#[test]
fn reports_invalid_toml_with_its_location() {
    let error = parse("[[known]]\nrule = \nreason = \"a\nexpires = 2027-02-30\n").expect_err("mistakes");
    assert_eq!(
        error.to_string(),
        r#"error[known-syntax]: string values must be quoted, expected literal string
 --> known.toml:2:8
  |
2 | rule = 
  |        ^ this is no TOML: correct it
error[known-syntax]: invalid basic string, expected `"`
 --> known.toml:3:12
  |
3 | reason = "a
  |            ^ this is no TOML: correct it
error[known-syntax]: invalid date, expected day between 01 and 28
 --> known.toml:4:11
  |
4 | expires = 2027-02-30
  |           ^^^^^^^^^^ this is no TOML: correct it"#
    );
    let not_text = Lists::parse([("known.toml".to_owned(), b"\xff".to_vec())]).expect_err("no text");
    assert!(not_text.to_string().contains("save the file as UTF-8"), "{not_text}");
}

proptest! {
    /// No text makes it panic, and mistakes have a place.
    #[test]
    fn any_text_is_read_or_refused(text in "([\\[\\]=\"'#{},.\n a-z0-9-]|known|flaky|rule|case|reason|expires){0,40}") {
        if let Err(error) = parse(&text) {
            prop_assert!(error.to_string().starts_with("error["), "{}", error);
        }
    }
}
