//! The summary for a pilot: why the vehicle couldn't arm, when it flew, and why it disarmed.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use uavspec_dynamic::DynamicView;
use uavspec_dynamic::event::DecodedEvent;
use uavspec_model::Channel;
use uavspec_px4::checks::{ModeGroup, Problem, Report};
use uavspec_px4::event::EventMetadata;

use super::events::part_of;
use super::number;
use crate::limits::{MAX_FLIGHTS, MAX_REFUSALS};
use crate::timeline::label::{Label, Texts};
use crate::timeline::lane::Part;

/// `vehicle_status.arming_state` of an armed vehicle, in all releases.
const ARMED: i128 = 2;

/// The events that say who armed or disarmed the vehicle, with the argument that names the reason.
const ARMED_BY: &str = "commander_armed_by";
const DISARMED_BY: &str = "commander_disarmed_by";

/// The time within which such an event belongs to a change of the state, in µs.
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

/// A time at which the vehicle couldn't arm in a mode.
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
    /// The reasons, in the order in which they were first reported.
    pub reasons: Vec<Part>,
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
    /// The channel of the state. With a second one, there are several vehicles, which can't be distinguished.
    channel: Option<usize>,
    is_ambiguous: bool,
    is_armed: Option<bool>,
    is_landed: Option<bool>,
    mode: Option<i128>,
    /// The modes in which the vehicle can't arm now: the index in the refusals, by bit.
    open: BTreeMap<u32, usize>,
    /// The latest events about arming and disarming, each with its time.
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
}

/// A time for an [`Overview`], which is later made relative to the start.
fn instant(time: u64) -> i64 {
    i64::try_from(time).unwrap_or(i64::MAX)
}

impl Flights {
    /// Takes the state from a message of `vehicle_status`. `stated` returns a reason that the message states.
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
        let Some(is_armed) = number(values, "arming_state").map(|state| state == ARMED) else { return };
        let was_armed = self.is_armed.replace(is_armed);
        if was_armed == Some(is_armed) {
            return;
        }
        if is_armed {
            self.end_refusals(time, |_| true);
            let flight = Flight {
                armed_us: was_armed.map(|_| instant(time)),
                armed_by: was_armed
                    .and_then(|_| self.reason(0, time).or_else(|| stated("latest_arming_reason"))),
                ..Flight::default()
            };
            if self.overview.flights.len() < MAX_FLIGHTS {
                self.overview.flights.push(flight);
            }
        } else if was_armed.is_some() {
            let reason = self.reason(1, time).or_else(|| stated("latest_disarming_reason"));
            if let Some(flight) = self.overview.flights.last_mut() {
                flight.disarmed_us.get_or_insert(instant(time));
                flight.disarmed_by = reason;
            }
        }
    }

    /// Takes the state from a message of `vehicle_land_detected`.
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
        let which = match event.event.name.as_str() {
            ARMED_BY => 0,
            DISARMED_BY => 1,
            _ => return,
        };
        let Some(reason) = event.argument(0).map(|reason| reason.to_string()) else { return };
        let part = Part::new(event.event.name.clone(), Label::plain(&reason));
        // The event may follow the state that it explains.
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

    fn reason(&self, which: usize, time: u64) -> Option<Part> {
        let found = self.reasons[which].as_ref().filter(|(at, _)| time.abs_diff(*at) <= NEAR);
        found.map(|(_, part)| part.clone())
    }

    /// Takes the reasons against arming from a report.
    pub(super) fn report(&mut self, report: &Report, refused: Vec<Refused>, time: u64) {
        if self.overview.modes.is_empty() {
            self.overview.modes = report.modes.values().map(part).collect();
        }
        self.end_refusals(time, |bit| refused.iter().all(|refused| refused.number != bit));
        if self.is_armed == Some(true) {
            return;
        }
        let selected = self.mode.and_then(|mode| u32::try_from(mode).ok());
        for Refused { number, mode, reasons } in refused {
            let refusals = &mut self.overview.refusals;
            let index = *self.open.entry(number).or_insert(refusals.len());
            if index == refusals.len() && index < MAX_REFUSALS {
                let (from_us, reasons) = (instant(time), Vec::new());
                refusals.push(Refusal { mode, is_selected: false, from_us, until_us: None, reasons });
            }
            let Some(open) = refusals.get_mut(index) else { continue };
            open.is_selected |= selected == Some(number);
            for part in reasons {
                if !open.reasons.contains(&part) {
                    open.reasons.push(part);
                }
            }
        }
    }

    /// Ends the refusals of some modes.
    fn end_refusals(&mut self, time: u64, is_over: impl Fn(u32) -> bool) {
        let refusals = &mut self.overview.refusals;
        self.open.retain(|bit, index| {
            let is_over = is_over(*bit);
            if is_over && let Some(open) = refusals.get_mut(*index) {
                open.until_us = Some(instant(time));
            }
            !is_over
        });
    }

    /// The overview, with times relative to `start`. `None` if the capture doesn't show the state of a single vehicle.
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

/// The modes in which the vehicle can't arm. PX4 reports a problem that prevents nothing for all modes, so such problems
/// are reasons only if there are no others.
pub fn refused_modes(report: &Report, metadata: &EventMetadata, texts: &Texts) -> Vec<Refused> {
    let refused = report.modes.iter().filter(|(_, mode)| !mode.can_arm).map(|(bit, mode)| {
        let problems = || report.problems.iter().filter(|problem| problem.modes & 1 << bit != 0);
        let is_general = |problem: &Problem| problem.modes >= u64::from(u32::MAX);
        let has_specific = problems().any(|problem| !is_general(problem));
        let reasons = problems().filter(|problem| !has_specific || !is_general(problem));
        let reasons = reasons.filter_map(|problem| part_of(problem, metadata, texts)).collect();
        Refused { number: *bit, mode: part(mode), reasons }
    });
    refused.collect()
}
