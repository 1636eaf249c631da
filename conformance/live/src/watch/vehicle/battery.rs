//! Batteries.

use std::collections::BTreeMap;

use uavspec_check::timeline::{Value, number, state_value};
use uavspec_dynamic::DynamicView;
use uavspec_runtime::Number;

use super::Meaning;
use crate::limits::MAX_BATTERIES;

/// A battery. Values that aren't known are `None`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Battery {
    /// The charge in percent.
    pub percent: Option<i64>,
    /// The voltage in tenths of volts.
    pub tenth_volts: Option<i64>,
    /// The warning.
    pub warning: Option<Value>,
    /// True if the battery is connected.
    pub is_connected: Option<bool>,
    /// The fault bits.
    pub faults: i128,
}

/// Takes a message. Returns true if it changes the state of the batteries.
pub(super) fn message(
    batteries: &mut BTreeMap<i128, Battery>,
    instance: Option<u8>,
    values: DynamicView<'_>,
    meaning: Meaning<'_>,
) -> bool {
    let id = number(values, "id").filter(|id| *id > 0);
    let id = id.unwrap_or_else(|| i128::from(instance.unwrap_or_default()) + 1);
    if batteries.len() >= MAX_BATTERIES && !batteries.contains_key(&id) {
        return false;
    }
    let battery = Battery::read(values, meaning);
    batteries.insert(id, battery.clone()) != Some(battery)
}

impl Battery {
    fn read(values: DynamicView<'_>, meaning: Meaning<'_>) -> Self {
        let Meaning { id, definitions, texts } = meaning;
        let warning = number(values, "warning")
            .and_then(|warning| state_value(("battery_status", "warning"), id, warning, definitions, texts));
        Self {
            percent: real(values, "remaining")
                .filter(|charge| *charge >= 0.0)
                .and_then(|charge| rounded(charge * 100.0)),
            tenth_volts: real(values, "voltage_v")
                .filter(|volts| *volts > 0.0)
                .and_then(|volts| rounded(volts * 10.0)),
            warning,
            is_connected: number(values, "connected").map(|value| value != 0),
            faults: number(values, "faults").unwrap_or_default(),
        }
    }
}

fn real(values: DynamicView<'_>, name: &str) -> Option<f64> {
    match values.get(name)?.number()? {
        Number::Float(value) => Some(value),
        Number::Int(_) => None,
    }
}

/// The nearest integer, if the number is finite.
#[allow(clippy::cast_possible_truncation)] // the cast saturates
fn rounded(number: f64) -> Option<i64> {
    number.is_finite().then(|| number.round() as i64)
}
