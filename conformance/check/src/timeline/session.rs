//! Follows recorded Flockwave sessions.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_flockwave::record::{Direction, SessionRecord};
use uavspec_model::json::Tree;
use uavspec_rules::definitions::Definitions;
use uavspec_runtime::Severity as CodeSeverity;
use uavspec_schema::json_type::{Definition, SetValues};

use super::context::Context;
use super::label::Label;
use super::lane::{Lane, LaneKind, Part, Severity, Value};
use crate::limits::{MAX_CODES, MAX_ID, MAX_UAVS};

/// The message types of the timeline, in the order of their lanes.
pub(super) const TYPES: [&str; 2] = [UAV, "CONN-INF"];

/// The type of status reports.
const UAV: &str = "UAV-INF";

/// The name of the lanes of recorded connections.
const CONNECTION: &str = "connection";

/// Follows a session.
#[derive(Default)]
pub(super) struct Session {
    uavs: BTreeMap<String, Uav>,
}

/// The error codes of a UAV.
struct Uav {
    /// The time of the first status with error codes, in µs.
    first: u64,
    /// The lanes, by error code.
    codes: BTreeMap<u32, usize>,
}

impl Session {
    /// Follows a record. Returns the type of the message if it belongs to the timeline.
    pub(super) fn record(
        &mut self,
        record: &SessionRecord<'_>,
        context: &mut Context<'_>,
    ) -> Option<&'static str> {
        if record.direction == Direction::Event {
            let name = if record.connection.name.is_empty() { "?" } else { record.connection.name };
            let severity = if record.text == "refused" { Severity::Warning } else { Severity::Normal };
            let value = Value::new(vec![Part::new(record.text, None)], severity);
            set((CONNECTION, name, CONNECTION), 0, value, context);
        }
        let message = record.value.filter(|_| record.direction == Direction::In)?;
        let body = message.get("body").unwrap_or(message);
        let name = body.get("type").and_then(Tree::as_str);
        let ty = *TYPES.iter().find(|known| Some(**known) == name)?;
        let states = match body.get("status") {
            Some(Tree::Object(states)) => states.as_slice(),
            _ => &[],
        };
        for (id, state) in states.iter().filter(|(id, _)| id.len() <= MAX_ID) {
            if ty == UAV {
                self.uav(id, state, context);
            } else if let Some(status) = state.get("status").and_then(Tree::as_str) {
                let value = value("ConnectionStatus", status, context.texts.of_session(context.definitions));
                set((ty, id, "status"), 1, value, context);
            }
        }
        Some(ty)
    }

    fn uav(&mut self, id: &str, state: &Tree<'_>, context: &mut Context<'_>) {
        if !self.uavs.contains_key(id) && self.uavs.len() >= MAX_UAVS {
            context.lanes.more += 1;
            return;
        }
        if let Some(mode) = state.get("mode").and_then(Tree::as_str) {
            let value = value("FlightMode", mode, context.texts.of_session(context.definitions));
            set((UAV, id, "mode"), 2, value, context);
        }
        // Without this field, the error codes are unknown.
        let Some(Tree::List(codes)) = state.get("errors") else { return };
        let time = context.time;
        let uav =
            self.uavs.entry(id.to_owned()).or_insert_with(|| Uav { first: time, codes: BTreeMap::new() });
        let codes: BTreeSet<u32> = codes.iter().take(MAX_CODES).filter_map(code).collect();
        for code in &codes {
            if !uav.codes.contains_key(code)
                && let Some(lane) = error_lane(id, *code, context)
            {
                // Earlier statuses didn't contain the code.
                if uav.first < time {
                    context.lanes.start_cleared(lane, uav.first);
                }
                uav.codes.insert(*code, lane);
            }
        }
        for (code, lane) in &uav.codes {
            context.lanes.set_flag(*lane, time, codes.contains(code));
        }
    }
}

/// The lane of a UAV's error code.
fn error_lane(id: &str, code: u32, context: &mut Context<'_>) -> Option<usize> {
    let Context { definitions, texts, .. } = *context;
    let definitions = texts.of_session(definitions);
    let tables = definitions.schema.packages.iter().flat_map(|package| &package.error_tables);
    let known = tables.flat_map(|table| &table.codes).find(|known| known.code == code);
    let name = match known.and_then(|known| known.abbreviation.as_deref()) {
        Some(abbreviation) => format!("{code} {abbreviation}"),
        None => code.to_string(),
    };
    context.lanes.get((UAV, id, &name), || {
        let label = texts.error_code(code, definitions);
        let mut lane = Lane { label, rank: 2, ..Lane::new(UAV, &*name, LaneKind::Flag) };
        lane.values[1].severity = match CodeSeverity::of(code) {
            CodeSeverity::Informational => Severity::Info,
            CodeSeverity::Warning => Severity::Warning,
            CodeSeverity::Error | CodeSeverity::Fatal => Severity::Error,
        };
        lane
    })
}

/// Records the value of a state.
fn set(key: (&str, &str, &str), rank: usize, value: Value, context: &mut Context<'_>) {
    if let Some(lane) = context.lane(key, rank, LaneKind::State) {
        context.lanes.set(lane, context.time, value);
    }
}

/// A value of a type, with the description from its definition.
fn value(ty: &str, text: &str, definitions: &Definitions) -> Value {
    let types = definitions.schema.json_types.iter().filter(|known| known.name == ty);
    let label = types.filter_map(|known| match &known.definition {
        Definition::Set(set) => match &set.values {
            SetValues::Strings(values) => values.iter().find(|known| known.value == text),
            SetValues::Integers(_) => None,
        },
        _ => None,
    });
    let label = label.map(|known| known.description.as_str()).next().and_then(Label::plain);
    Value::new(vec![Part::new(text, label)], Severity::Normal)
}

fn code(value: &Tree<'_>) -> Option<u32> {
    match value {
        Tree::Int(code) => u32::try_from(*code).ok(),
        _ => None,
    }
}
