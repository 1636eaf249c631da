//! The quality of service in tokens: `RELIABILITY:DURABILITY:HISTORY,DEPTH:DEADLINE:LIFESPAN:LIVELINESS,LEASE`.
//!
//! The numbers come from the header `rmw/types.h`. Default values are left out.

use std::str::FromStr;
use std::time::Duration;

use uavspec_model::{Durability, History, Liveliness, Qos, Reliability};

/// The default depth.
const DEPTH: u32 = 42;

/// The seconds and nanoseconds of an unlimited duration.
const UNLIMITED: (u64, u32) = (9_223_372_036, 854_775_807);

/// Parses a quality of service. The parts after the depth are optional: early versions don't write them.
pub(super) fn parse_qos(text: &str) -> Result<Qos, String> {
    let mut fields = text.splitn(6, ':');
    let mut next = || {
        fields.next().ok_or_else(|| {
            format!("expected RELIABILITY:DURABILITY:HISTORY,DEPTH, found `{}`", text.escape_debug())
        })
    };
    let reliability = match next()? {
        "" | "0" | "1" => Reliability::Reliable,
        "2" => Reliability::BestEffort,
        other => return Err(unknown("reliability", other)),
    };
    let durability = match next()? {
        "1" => Durability::TransientLocal,
        "" | "0" | "2" => Durability::Volatile,
        other => return Err(unknown("durability", other)),
    };
    let history = Some(parse_history(next()?)?);
    let deadline = parse_duration(fields.next().unwrap_or_default())?;
    let lifespan = parse_duration(fields.next().unwrap_or_default())?;
    let (kind, lease) = fields.next().unwrap_or_default().split_once(',').unwrap_or_default();
    let liveliness = match kind {
        "" | "0" | "1" => Liveliness::Automatic,
        "2" => Liveliness::ManualByParticipant,
        "3" => Liveliness::ManualByTopic,
        other => return Err(unknown("liveliness", other)),
    };
    let lease = parse_duration(lease)?;
    Ok(Qos {
        reliability,
        durability,
        history,
        deadline,
        lifespan,
        liveliness,
        lease,
        partitions: Vec::new(),
    })
}

fn unknown(policy: &str, found: &str) -> String {
    format!("{policy}: expected a value from rmw/types.h, found `{}`", found.escape_debug())
}

fn parse_history(text: &str) -> Result<History, String> {
    let (kind, depth) = text.split_once(',').unwrap_or((text, ""));
    match kind {
        "" | "0" | "1" => {
            let depth = if depth.is_empty() { DEPTH } else { number(depth, "depth")? };
            Ok(History::KeepLast(if depth == 0 { DEPTH } else { depth }))
        }
        "2" => Ok(History::KeepAll),
        other => Err(unknown("history", other)),
    }
}

/// Parses `SECONDS,NANOSECONDS`. In ROS, zero means "unspecified", so it is also treated as unlimited.
fn parse_duration(text: &str) -> Result<Option<Duration>, String> {
    let (seconds, nanoseconds) = text.split_once(',').unwrap_or((text, ""));
    let seconds = if seconds.is_empty() { UNLIMITED.0 } else { number(seconds, "seconds")? };
    let nanoseconds = if nanoseconds.is_empty() { UNLIMITED.1 } else { number(nanoseconds, "nanoseconds")? };
    if nanoseconds >= 1_000_000_000 {
        return Err(format!("expected fewer than 1,000,000,000 nanoseconds, found {nanoseconds}"));
    }
    let is_unlimited = (seconds, nanoseconds) == UNLIMITED || (seconds, nanoseconds) == (0, 0);
    Ok((!is_unlimited).then(|| Duration::new(seconds, nanoseconds)))
}

fn number<T: FromStr>(text: &str, field: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("{field}: expected a number, found `{}`", text.escape_debug()))
}

/// Formats a quality of service. In Zenoh, messages never outlive their publisher, so anything more durable than
/// transient local becomes transient local.
pub(super) fn format_qos(qos: &Qos) -> String {
    let reliability = if qos.reliability == Reliability::BestEffort { "2" } else { "" };
    let durability = if qos.durability == Durability::Volatile { "" } else { "1" };
    let history = match qos.history {
        None | Some(History::KeepLast(DEPTH)) => ",".to_owned(),
        Some(History::KeepLast(depth)) => format!(",{depth}"),
        Some(History::KeepAll) => "2,".to_owned(),
    };
    let [deadline, lifespan, lease] = [qos.deadline, qos.lifespan, qos.lease].map(format_duration);
    let liveliness = match qos.liveliness {
        Liveliness::Automatic => "",
        Liveliness::ManualByParticipant => "2",
        Liveliness::ManualByTopic => "3",
    };
    format!("{reliability}:{durability}:{history}:{deadline}:{lifespan}:{liveliness},{lease}")
}

fn format_duration(duration: Option<Duration>) -> String {
    let (seconds, nanoseconds) = duration.map_or(UNLIMITED, |time| (time.as_secs(), time.subsec_nanos()));
    let part = |value: u64, default: u64| if value == default { String::new() } else { value.to_string() };
    format!("{},{}", part(seconds, UNLIMITED.0), part(nanoseconds.into(), UNLIMITED.1.into()))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn duration() -> impl Strategy<Value = Option<Duration>> {
        let seconds = prop_oneof![0_u64..5, Just(UNLIMITED.0)];
        let nanoseconds = prop_oneof![1_u32..1_000_000_000, Just(UNLIMITED.1)];
        (seconds, nanoseconds).prop_map(|time| (time != UNLIMITED).then(|| Duration::new(time.0, time.1)))
    }

    proptest! {
        #[test]
        fn a_formatted_qos_parses_to_itself(
            reliability in prop::sample::select(vec![Reliability::BestEffort, Reliability::Reliable]),
            durability in prop::sample::select(vec![Durability::Volatile, Durability::TransientLocal]),
            history in prop_oneof![Just(History::KeepAll), (1_u32..100).prop_map(History::KeepLast)],
            liveliness in prop::sample::select(vec![Liveliness::Automatic, Liveliness::ManualByTopic]),
            [deadline, lifespan, lease] in [duration(), duration(), duration()],
        ) {
            let (history, partitions) = (Some(history), Vec::new());
            let qos =
                Qos { reliability, durability, history, deadline, lifespan, liveliness, lease, partitions };
            prop_assert_eq!(parse_qos(&format_qos(&qos)), Ok(qos));
        }

        #[test]
        fn any_text_parses_without_panic(text in "[0-9:,-]{0,40}") {
            drop(parse_qos(&text));
        }
    }

    #[test]
    fn missing_values_are_defaults() {
        let qos = parse_qos("::,").expect("valid");
        assert_eq!((qos.reliability, qos.durability), (Reliability::Reliable, Durability::Volatile));
        assert_eq!((qos.history, qos.lease), (Some(History::KeepLast(42)), None));
        assert_eq!(parse_qos("2:1:,1:,:,:,,"), Ok(Qos::PX4));
        assert_eq!(parse_qos("1:2:1,10").map(|qos| qos.history), Ok(Some(History::KeepLast(10))));
    }

    #[test]
    fn errors_name_the_policy() {
        for (text, part) in [
            ("7:1:,1", "reliability: expected a value from rmw/types.h, found `7`"),
            ("1", "expected RELIABILITY:DURABILITY:HISTORY,DEPTH, found `1`"),
            ("::,x", "depth: expected a number, found `x`"),
            ("::,:0,1999999999:,:,,", "expected fewer than 1,000,000,000 nanoseconds"),
        ] {
            assert!(parse_qos(text).expect_err("an error").contains(part), "{text}");
        }
    }
}
