//! Literals: text to typed values.

use uavspec_runtime::Scalar;

use crate::value::Value;

/// The reason why a text is not a literal of a type.
#[derive(Debug, PartialEq)]
pub(crate) enum LiteralError {
    /// Not a literal of this type.
    Form,
    /// A number that is out of range.
    Range {
        /// The minimum of the type.
        min: String,
        /// The maximum of the type.
        max: String,
    },
}

/// Parses `text` as a value of type `scalar`. Accepts the syntax of Python's `int` and `float`, as ROS does.
pub(crate) fn parse_scalar(text: &str, scalar: Scalar) -> Result<Value, LiteralError> {
    match scalar {
        Scalar::Bool => parse_bool(text).map(Value::Bool).ok_or(LiteralError::Form),
        Scalar::Float32 | Scalar::Float64 => parse_float(text, scalar),
        _ => {
            let value = parse_int(text).ok_or(LiteralError::Form)?;
            let (min, max) = scalar.integer_bounds().ok_or(LiteralError::Form)?;
            match value {
                Some(value) if (min..=max).contains(&value) => Ok(Value::Int(value)),
                _ => Err(LiteralError::Range { min: min.to_string(), max: max.to_string() }),
            }
        }
    }
}

/// A hint that describes the syntax of literals of type `scalar`.
pub(crate) fn form(scalar: Scalar) -> &'static str {
    match scalar {
        Scalar::Bool => "write `True` or `False`",
        Scalar::Char | Scalar::Byte => "write the numeric value of the character or byte, such as 97",
        Scalar::Float32 | Scalar::Float64 => "write a number such as `1.5`, `1e-3`, `inf` or `nan`",
        _ => "write an integer, not an expression or the name of another constant",
    }
}

/// True if PX4's generator also reads `text` as `value`. PX4's generator accepts decimal integers, `True` and `False`,
/// and truncates floats to integers.
pub(crate) fn is_portable(text: &str, value: &Value) -> bool {
    match value {
        Value::Bool(_) => matches!(text, "True" | "False" | "0" | "1"),
        Value::Float(value) => value.fract() == 0.0,
        _ => text
            .strip_prefix(['+', '-'])
            .unwrap_or(text)
            .bytes()
            .all(|byte| matches!(byte, b'0'..=b'9' | b'_')),
    }
}

fn parse_bool(text: &str) -> Option<bool> {
    match text {
        "1" => Some(true),
        "0" => Some(false),
        _ if text.eq_ignore_ascii_case("true") => Some(true),
        _ if text.eq_ignore_ascii_case("false") => Some(false),
        _ => None,
    }
}

/// Parses an integer with sign, base prefix and `_` between digits. Returns `Some(None)` if the integer exceeds 128
/// bits.
#[allow(clippy::option_option)]
fn parse_int(text: &str) -> Option<Option<i128>> {
    let (sign, unsigned) = match text.as_bytes().first()? {
        b'-' => (-1, &text[1..]),
        b'+' => (1, &text[1..]),
        _ => (1, text),
    };
    let (base, digits) = match unsigned.get(..2) {
        Some("0x" | "0X") => (16, &unsigned[2..]),
        Some("0o" | "0O") => (8, &unsigned[2..]),
        Some("0b" | "0B") => (2, &unsigned[2..]),
        _ => (10, unsigned),
    };
    let digits = if base == 10 { digits } else { digits.strip_prefix('_').unwrap_or(digits) };
    let mut value = Some(0_i128);
    for part in digits.split('_') {
        if part.is_empty() {
            return None;
        }
        for digit in part.chars() {
            let digit = i128::from(digit.to_digit(base)?);
            value = value.and_then(|value| value.checked_mul(i128::from(base))?.checked_add(digit));
        }
    }
    Some(value.map(|value| sign * value))
}

fn parse_float(text: &str, scalar: Scalar) -> Result<Value, LiteralError> {
    let has_stray_underscore = text.starts_with('_')
        || text.ends_with('_')
        || text.as_bytes().windows(2).any(|pair| {
            (pair[0] == b'_' && !pair[1].is_ascii_digit()) || (pair[1] == b'_' && !pair[0].is_ascii_digit())
        });
    if has_stray_underscore {
        return Err(LiteralError::Form);
    }
    // Rust's parser accepts the syntax of Python's `float`, including `inf`, `infinity` and `nan` in any case.
    let value: f64 = text.replace('_', "").parse().map_err(|_| LiteralError::Form)?;
    let is_single = scalar == Scalar::Float32;
    // Common spellings of the greatest `float32` are slightly greater, and are rounded to it.
    #[allow(clippy::cast_possible_truncation)]
    let is_infinite = if is_single { (value as f32).is_infinite() } else { value.is_infinite() };
    let names_infinity = text.to_ascii_lowercase().contains("inf");
    if is_infinite && !names_infinity {
        // The limit of the type, in its shortest decimal form.
        let max = if is_single { format!("{:e}", f32::MAX) } else { format!("{:e}", f64::MAX) };
        return Err(LiteralError::Range { min: format!("-{max}"), max });
    }
    let max = f64::from(f32::MAX);
    Ok(Value::Float(if is_single && value.is_finite() { value.clamp(-max, max) } else { value }))
}

/// A string literal at the start of a text.
#[derive(Debug, PartialEq)]
pub(crate) struct Quoted {
    /// The content, with escapes replaced.
    pub value: String,
    /// The length in bytes, including quotes.
    pub len: usize,
    /// The ranges of unknown escape sequences, which are left unchanged.
    pub unknown_escapes: Vec<std::ops::Range<usize>>,
}

/// Parses the string literal at the start of `text`. Returns `None` if the closing quote is missing.
pub(crate) fn parse_quoted(text: &str) -> Option<Quoted> {
    let quote = text.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
    let mut quoted = Quoted { value: String::new(), len: 0, unknown_escapes: Vec::new() };
    let mut characters = text.char_indices().skip(1);
    while let Some((at, character)) = characters.next() {
        if character == quote {
            quoted.len = at + 1;
            return Some(quoted);
        }
        if character != '\\' {
            quoted.value.push(character);
            continue;
        }
        let (end, escaped) = characters.next()?;
        let unescaped = match escaped {
            'n' => '\n',
            't' => '\t',
            'r' => '\r',
            '0' => '\0',
            '\\' | '"' | '\'' => escaped,
            _ => {
                quoted.unknown_escapes.push(at..end + escaped.len_utf8());
                quoted.value.push('\\');
                escaped
            }
        };
        quoted.value.push(unescaped);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_allow_sign_base_and_underscores() {
        let int = |text| parse_scalar(text, Scalar::Int64);
        for (text, value) in
            [("010", 10), ("+1", 1), ("-0x1", -1), ("0X1f", 31), ("0b1_01", 5), ("0o17", 15), ("1_000", 1000)]
        {
            assert_eq!(int(text), Ok(Value::Int(value)), "{text}");
        }
        for text in ["", "-", "0x", "1__0", "_1", "1_", "- 1", "1.0", "1e3", "A", "'1'", "1 << 2"] {
            assert_eq!(int(text), Err(LiteralError::Form), "{text}");
        }
    }

    #[test]
    fn numbers_out_of_the_types_range_are_rejected() {
        assert_eq!(parse_scalar("18446744073709551615", Scalar::UInt64), Ok(Value::Int(u64::MAX.into())));
        assert!(matches!(parse_scalar("256", Scalar::UInt8), Err(LiteralError::Range { .. })));
        assert!(matches!(parse_scalar(&"9".repeat(400), Scalar::UInt64), Err(LiteralError::Range { .. })));
        assert!(matches!(parse_scalar("1e39", Scalar::Float32), Err(LiteralError::Range { .. })));
        assert!(matches!(parse_scalar("3.4028236e38", Scalar::Float32), Err(LiteralError::Range { .. })));
        for max in ["3.4028234663852886e38", "3.4028235e38", "3.40282347e+38"] {
            let expected = Ok(Value::Float(f32::MAX.into()));
            assert_eq!(parse_scalar(max, Scalar::Float32), expected, "{max}");
        }
        assert!(matches!(parse_scalar("1e309", Scalar::Float64), Err(LiteralError::Range { .. })));
        assert_eq!(parse_scalar("-Inf", Scalar::Float32), Ok(Value::Float(f64::NEG_INFINITY)));
        assert_eq!(parse_scalar("2", Scalar::Bool), Err(LiteralError::Form));
    }

    #[test]
    fn strings_end_at_their_own_quote() {
        let quoted = parse_quoted(r#""a\"b#'=" # rest"#).expect("closed");
        assert_eq!((quoted.value.as_str(), quoted.len), (r#"a"b#'="#, 9));
        assert_eq!(parse_quoted(r#""a\""#), None);
        assert_eq!(parse_quoted(r"'\q'").expect("closed").unknown_escapes, vec![1..3]);
    }
}
