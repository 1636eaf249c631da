//! The quality of service in rustdds.

use std::time::Duration;

use rustdds::{QosPolicies, policy};
use uavspec_model::{Durability, EndpointKind, History, Liveliness, Qos, Reliability};

/// The seconds of an infinite duration.
const INFINITE: u64 = 0x7fff_ffff;

/// The announced quality of service. A policy that isn't announced has the default of DDS.
pub(crate) fn from_policies(policies: &QosPolicies, kind: EndpointKind) -> Qos {
    let (liveliness, lease) = policies.liveliness().map_or((Liveliness::Automatic, None), from_liveliness);
    Qos {
        reliability: match policies.reliability() {
            Some(policy::Reliability::Reliable { .. }) => Reliability::Reliable,
            None if kind == EndpointKind::Publisher => Reliability::Reliable,
            _ => Reliability::BestEffort,
        },
        durability: match policies.durability() {
            None | Some(policy::Durability::Volatile) => Durability::Volatile,
            Some(policy::Durability::TransientLocal) => Durability::TransientLocal,
            Some(policy::Durability::Transient) => Durability::Transient,
            Some(policy::Durability::Persistent) => Durability::Persistent,
        },
        history: policies.history().map(|history| match history {
            policy::History::KeepLast { depth } => History::KeepLast(depth.unsigned_abs()),
            policy::History::KeepAll => History::KeepAll,
        }),
        deadline: policies.deadline().and_then(|deadline| finite(deadline.0)),
        lifespan: policies.lifespan().and_then(|lifespan| finite(lifespan.duration)),
        liveliness,
        lease,
        partitions: Vec::new(),
    }
}

fn from_liveliness(liveliness: policy::Liveliness) -> (Liveliness, Option<Duration>) {
    let (kind, lease) = match liveliness {
        policy::Liveliness::Automatic { lease_duration } => (Liveliness::Automatic, lease_duration),
        policy::Liveliness::ManualByParticipant { lease_duration } => {
            (Liveliness::ManualByParticipant, lease_duration)
        }
        policy::Liveliness::ManualByTopic { lease_duration } => (Liveliness::ManualByTopic, lease_duration),
    };
    (kind, finite(lease))
}

/// A duration. `None` if it is infinite. A negative duration is invalid, and is treated as zero.
fn finite(duration: rustdds::Duration) -> Option<Duration> {
    let time = Duration::from_nanos(u64::try_from(duration.to_nanoseconds()).unwrap_or(0));
    (time < Duration::from_secs(INFINITE)).then_some(time)
}

/// The policies of an endpoint of this program.
pub(crate) fn to_policies(qos: &Qos) -> QosPolicies {
    let lease_duration = to_duration(qos.lease);
    let mut builder = QosPolicies::builder()
        .reliability(match qos.reliability {
            Reliability::BestEffort => policy::Reliability::BestEffort,
            Reliability::Reliable => {
                policy::Reliability::Reliable { max_blocking_time: rustdds::Duration::from_millis(100) }
            }
        })
        .durability(match qos.durability {
            Durability::Volatile => policy::Durability::Volatile,
            Durability::TransientLocal => policy::Durability::TransientLocal,
            Durability::Transient => policy::Durability::Transient,
            Durability::Persistent => policy::Durability::Persistent,
        })
        .liveliness(match qos.liveliness {
            Liveliness::Automatic => policy::Liveliness::Automatic { lease_duration },
            Liveliness::ManualByParticipant => policy::Liveliness::ManualByParticipant { lease_duration },
            Liveliness::ManualByTopic => policy::Liveliness::ManualByTopic { lease_duration },
        })
        .history(match qos.history {
            None => policy::History::KeepLast { depth: 1 },
            Some(History::KeepLast(depth)) => {
                policy::History::KeepLast { depth: i32::try_from(depth).unwrap_or(i32::MAX).max(1) }
            }
            Some(History::KeepAll) => policy::History::KeepAll,
        });
    if qos.deadline.is_some() {
        builder = builder.deadline(policy::Deadline(to_duration(qos.deadline)));
    }
    if qos.lifespan.is_some() {
        builder = builder.lifespan(policy::Lifespan { duration: to_duration(qos.lifespan) });
    }
    builder.build()
}

fn to_duration(time: Option<Duration>) -> rustdds::Duration {
    let longest = Duration::from_secs(INFINITE - 1);
    time.map_or(rustdds::Duration::INFINITE, |time| rustdds::Duration::from_std(time.min(longest)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(qos: &Qos) -> Qos {
        from_policies(&to_policies(qos), EndpointKind::Publisher)
    }

    #[test]
    fn policies_keep_the_quality_of_service() {
        assert_eq!(read(&Qos::PX4), Qos::PX4);
        let qos = Qos {
            reliability: Reliability::Reliable,
            durability: Durability::Persistent,
            history: Some(History::KeepAll),
            deadline: Some(Duration::from_secs(1)),
            lifespan: Some(Duration::from_secs(2)),
            liveliness: Liveliness::ManualByTopic,
            lease: Some(Duration::from_secs(3)),
            partitions: Vec::new(),
        };
        assert_eq!(read(&qos), qos);
        let durations = Qos { deadline: Some(Duration::MAX), ..qos };
        assert_eq!(read(&durations).deadline, Some(Duration::from_secs(INFINITE - 1)));
    }

    #[test]
    fn policies_that_are_not_announced_have_the_defaults_of_dds() {
        let none = QosPolicies::qos_none();
        assert_eq!(from_policies(&none, EndpointKind::Publisher).reliability, Reliability::Reliable);
        assert_eq!(from_policies(&none, EndpointKind::Subscriber).reliability, Reliability::BestEffort);
        assert_eq!(from_policies(&none, EndpointKind::Publisher).durability, Durability::Volatile);
    }
}
