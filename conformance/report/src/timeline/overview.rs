//! The summary for a pilot, in sentences.

use uavspec_check::timeline::{Flight, Overview, Part, Refusal, reasons_text};
use uavspec_model::text::shown;

use super::{clock, duration};

/// The sentences of an overview, in chronological order.
pub(super) fn sentences(overview: &Overview, language: &str) -> Vec<String> {
    let refusals = joined(overview.refusals.iter().filter(|refusal| refusal.is_selected));
    let refusals = refusals.iter().map(|refusal| (refusal.from_us, self::refusal(refusal, language)));
    let flights = overview.flights.iter().map(|flight| (start(flight), self::flight(flight, language)));
    let mut sentences: Vec<(i64, String)> = refusals.chain(flights).collect();
    sentences.sort_by_key(|(time, _)| *time);
    sentences.into_iter().map(|(_, sentence)| sentence).collect()
}

/// The question why the vehicle couldn't arm.
#[derive(Clone, Debug, Default)]
pub struct WhyNotArm {
    /// The time that the question is about, in µs since the start. `None` means the whole capture.
    pub time_us: Option<i64>,
    /// The name of the mode that the question is about. `None` means the modes that the vehicle was in.
    pub mode: Option<String>,
}

impl WhyNotArm {
    /// The refusals that answer the question.
    pub fn refusals<'o>(&self, overview: &'o Overview) -> Vec<&'o Refusal> {
        let is_at = |refusal: &Refusal| {
            let until = refusal.until_us.unwrap_or(i64::MAX);
            self.time_us.is_none_or(|time| refusal.from_us <= time && time < until)
        };
        let is_of = |refusal: &Refusal| match &self.mode {
            Some(mode) => refusal.mode.is_named(mode),
            None => refusal.is_selected,
        };
        overview.refusals.iter().filter(|refusal| is_at(refusal) && is_of(refusal)).collect()
    }

    /// The answer, with a line for each refusal.
    pub fn answer(&self, overview: &Overview, language: &str) -> String {
        let refusals = self.refusals(overview);
        if refusals.is_empty() {
            return "No health and arming report says that the vehicle couldn't arm.\n".to_owned();
        }
        joined(refusals.into_iter()).iter().map(|found| refusal(found, language) + "\n").collect()
    }
}

/// Joins consecutive refusals in the same mode. A joined refusal has the reasons of all of them.
fn joined<'o>(refusals: impl Iterator<Item = &'o Refusal>) -> Vec<Refusal> {
    let mut joined: Vec<Refusal> = Vec::new();
    for refusal in refusals {
        let before = joined.iter_mut().rev().find(|before| before.mode == refusal.mode);
        let Some(before) = before.filter(|before| before.until_us == Some(refusal.from_us)) else {
            joined.push(refusal.clone());
            continue;
        };
        before.until_us = refusal.until_us;
        for (known, new) in [(&mut before.reasons, &refusal.reasons), (&mut before.general, &refusal.general)]
        {
            known.extend(new.iter().filter(|part| !known.contains(part)).cloned().collect::<Vec<_>>());
        }
    }
    joined
}

fn refusal(refusal: &Refusal, language: &str) -> String {
    let from = if refusal.from_us > 0 { format!(" from {}", clock(refusal.from_us)) } else { String::new() };
    let until = refusal.until_us.map_or_else(|| "the end".to_owned(), clock);
    let reasons = reasons_text(&refusal.reasons, &refusal.general, |part| label(part, language));
    let reasons = reasons.unwrap_or_else(|| "no reason is recorded".to_owned());
    format!("Couldn't arm in {}{from} until {until}: {reasons}.", label(&refusal.mode, language))
}

/// The time of the first event in a flight.
fn start(flight: &Flight) -> i64 {
    let steps = flight.takeoffs_us.iter().chain(&flight.landings_us).chain(&flight.disarmed_us);
    flight.armed_us.or_else(|| steps.min().copied()).unwrap_or(i64::MIN)
}

fn flight(flight: &Flight, language: &str) -> String {
    let mut steps: Vec<(i64, String)> = Vec::new();
    let because = |reason: &Option<Part>| {
        reason.as_ref().map(|reason| format!(" ({})", label(reason, language))).unwrap_or_default()
    };
    steps.extend(
        flight.armed_us.map(|at| (at, format!("armed at {}{}", clock(at), because(&flight.armed_by)))),
    );
    steps.extend(flight.takeoffs_us.iter().map(|at| (*at, format!("took off at {}", clock(*at)))));
    steps.extend(flight.landings_us.iter().map(|at| (*at, format!("landed at {}", clock(*at)))));
    let disarmed = |at| (at, format!("disarmed at {}{}", clock(at), because(&flight.disarmed_by)));
    steps.extend(flight.disarmed_us.map(disarmed));
    steps.sort_by_key(|(time, _)| *time);
    let mut steps: Vec<String> = steps.into_iter().map(|(_, step)| step).collect();
    if flight.armed_us.is_none() {
        steps.insert(0, "armed at the start".to_owned());
    }
    if flight.disarmed_us.is_none() {
        steps.push("still armed at the end".to_owned());
    }
    let steps = steps.join(", ");
    let (first, rest) = steps.split_at(1);
    let air = airtime(flight).map(|time| format!(" In the air for {}.", duration(time))).unwrap_or_default();
    format!("{}{rest}.{air}", first.to_uppercase())
}

/// The total time between takeoffs and landings, in µs. `None` if they aren't all known.
fn airtime(flight: &Flight) -> Option<u64> {
    let Flight { takeoffs_us: takeoffs, landings_us: landings, .. } = flight;
    if takeoffs.is_empty() || takeoffs.len() != landings.len() {
        return None;
    }
    let times = takeoffs.iter().zip(landings).map(|(takeoff, landing)| u64::try_from(landing - takeoff).ok());
    times.sum()
}

fn label(part: &Part, language: &str) -> String {
    shown(part.label.as_ref().map_or(&part.name, |label| label.in_language(language)))
}
