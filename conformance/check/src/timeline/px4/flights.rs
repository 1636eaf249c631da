//! The summary for a pilot: why the vehicle couldn't arm, when it flew, and why it disarmed.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;
use uavspec_dynamic::DynamicView;
use uavspec_dynamic::event::DecodedEvent;
use uavspec_model::Channel;
use uavspec_px4::checks::{ModeGroup, Report};
use uavspec_px4::event::{ARMED, ARMING_EVENTS, EventMetadata};

use super::events::part_of;
use super::number;
use crate::limits::{MAX_FLIGHTS, MAX_REFUSALS};
use crate::timeline::label::{Label, Texts};
use crate::timeline::lane::Part;

/// The maximum time between an event about arming and the change of state that it explains, in µs.
const NEAR: u64 = 2_000_000;

/// The summary for a pilot.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Overview {
    /// The times at which the vehicle couldn't arm in a mode. Empty if it could, or if there are no reports.
    pub refusals: Vec<Refusal>,
    /// The modes in the health and arming reports. Empty if there are no reports.
    pub modes: Vec<Part>,
    /// The flights.
    pub flights: Vec<Flight>,
}

/// A time at which the vehicle couldn't arm in a mode for the same reasons.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Refusal {
    /// The mode.
    pub mode: Part,
    /// True if the vehicle was in this mode.
    pub is_selected: bool,
    /// The time of the first report about it, in µs since the start of the capture.
    pub from_us: i64,
    /// The time at which it ended. `None` if it lasted until the end of the capture.
    pub until_us: Option<i64>,
    /// The reasons.
    pub reasons: Vec<Part>,
    /// The problems that PX4 reports for all modes. They may be reasons too: PX4 also marks problems that prevent nothing
    /// in this way.
    pub general: Vec<Part>,
}

/// A time at which the vehicle was armed. Times are in µs since the start of the capture.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Flight {
    /// The time at which the vehicle armed. `None` if it was armed at the start of the capture.
    pub armed_us: Option<i64>,
    /// The reason for arming.
    pub armed_by: Option<Part>,
    /// The times of the takeoffs.
    pub takeoffs_us: Vec<i64>,
    /// The times of the landings.
    pub landings_us: Vec<i64>,
    /// The time at which the vehicle disarmed. `None` if it was armed at the end of the capture.
    pub disarmed_us: Option<i64>,
    /// The reason for disarming.
    pub disarmed_by: Option<Part>,
}

/// Follows the state of the vehicle.
#[derive(Default)]
pub(in crate::timeline) struct Flights {
    overview: Overview,
    /// The channel that contains the vehicle's state. A second channel means that there are several vehicles, which
    /// can't be distinguished.
    channel: Option<usize>,
    is_ambiguous: bool,
    /// The subject from which the reports come.
    reporter: Option<Arc<str>>,
    is_armed: Option<bool>,
    is_landed: Option<bool>,
    mode: Option<i128>,
    /// The modes in which the vehicle can't arm, according to the latest report.
    refused: Vec<Refused>,
    /// The current refusals: their indices, by mode number.
    open: BTreeMap<u32, usize>,
    /// The latest event about arming, and the latest event about disarming, each with its time.
    reasons: [Option<(u64, Part)>; 2],
}

/// A mode in which the vehicle can't arm, according to a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The number of the mode.
    pub number: u32,
    /// The mode.
    pub mode: Part,
    /// The reasons.
    pub reasons: Vec<Part>,
    /// The problems that concern all modes.
    pub general: Vec<Part>,
}

/// A time for an [`Overview`], which is later made relative to the start.
fn instant(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}

impl Flights {
    /// Takes the vehicle's state from a message of `vehicle_status`. `stated` returns the reason in a field of the
    /// message.
    pub(super) fn status(
        &mut self,
        channel: &Channel<'_>,
        values: DynamicView<'_>,
        time: u64,
        stated: impl Fn(&str) -> Option<Part>,
    ) {
        self.is_ambiguous |= self.channel.is_some_and(|known| known != channel.index);
        self.channel = Some(channel.index);
        self.mode = number(values, "nav_state").or(self.mode);
        // PX4 doesn't send a report when the mode changes.
        let open = self.selected().and_then(|mode| self.open.get(&mode));
        if let Some(open) = open.and_then(|index| self.overview.refusals.get_mut(*index)) {
            open.is_selected = true;
        }
        let Some(is_armed) = number(values, "arming_state").map(|state| state == i128::from(ARMED)) else {
            return;
        };
        let was_armed = self.is_armed.replace(is_armed);
        if was_armed == Some(is_armed) {
            return;
        }
        if is_armed {
            self.end_refusals(time, |_, _| true);
            let flight = Flight {
                armed_us: was_armed.map(|_| instant(time)),
                armed_by: was_armed.and_then(|_| self.reason(0, time).or_else(|| stated(ARMING_EVENTS[0].1))),
                ..Flight::default()
            };
            if self.overview.flights.len() < MAX_FLIGHTS {
                self.overview.flights.push(flight);
            }
        } else if was_armed.is_some() {
            let reason = self.reason(1, time).or_else(|| stated(ARMING_EVENTS[1].1));
            // If there was no room for another flight, the last stored flight has already ended.
            let open = self.overview.flights.last_mut().filter(|flight| flight.disarmed_us.is_none());
            if let Some(flight) = open {
                flight.disarmed_us = Some(instant(time));
                flight.disarmed_by = reason;
            }
            self.refuse(time);
        }
    }

    /// Takes takeoffs and landings from a message of `vehicle_land_detected`.
    pub(super) fn landed(&mut self, values: DynamicView<'_>, time: u64) {
        let Some(is_landed) = number(values, "landed").map(|landed| landed != 0) else { return };
        let was_landed = self.is_landed.replace(is_landed);
        let flight = self.overview.flights.last_mut().filter(|flight| flight.disarmed_us.is_none());
        let Some(flight) = flight.filter(|_| was_landed == Some(!is_landed)) else { return };
        let times = if is_landed { &mut flight.landings_us } else { &mut flight.takeoffs_us };
        if times.len() < MAX_FLIGHTS {
            times.push(instant(time));
        }
    }

    /// Takes the reason for arming or disarming from an event.
    pub(super) fn event(&mut self, event: &DecodedEvent<'_>, time: u64) {
        let which = ARMING_EVENTS.iter().position(|(name, _)| event.event.name == *name);
        let Some(which) = which else { return };
        let Some(reason) = event.argument(0).map(|reason| reason.to_string()) else { return };
        let part = Part::new(event.event.name.clone(), Label::plain(&reason));
        // The event may follow the change that it explains.
        let near = |at: Option<i64>| at.is_some_and(|at| time.abs_diff(at.unsigned_abs()) <= NEAR);
        if let Some(flight) = self.overview.flights.last_mut() {
            match which {
                0 if near(flight.armed_us) => flight.armed_by = Some(part.clone()),
                1 if near(flight.disarmed_us) => flight.disarmed_by = Some(part.clone()),
                _ => {}
            }
        }
        self.reasons[which] = Some((time, part));
    }

    /// The number of the current mode.
    fn selected(&self) -> Option<u32> {
        self.mode.and_then(|mode| u32::try_from(mode).ok())
    }

    /// The reason in an event that is close in time. Removes the event, because it explains only one change.
    fn reason(&mut self, which: usize, time: u64) -> Option<Part> {
        self.reasons[which].take().filter(|(at, _)| time.abs_diff(*at) <= NEAR).map(|(_, part)| part)
    }

    /// Sets the subject of the reports. A second subject means that there are several vehicles.
    pub(super) fn reporter(&mut self, subject: &Arc<str>) {
        self.is_ambiguous |= self.reporter.as_ref().is_some_and(|known| known != subject);
        self.reporter = Some(Arc::clone(subject));
    }

    /// Takes the refusals from a report, with their reasons.
    pub(super) fn report(&mut self, report: &Report, refused: Vec<Refused>, time: u64) {
        if self.overview.modes.is_empty() {
            self.overview.modes = reported_modes(report);
        }
        self.refused = refused;
        if self.is_armed != Some(true) {
            self.refuse(time);
        }
    }

    /// Ends the refusals that no longer apply or whose reasons have changed, and starts new ones.
    fn refuse(&mut self, time: u64) {
        let refused = std::mem::take(&mut self.refused);
        // Measured values in a text vary.
        let are_same = |left: &[Part], right: &[Part]| {
            left.iter().map(|part| &part.name).eq(right.iter().map(|part| &part.name))
        };
        self.end_refusals(time, |bit, open| {
            let new = refused.iter().find(|new| new.number == bit);
            !new.is_some_and(|new| {
                are_same(&new.reasons, &open.reasons) && are_same(&new.general, &open.general)
            })
        });
        let selected = self.selected();
        for Refused { number, mode, reasons, general } in &refused {
            let refusals = &mut self.overview.refusals;
            if self.open.contains_key(number) || refusals.len() == MAX_REFUSALS {
                continue;
            }
            self.open.insert(*number, refusals.len());
            refusals.push(Refusal {
                mode: mode.clone(),
                is_selected: selected == Some(*number),
                from_us: instant(time),
                until_us: None,
                reasons: reasons.clone(),
                general: general.clone(),
            });
        }
        self.refused = refused;
    }

    /// Ends some refusals.
    fn end_refusals(&mut self, time: u64, is_over: impl Fn(u32, &Refusal) -> bool) {
        let refusals = &mut self.overview.refusals;
        self.open.retain(|bit, index| {
            let open = refusals.get_mut(*index).filter(|open| is_over(*bit, open));
            open.map(|open| open.until_us = Some(instant(time))).is_none()
        });
    }

    /// The overview, with times relative to `start`. `None` if the capture doesn't contain the state of a single
    /// vehicle.
    pub(in crate::timeline) fn finish(mut self, start: u64) -> Option<Overview> {
        if self.is_ambiguous || self.channel.is_none() {
            return None;
        }
        let start = instant(start);
        for refusal in &mut self.overview.refusals {
            refusal.from_us -= start;
            refusal.until_us = refusal.until_us.map(|time| time - start);
        }
        for flight in &mut self.overview.flights {
            let times = [&mut flight.armed_us, &mut flight.disarmed_us].into_iter().flatten();
            let times = times.chain(&mut flight.takeoffs_us).chain(&mut flight.landings_us);
            times.for_each(|time| *time -= start);
        }
        Some(self.overview)
    }
}

fn part(mode: &ModeGroup) -> Part {
    Part::new(mode.name.clone(), Label::plain(&mode.description))
}

/// The reasons, and the problems that concern all modes, as text. `None` if there are neither.
pub fn reasons_text(reasons: &[Part], general: &[Part], text: impl Fn(&Part) -> String) -> Option<String> {
    let joined = |parts: &[Part]| parts.iter().map(&text).collect::<Vec<_>>().join("; ");
    match (reasons, general) {
        ([], []) => None,
        ([], only) | (only, []) => Some(joined(only)),
        _ => Some(format!("{}. Reported for all modes: {}", joined(reasons), joined(general))),
    }
}

/// The modes in a report.
pub fn reported_modes(report: &Report) -> Vec<Part> {
    report.modes.values().map(part).collect()
}

/// The modes in which the vehicle can't arm. The problems that concern all modes are left out for a mode that has other
/// reasons, if the vehicle can arm in another mode: they don't prevent arming then.
pub fn refused_modes(report: &Report, metadata: &EventMetadata, texts: &Texts) -> Vec<Refused> {
    let can_arm = report.modes.values().any(|mode| mode.can_arm);
    let problems = report.problems.iter().filter_map(|problem| {
        let is_general = problem.modes >= u64::from(u32::MAX);
        Some((problem.modes, is_general, part_of(problem, metadata, texts)?))
    });
    let (general, specific): (Vec<_>, Vec<_>) = problems.partition(|(_, is_general, _)| *is_general);
    let general: Vec<Part> = general.into_iter().map(|(_, _, part)| part).collect();
    let refused = report.modes.iter().filter(|(_, mode)| !mode.can_arm).map(|(bit, mode)| {
        let of_mode = specific.iter().filter(|(modes, _, _)| modes & 1 << bit != 0);
        let reasons: Vec<Part> = of_mode.map(|(_, _, part)| part.clone()).collect();
        let general = if can_arm && !reasons.is_empty() { Vec::new() } else { general.clone() };
        Refused { number: *bit, mode: part(mode), reasons, general }
    });
    refused.collect()
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};
    use uavspec_dynamic::Types;
    use uavspec_dynamic::event::{EventValue, Events};
    use uavspec_model::Location;
    use uavspec_px4::checks::{ModeGroup, Problem};
    use uavspec_schema::msg::Dialect;
    use uavspec_schema::translation::Translations;
    use uavspec_schema::{Form, PackageInput, SourceMap, read};

    use super::*;

    const SECOND: u64 = 1_000_000;

    /// The time of the start.
    const START: u64 = 10 * SECOND;

    const DISARMED: u8 = 1;

    const ARMED_BY: &str = ARMING_EVENTS[0].0;
    const DISARMED_BY: &str = ARMING_EVENTS[1].0;

    /// The bits of two modes.
    const MANUAL: u32 = 0;
    const AUTO: u32 = 3;

    fn types() -> Types {
        let mut sources = SourceMap::default();
        let mut add = |name: &str, text: &str| sources.add(name, text.into()).expect("a text");
        let files = vec![
            add("VehicleStatus.msg", "uint64 timestamp\nuint8 arming_state\nuint8 nav_state\n"),
            add("VehicleLandDetected.msg", "uint64 timestamp\nbool landed\n"),
        ];
        let package = PackageInput::new("px4", Form::Msg(Dialect::Px4), files);
        Types::new(&read(&sources, &[package]).0)
    }

    /// A vehicle whose messages are followed by the test. Times are in seconds since the start.
    struct Vehicle {
        types: Types,
        flights: Flights,
        /// The channel of the next state.
        channel: usize,
    }

    impl Vehicle {
        fn new() -> Self {
            Self { types: types(), flights: Flights::default(), channel: 0 }
        }

        fn status(&mut self, second: u64, arming_state: u8, mode: u32) {
            let channel = Channel {
                index: self.channel,
                topic: "vehicle_status",
                full_topic: "vehicle_status",
                multi_id: None,
                definition: None,
                version: None,
                location: Location::Byte(0),
            };
            let value = json!({ "timestamp": 0, "arming_state": arming_state, "nav_state": mode });
            let ty = self.types.find("px4", "VehicleStatus").expect("a type");
            let message = ty.from_json(&value).expect("a message");
            let stated = |field: &str| Some(Part::new(field.to_owned(), None));
            self.flights.status(&channel, message.view(), START + second * SECOND, stated);
        }

        fn landed(&mut self, second: u64, landed: bool) {
            let ty = self.types.find("px4", "VehicleLandDetected").expect("a type");
            let value = ty.from_json(&json!({ "timestamp": 0, "landed": landed })).expect("a message");
            self.flights.landed(value.view(), START + second * SECOND);
        }

        /// Follows an event that states the reason for arming or disarming.
        fn event(&mut self, second: u64, name: &str) {
            let event =
                json!({ "name": name, "message": "m", "arguments": [{ "name": "by", "type": "by_t" }] });
            let entries = json!({ "7": { "name": "stick", "description": "Stick" } });
            let (events, mistakes) =
                Events::read(metadata(&json!({ "1": event }), &entries).to_string().into_bytes());
            assert_eq!(mistakes, []);
            let event = DecodedEvent::new(&events, 1, vec![EventValue::Integer(7)]).expect("an event");
            self.flights.event(&event, START + second * SECOND);
        }

        /// Follows a report, with the modes in which the vehicle can't arm, and the problems. The modes of each problem
        /// are a mask.
        fn report(&mut self, second: u64, refused: &[u32], problems: &[(&str, u64)]) {
            let mode = |bit: u32| ModeGroup {
                name: format!("mode{bit}"),
                description: String::new(),
                can_arm: !refused.contains(&bit),
                can_run: true,
            };
            let modes = [MANUAL, AUTO].map(|bit| (bit, mode(bit))).into();
            let mut events = serde_json::Map::new();
            let mut report = Report { modes, ..Report::default() };
            for (id, (name, modes)) in (1..).zip(problems) {
                events.insert(id.to_string(), json!({ "name": name, "message": "m" }));
                report.problems.push(Problem { id, values: Vec::new(), modes: *modes, component: 0 });
            }
            let metadata = metadata(&events.into(), &json!({})).to_string();
            let (metadata, _) = EventMetadata::of_capture(metadata.as_bytes()).expect("metadata");
            let refused = refused_modes(&report, &metadata, &Texts::of(Translations::default()));
            self.flights.report(&report, refused, START + second * SECOND);
        }

        fn finish(self) -> Overview {
            self.flights.finish(START).expect("a single vehicle")
        }
    }

    fn metadata(events: &Value, entries: &Value) -> Value {
        json!({ "version": 2, "components": { "0": {
            "namespace": "common",
            "enums": { "by_t": { "type": "uint8_t", "entries": entries } },
            "event_groups": { "default": { "events": events } },
        } } })
    }

    fn seconds(time: Option<i64>) -> Option<i64> {
        time.map(|time| time / SECOND.cast_signed())
    }

    /// The times at which each flight was armed and disarmed.
    fn times(overview: &Overview) -> Vec<(Option<i64>, Option<i64>)> {
        let times = |flight: &Flight| (seconds(flight.armed_us), seconds(flight.disarmed_us));
        overview.flights.iter().map(times).collect()
    }

    /// The text of a reason, or its name.
    fn text(part: Option<&Part>) -> &str {
        part.map_or("", |part| part.label.as_ref().map_or(&*part.name, |label| &*label.text))
    }

    /// A refusal: the mode, the times at which it began and ended, a flag that is true if the mode was selected, and
    /// the reasons.
    type Row<'o> = (&'o str, Option<i64>, Option<i64>, bool, Vec<&'o str>);

    fn refusals(overview: &Overview) -> Vec<Row<'_>> {
        let mut all = Vec::new();
        for Refusal { mode, is_selected, from_us, until_us, reasons, .. } in &overview.refusals {
            let reasons = reasons.iter().filter_map(|part| part.name.strip_prefix("common::")).collect();
            all.push((&*mode.name, seconds(Some(*from_us)), seconds(*until_us), *is_selected, reasons));
        }
        all
    }

    #[test]
    fn a_flight_lasts_while_the_vehicle_is_armed() {
        let mut vehicle = Vehicle::new();
        vehicle.landed(0, true);
        for (armed, took_off, landed, disarmed) in [(2, 4, 8, 9), (20, 21, 22, 23)] {
            vehicle.status(armed - 1, DISARMED, MANUAL);
            vehicle.status(armed, ARMED, MANUAL);
            vehicle.landed(took_off, false);
            vehicle.status(took_off, ARMED, AUTO);
            vehicle.landed(landed, true);
            vehicle.status(disarmed, DISARMED, AUTO);
        }
        // Lifted by hand.
        vehicle.landed(30, false);
        let overview = vehicle.finish();
        assert_eq!(times(&overview), [(Some(2), Some(9)), (Some(20), Some(23))]);
        let [first, second] = &overview.flights[..] else { panic!("two flights") };
        assert_eq!((&first.takeoffs_us[..], &first.landings_us[..]), (&[4_000_000][..], &[8_000_000][..]));
        assert_eq!(
            (&second.takeoffs_us[..], &second.landings_us[..]),
            (&[21_000_000][..], &[22_000_000][..])
        );
        assert_eq!((&overview.modes[..], &overview.refusals[..]), (&[][..], &[][..]));
    }

    #[test]
    fn a_flight_may_begin_before_the_capture_and_end_after_it() {
        let mut vehicle = Vehicle::new();
        vehicle.status(1, ARMED, MANUAL);
        vehicle.status(5, DISARMED, MANUAL);
        vehicle.status(7, ARMED, MANUAL);
        let overview = vehicle.finish();
        assert_eq!(times(&overview), [(None, Some(5)), (Some(7), None)]);
        assert_eq!(text(overview.flights[0].armed_by.as_ref()), "");
        assert_eq!(text(overview.flights[1].disarmed_by.as_ref()), "");
    }

    #[test]
    fn the_reason_is_that_of_an_event_nearby_or_else_of_the_message() {
        for (armed_event, disarmed_event, expected) in [
            (9, 21, ["Stick", "Stick"]),
            (11, 19, ["Stick", "Stick"]),
            (5, 29, ["latest_arming_reason", "latest_disarming_reason"]),
        ] {
            let mut vehicle = Vehicle::new();
            vehicle.status(1, DISARMED, MANUAL);
            for second in 2..30 {
                vehicle.status(second, if (10..20).contains(&second) { ARMED } else { DISARMED }, MANUAL);
                if second == armed_event {
                    vehicle.event(second, ARMED_BY);
                }
                if second == disarmed_event {
                    vehicle.event(second, DISARMED_BY);
                }
            }
            let overview = vehicle.finish();
            let [flight] = &overview.flights[..] else { panic!("one flight") };
            assert_eq!([&flight.armed_by, &flight.disarmed_by].map(|part| text(part.as_ref())), expected);
        }
    }

    #[test]
    fn a_refusal_lasts_until_a_report_allows_arming() {
        let mut vehicle = Vehicle::new();
        vehicle.status(0, DISARMED, AUTO);
        vehicle.report(1, &[MANUAL, AUTO], &[("no_fix", 1 << AUTO), ("low", 1 << AUTO | 1 << MANUAL)]);
        vehicle.report(2, &[AUTO], &[("no_fix", 1 << AUTO), ("no_home", 1 << AUTO)]);
        vehicle.report(4, &[], &[]);
        vehicle.report(5, &[MANUAL], &[("low", 1 << MANUAL)]);
        let overview = vehicle.finish();
        let expected = [
            ("mode0", Some(1), Some(2), false, vec!["low"]),
            ("mode3", Some(1), Some(2), true, vec!["no_fix", "low"]),
            ("mode3", Some(2), Some(4), true, vec!["no_fix", "no_home"]),
            ("mode0", Some(5), None, false, vec!["low"]),
        ];
        assert_eq!(refusals(&overview), expected);
        assert!(overview.modes.len() == 2 && overview.flights.is_empty());
    }

    #[test]
    fn arming_ends_all_refusals() {
        let mut vehicle = Vehicle::new();
        vehicle.status(0, DISARMED, MANUAL);
        vehicle.report(1, &[AUTO], &[("no_fix", 1 << AUTO)]);
        vehicle.status(3, ARMED, MANUAL);
        vehicle.report(4, &[AUTO], &[("no_fix", 1 << AUTO)]);
        let overview = vehicle.finish();
        assert_eq!(refusals(&overview), [("mode3", Some(1), Some(3), false, vec!["no_fix"])]);
        assert_eq!(times(&overview), [(Some(3), None)]);
    }

    #[test]
    fn problems_of_all_modes_are_separate() {
        let all = u64::from(u32::MAX);
        let both = vec![("kill_switch", all), ("no_fix", 1 << AUTO)];
        for (refused, problems, expected, general) in [
            (vec![MANUAL, AUTO], both.clone(), vec!["no_fix"], vec!["kill_switch"]),
            // The vehicle can arm in another mode.
            (vec![AUTO], both, vec!["no_fix"], vec![]),
            (vec![AUTO], vec![("kill_switch", all)], vec![], vec!["kill_switch"]),
        ] {
            let mut vehicle = Vehicle::new();
            vehicle.status(0, DISARMED, MANUAL);
            vehicle.report(1, &refused, &problems);
            let overview = vehicle.finish();
            let last = overview.refusals.last().expect("a refusal");
            let names = |parts: &[Part]| parts.iter().map(|part| part.name.clone()).collect::<Vec<_>>();
            let full =
                |names: Vec<&str>| names.iter().map(|name| format!("common::{name}")).collect::<Vec<_>>();
            assert_eq!((names(&last.reasons), names(&last.general)), (full(expected), full(general)));
        }
    }

    #[test]
    fn a_mode_that_is_selected_after_the_report_is_explained() {
        let mut vehicle = Vehicle::new();
        vehicle.status(1, DISARMED, MANUAL);
        vehicle.report(2, &[AUTO], &[("no_mission", 1 << AUTO)]);
        vehicle.status(3, DISARMED, AUTO);
        assert_eq!(refusals(&vehicle.finish()), [("mode3", Some(2), None, true, vec!["no_mission"])]);
    }

    #[test]
    fn a_refusal_reported_in_flight_lasts_after_it() {
        let mut vehicle = Vehicle::new();
        vehicle.status(1, DISARMED, AUTO);
        vehicle.status(2, ARMED, AUTO);
        vehicle.report(5, &[AUTO], &[("no_fix", 1 << AUTO)]);
        vehicle.status(9, DISARMED, AUTO);
        assert_eq!(refusals(&vehicle.finish()), [("mode3", Some(9), None, true, vec!["no_fix"])]);
    }

    #[test]
    fn an_event_explains_one_change() {
        let mut vehicle = Vehicle::new();
        vehicle.status(1, DISARMED, MANUAL);
        vehicle.event(2, ARMED_BY);
        for (second, state) in [(2, ARMED), (3, DISARMED), (4, ARMED)] {
            vehicle.status(second, state, MANUAL);
        }
        let overview = vehicle.finish();
        let reasons: Vec<&str> =
            overview.flights.iter().map(|flight| text(flight.armed_by.as_ref())).collect();
        assert_eq!(reasons, ["Stick", "latest_arming_reason"]);
    }

    #[test]
    fn there_is_no_overview_without_the_state_of_a_single_vehicle() {
        let mut vehicle = Vehicle::new();
        vehicle.report(1, &[AUTO], &[]);
        vehicle.landed(2, false);
        vehicle.event(2, ARMED_BY);
        assert_eq!(vehicle.flights.finish(START), None);
        let mut vehicle = Vehicle::new();
        vehicle.status(1, DISARMED, MANUAL);
        vehicle.channel = 1;
        vehicle.status(2, ARMED, MANUAL);
        assert_eq!(vehicle.flights.finish(START), None);
    }

    #[test]
    fn the_last_flight_stays_the_same_if_there_are_too_many() {
        let mut vehicle = Vehicle::new();
        let last = 2 * u64::try_from(MAX_FLIGHTS).expect("a number");
        for second in 0..last {
            vehicle.status(second, if second % 2 == 0 { DISARMED } else { ARMED }, MANUAL);
        }
        vehicle.status(last, DISARMED, MANUAL);
        vehicle.status(last + 1, ARMED, MANUAL);
        vehicle.event(last + 7, DISARMED_BY);
        vehicle.status(last + 8, DISARMED, MANUAL);
        let overview = vehicle.finish();
        assert_eq!(overview.flights.len(), MAX_FLIGHTS);
        let flight = &overview.flights[MAX_FLIGHTS - 1];
        assert_eq!(seconds(flight.disarmed_us), Some(last.cast_signed()));
        assert_eq!(text(flight.disarmed_by.as_ref()), "latest_disarming_reason");
    }
}
