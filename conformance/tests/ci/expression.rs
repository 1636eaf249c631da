//! The GitHub expressions that the action and the example use: names, strings, `==`, `!=`, `&&` and `||`.

use std::collections::BTreeMap;

/// The values of names such as `inputs.config`.
pub(super) type Context = BTreeMap<String, String>;

/// Replaces each `${{ … }}` in a text with its value.
pub(super) fn expanded(text: &str, context: &Context) -> String {
    let mut parts = text.split("${{");
    let mut result = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (expression, rest) = part.split_once("}}").expect("the end of an expression");
        result += &value(expression, context);
        result += rest;
    }
    result
}

/// The value of an expression. The value of a comparison is `true` or empty.
pub(super) fn value(expression: &str, context: &Context) -> String {
    let expression = expression.trim();
    if let Some((left, right)) = expression.split_once("||") {
        let left = value(left, context);
        return if left.is_empty() { value(right, context) } else { left };
    }
    if let Some((left, right)) = expression.split_once("&&") {
        let left = value(left, context);
        return if left.is_empty() { left } else { value(right, context) };
    }
    let compared = |(left, right): (&str, &str), expected: bool| {
        let is_equal = value(left, context) == value(right, context);
        (if is_equal == expected { "true" } else { "" }).to_owned()
    };
    if let Some(sides) = expression.split_once("==") {
        return compared(sides, true);
    }
    if let Some(sides) = expression.split_once("!=") {
        return compared(sides, false);
    }
    if let Some(text) = expression.strip_prefix('\'').and_then(|rest| rest.strip_suffix('\'')) {
        return text.to_owned();
    }
    let is_name = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
    assert!(is_name(expression), "unsupported expression `{expression}`");
    context.get(expression).cloned().unwrap_or_default()
}

#[test]
fn expressions_have_the_values_of_github() {
    let context = Context::from([("inputs.a".to_owned(), "x".to_owned())]);
    for (expression, expected) in [
        ("inputs.a", "x"),
        ("inputs.absent", ""),
        ("inputs.absent || inputs.a", "x"),
        ("inputs.a == 'x' && inputs.absent != 'y'", "true"),
        ("inputs.a == 'y'", ""),
        ("inputs.a != ''", "true"),
    ] {
        assert_eq!(value(expression, &context), expected, "{expression}");
    }
    assert_eq!(expanded("a ${{ inputs.a }}, ${{ inputs.absent }}.", &context), "a x, .");
}
