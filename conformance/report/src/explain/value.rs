//! Values of fields.

use uavspec_runtime::Scalar;
use uavspec_schema::Element;
use uavspec_schema::msg::constraint::{Constraint, Stated};
use uavspec_schema::value::Value;

use super::answer::{Asked, Field, Meaning, Member, Values};
use super::catalogue::{Catalogue, Definition};
use super::field::Located;
use super::target::Place;
use super::{Unknown, suggestion};

/// The suffixes of constants that are limits or counts, not values.
const LIMITS: [&str; 5] = ["_MAX", "_COUNT", "_NUM", "_LAST", "_ENUM_END"];

/// The start of notes about invalid values.
const INVALID: &str = "invalid: ";

/// Explains a value of a field: a number, or the name of a constant.
pub(super) fn explain(
    catalogue: &Catalogue<'_>,
    place: &Place,
    field: &Field,
    text: &str,
) -> Result<Asked, Unknown> {
    let mut asked =
        Asked { value: text.to_owned(), meaning: Vec::new(), notes: Vec::new(), by_release: Vec::new() };
    let Some(located) = Located::new(catalogue, place) else { return Ok(asked) };
    let element = located.field().ty.element;
    let number = match (element, integer(text)) {
        (Element::Scalar(Scalar::Bool), _) => {
            Some(truth(text).ok_or_else(|| suggestion::no_value(place, text, "true or false"))?)
        }
        (Element::Scalar(scalar), None) if scalar.is_float() => {
            let number: f64 =
                text.parse().map_err(|_| suggestion::no_value(place, text, "a number or NaN"))?;
            asked.notes.extend(notes(&located.constraints(catalogue), &Value::Float(number)));
            return Ok(asked);
        }
        (Element::Scalar(_), Some(number)) => Some(number),
        (Element::Scalar(_), None) => {
            named(field, text).map(|member| integer(&member.value).unwrap_or_default())
        }
        (Element::Text(_) | Element::String { .. } | Element::Message(_), _) => {
            return Err(suggestion::no_value(place, text, "a field that is a number"));
        }
    };
    let Some(number) = number else { return Err(suggestion::unknown_value(place, field, text)) };
    asked.notes.extend(out_of_type(element, number));
    asked.notes.extend(notes(&located.constraints(catalogue), &Value::Int(number)));
    if let Some(values) = &field.values {
        meaning(&mut asked, values, number);
        let owner = Definition {
            name: values.message.clone(),
            ..catalogue.read(&values.message, place.release, None)
        };
        asked.by_release = by_release(catalogue, &owner, values, &asked.meaning);
    }
    Ok(asked)
}

/// True if a field can have the value in the question. If the field has constants, the value must also have a meaning.
pub(super) fn is_possible(field: &Field) -> bool {
    let asked = field.asked.as_ref();
    asked.is_some_and(|asked| {
        asked.notes.iter().all(|note| !note.starts_with(INVALID))
            && (field.values.is_none() || !asked.meaning.is_empty())
    })
}

/// Adds the constants that a number denotes.
fn meaning(asked: &mut Asked, values: &Values, number: i128) {
    let value_of = |member: &Member| integer(&member.value);
    asked.meaning =
        values.members.iter().filter(|member| value_of(member) == Some(number)).cloned().collect();
    let has_masks = values.flags || values.is_inferred && are_masks(values);
    if !asked.meaning.is_empty() {
        return;
    }
    if !has_masks || number < 0 || !asked.notes.is_empty() {
        asked.notes.push("no constant has this value".to_owned());
        return;
    }
    let mut rest = number;
    for member in &values.members {
        let mask = value_of(member).filter(|mask| *mask != 0 && number & mask == *mask);
        if let Some(mask) = mask {
            asked.meaning.push(member.clone());
            rest &= !mask;
        }
    }
    if number == 0 {
        asked.notes.push("no bit is set".to_owned());
    }
    let bits = (0..127).filter(|bit| rest >> bit & 1 == 1);
    asked.notes.extend(bits.map(|bit| format!("bit {bit} ({:#x}) has no meaning", 1_i128 << bit)));
}

/// True if every constant has at most one bit, as in a mask. False for the numbers 0, 1 and 2, which may also be an
/// ordinary enum.
fn are_masks(values: &Values) -> bool {
    let mut numbers = values.members.iter().filter_map(|member| integer(&member.value));
    values.members.len() > 2
        && numbers.clone().any(|number| number > 2)
        && numbers.all(|number| number == 0 || number.count_ones() == 1)
}

/// The constants with the same numbers in all releases. Consecutive releases with the same constants share an entry.
fn by_release(
    catalogue: &Catalogue<'_>,
    owner: &Definition,
    values: &Values,
    meaning: &[Member],
) -> Vec<Meaning> {
    let family = catalogue.family(owner.release);
    let own = catalogue.library().index().release(owner.release).name();
    let steps = catalogue.history(owner);
    // The number of a flag is either its mask or its bit number.
    let constants = steps.iter().find(|step| step.release == own).map(|step| &step.constants);
    let numbers: Vec<&String> = meaning.iter().filter_map(|member| constants?.get(&member.name)).collect();
    let is_meant = |name: &str| {
        let is_limit = LIMITS.iter().any(|limit| name.ends_with(limit));
        let has_prefix = |prefix: &String| {
            name.starts_with(&format!("{prefix}_")) || name.contains(&format!("_{prefix}_"))
        };
        !is_limit && values.prefixes.iter().any(has_prefix)
    };
    let mut found: Vec<Meaning> = Vec::new();
    for step in steps.iter().filter(|step| step.name.is_some() && !numbers.is_empty()) {
        let label = format!("{}@{}", family.name(), step.release);
        if !catalogue.includes(&label) {
            continue;
        }
        let constants =
            step.constants.iter().filter(|(name, value)| numbers.contains(value) && is_meant(name));
        let names: Vec<String> = constants.map(|(name, _)| name.clone()).collect();
        match found.last_mut() {
            Some(last) if last.names == names => last.releases.push(label),
            _ => found.push(Meaning { releases: vec![label], names }),
        }
    }
    found
}

/// The constant that has a name, with or without the prefix.
fn named<'f>(field: &'f Field, text: &str) -> Option<&'f Member> {
    let values = field.values.as_ref()?;
    let is_named = |name: &str| {
        let rest = values.prefixes.iter().filter_map(|prefix| name.strip_prefix(prefix)?.strip_prefix('_'));
        name.eq_ignore_ascii_case(text) || { rest }.any(|rest| rest.eq_ignore_ascii_case(text))
    };
    values.members.iter().find(|member| is_named(&member.name))
}

/// Reads a decimal, hexadecimal or binary integer.
fn integer(text: &str) -> Option<i128> {
    let (sign, digits) = text.strip_prefix('-').map_or((1, text), |digits| (-1, digits));
    let lower = digits.to_ascii_lowercase();
    let (digits, radix) = match (lower.strip_prefix("0x"), lower.strip_prefix("0b")) {
        (Some(digits), _) => (digits, 16),
        (_, Some(digits)) => (digits, 2),
        (None, None) => (digits, 10),
    };
    let is_number = digits.starts_with(|first: char| first.is_ascii_hexdigit()) && digits.len() < 30;
    i128::from_str_radix(digits, radix).ok().filter(|_| is_number).map(|number| sign * number)
}

fn truth(text: &str) -> Option<i128> {
    match text {
        "true" | "1" => Some(1),
        "false" | "0" => Some(0),
        _ => None,
    }
}

/// A note that the type can't represent the value, if this is the case.
fn out_of_type(element: Element, number: i128) -> Option<String> {
    let Element::Scalar(scalar) = element else { return None };
    let (low, high) = scalar.integer_bounds()?;
    let is_out = number < low || number > high;
    is_out.then(|| format!("{INVALID}a {} holds {low} to {high}", scalar.name()))
}

/// Notes about special values, and about values outside the range.
fn notes(constraints: &[&Constraint], value: &Value) -> Vec<String> {
    let is_stated = |stated: &Value| match (stated.as_f64(), value.as_f64()) {
        (Some(stated), Some(value)) => stated.total_cmp(&value).is_eq() || stated.is_nan() && value.is_nan(),
        _ => false,
    };
    let special = |constraint: &&&Constraint| constraint.stated.value().is_some_and(is_stated);
    if let Some(special) = constraints.iter().find(special) {
        return vec![special.kind.words.replace("{value}", &value.to_string())];
    }
    let is_outside = |constraint: &&&Constraint| match (&constraint.stated, value.as_f64()) {
        (Stated::Range(range), Some(value)) => {
            let bound = |bound: &Option<Value>| bound.as_ref().and_then(Value::as_f64);
            bound(&range.low).is_some_and(|low| value < low)
                || bound(&range.high).is_some_and(|high| value > high)
        }
        _ => false,
    };
    let outside = constraints.iter().filter(is_outside).filter_map(|constraint| constraint.valid_values());
    outside.map(|values| format!("{INVALID}outside the range {values}")).collect()
}

#[cfg(test)]
mod tests {
    use super::{Member, Values, are_masks};

    #[test]
    fn consecutive_numbers_are_not_masks() {
        let member = |number: &u8| Member {
            name: format!("GUST_{number}"),
            value: number.to_string(),
            description: String::new(),
        };
        let cases: [(&[u8], bool); 6] = [
            (&[0, 1, 2], false),
            (&[1, 2], false),
            (&[1, 4], false),
            (&[0, 1, 2, 3], false),
            (&[0, 1, 2, 4], true),
            (&[1, 2, 4], true),
        ];
        for (numbers, expected) in cases {
            let values = Values {
                message: "demo/msg/Wind".to_owned(),
                prefixes: vec!["GUST".to_owned()],
                flags: false,
                known_from: String::new(),
                is_inferred: false,
                members: numbers.iter().map(member).collect(),
            };
            assert_eq!(are_masks(&values), expected, "{numbers:?}");
        }
    }
}
