//! `[@range low, high]`: inclusive bounds.

use uavspec_runtime::{Constraint, Scalar};

use super::model::{Argument, ConstraintKind, Demand, Effect, Probe, Range, Stated};
use super::number::{parse, spread};
use crate::msg::literal::LiteralError;
use crate::msg::words::single_spaced;
use crate::value::Value;

/// Inclusive bounds.
pub static RANGE: ConstraintKind = ConstraintKind {
    name: "range",
    form: "[@range low, high]",
    words: "{low} to {high}",
    keyword: "x-range",
    read: |argument| Some((Argument::Stated(Stated::Range(read(argument)?)), "")),
    lay_out,
    effect: Effect::Narrows { demands, samples },
};

/// Parses two bounds separated by a comma.
pub(crate) fn read(argument: &str) -> Option<Range> {
    let (low, high) = argument.split_once(',')?;
    let (low, high) = (bound(low).ok()?, bound(high).ok()?);
    (low.is_some() || high.is_some() || argument.contains("inf") || argument.contains("INF"))
        .then_some(Range { low, high })
}

/// Parses a bound, with an optional label in parentheses. Returns `None` if the bound is absent or infinite.
fn bound(text: &str) -> Result<Option<Value>, LiteralError> {
    let number = text.split_once('(').map_or(text, |(number, _)| number).trim();
    if number.is_empty() {
        return Ok(None);
    }
    match parse(number)? {
        Value::Float(value) if value.is_infinite() => Ok(None),
        Value::Float(value) if value.is_nan() => Err(LiteralError::Form),
        value => Ok(Some(value)),
    }
}

fn lay_out(argument: &str) -> String {
    let (low, high) = argument.split_once(',').unwrap_or((argument, ""));
    format!("{}, {}", single_spaced(low), single_spaced(high)).trim_end().to_owned()
}

fn demands(stated: &Stated, scalar: Scalar) -> Vec<Demand> {
    let Stated::Range(Range { low, high }) = stated else { return Vec::new() };
    let low = low.as_ref().and_then(Value::number).map(|low| spread(low, scalar).0);
    let high = high.as_ref().and_then(Value::number).map(|high| spread(high, scalar).1);
    let low = low.map(|number| Demand { method: "from", apply: Constraint::from, number });
    low.into_iter().chain(high.map(|number| Demand { method: "to", apply: Constraint::to, number })).collect()
}

fn samples(stated: &Stated, scalar: Scalar) -> Vec<Probe> {
    let ends = demands(stated, scalar).into_iter().flat_map(|Demand { method, number, .. }| {
        let (end, beyond) = if method == "from" {
            (("range-low", "the minimum of its range"), ("below-range", "just below its range", false))
        } else {
            (("range-high", "the maximum of its range"), ("above-range", "just above its range", true))
        };
        [
            Probe { name: end.0, words: end.1, number, up: None },
            Probe { name: beyond.0, words: beyond.1, number, up: Some(beyond.2) },
        ]
    });
    ends.collect()
}
