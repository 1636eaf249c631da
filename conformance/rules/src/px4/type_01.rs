//! `PX-TYPE-01`.

use uavspec_model::Endpoint;

use super::endpoints::{Pairs, name};
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-TYPE-01",
    name: "One type per topic",
    level: Level::Must,
    status: Status::Normative,
    statement: "All publishers and subscribers of a topic have the same type: the same name, and the same \
                type hash.",
    source: "DDS 1.4, 2.2.2.2; ROS 2 REP 2016 (RIHS01)",
    applies_to: "publishers and subscribers of a live vehicle",
    why: "Endpoints whose types have different names don't exchange messages. Endpoints with the same \
          name and different definitions exchange messages, but decode wrong values. The usual cause is \
          an application that was built for another PX4 release.",
    example: "publisher  /fmu/out/vehicle_status: px4_msgs/msg/VehicleStatus, RIHS01_2f8a…\n\
              subscriber /fmu/out/vehicle_status: px4_msgs/msg/VehicleStatus, RIHS01_77c1…",
    fix: "Build the application with the message definitions of the vehicle's release, or run PX4's \
          message translation node.",
})
.check(Check::State(|| Box::new(Pairs::new(violations))))
.bug(Bug::announced_type(
    Side::Autopilot,
    "A second publisher of arming_check_request announces a different type hash.",
))
.mutants(&[
    Mutant::mcap("an endpoint with a different type", |_, bag| {
        with_other(bag, |endpoint| "other_msgs/msg/Other".clone_into(&mut endpoint.type_name))
    }),
    Mutant::mcap("an endpoint with a different type hash", |_, bag| {
        with_other(bag, |endpoint| endpoint.type_hash = Some(format!("RIHS01_{}", "0".repeat(64))))
    }),
]);

/// The difference between the types of two endpoints. `None` if one of them announces no type.
fn violations(endpoint: &Endpoint, other: &Endpoint) -> Option<Vec<Detail>> {
    let are_known = [endpoint, other].iter().all(|endpoint| !endpoint.type_name.is_empty());
    are_known.then(|| difference(endpoint, other).into_iter().collect())
}

fn difference(endpoint: &Endpoint, other: &Endpoint) -> Option<Detail> {
    let (found, known) = (name(endpoint), name(other));
    if endpoint.type_name != other.type_name {
        let [ty, other] = [&endpoint.type_name, &other.type_name].map(|name| name.escape_debug().to_string());
        let text = format!("{found} has the type {ty}, but {known} has {other}");
        return Some(Detail::new(text).expected(other).actual(ty));
    }
    let (hash, other) = (endpoint.type_hash.as_ref()?, other.type_hash.as_ref()?);
    if hash.eq_ignore_ascii_case(other) {
        return None;
    }
    let [hash, other] = [hash, other].map(|hash| hash.escape_debug().to_string());
    let ty = endpoint.type_name.escape_debug();
    let text = format!("{found} and {known} define {ty} differently: messages decode as garbage");
    Some(Detail::new(text).expected(other).actual(hash))
}

/// Adds a changed copy of the first endpoint.
fn with_other(mut bag: Bag, change: impl FnOnce(&mut Endpoint)) -> Option<Bag> {
    let mut endpoint = bag.endpoints.first()?.clone();
    "application".clone_into(&mut endpoint.id);
    change(&mut endpoint);
    bag.endpoints.push(endpoint);
    Some(bag)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn endpoint(type_name: &str, type_hash: Option<&str>) -> Endpoint {
        let (type_name, type_hash) = (type_name.to_owned(), type_hash.map(str::to_owned));
        Endpoint { type_name, type_hash, ..Endpoint::publisher("/wind") }
    }

    /// The number of violations. `None` if the rule doesn't apply.
    fn count(endpoint: &Endpoint, other: &Endpoint) -> Option<usize> {
        violations(endpoint, other).map(|found| found.len())
    }

    #[test]
    fn unknown_types_are_not_compared() {
        let [known, unknown] = ["sky_msgs/msg/Wind", ""].map(|name| endpoint(name, None));
        assert_eq!(count(&known, &unknown), None);
        assert_eq!(count(&unknown, &known), None);
        assert_eq!(count(&unknown, &unknown), None);
    }

    #[test]
    fn names_and_known_hashes_are_compared() {
        let wind = endpoint("sky_msgs/msg/Wind", Some("RIHS01_1"));
        for (name, hash, expected) in [
            ("sky_msgs/msg/Wind", Some("RIHS01_1"), 0),
            ("sky_msgs/msg/Wind", None, 0),
            ("sky_msgs/msg/Wind", Some("RIHS01_2"), 1),
            ("sky_msgs/msg/Storm", Some("RIHS01_1"), 1),
        ] {
            assert_eq!(count(&wind, &endpoint(name, hash)), Some(expected), "{name} {hash:?}");
        }
    }
}
