//! The namespace of a vehicle, which precedes the names of its topics.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use uavspec_model::Endpoint;
use uavspec_rules::definitions::FOLDERS;

/// The namespace of a vehicle: `/uav_1` if its topics are in `/uav_1/fmu`, or empty if they are in `/fmu`.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Namespace(String);

impl Namespace {
    /// The namespace of the vehicle on a bus. Fails if there are several vehicles.
    pub(super) fn of_vehicle(endpoints: &[Endpoint]) -> Result<Self, String> {
        let found: BTreeSet<Self> = endpoints
            .iter()
            .filter_map(|endpoint| Self::split(&endpoint.topic))
            .map(|(own, _)| own)
            .collect();
        if found.len() > 1 {
            let names: Vec<String> = found.iter().map(Self::to_string).collect();
            return Err(format!(
                "there are several vehicles: choose one with --namespace {}",
                names.join(" or ")
            ));
        }
        Ok(found.into_iter().next().unwrap_or_default())
    }

    /// The name of a topic without the vehicle's namespace, such as `/fmu/out/vehicle_status`. `None` if PX4 doesn't
    /// exchange the topic with applications, or if the topic belongs to another vehicle.
    pub(super) fn strip<'t>(&self, topic: &'t str) -> Option<&'t str> {
        Self::split(topic).filter(|(namespace, _)| namespace == self).map(|(_, rest)| rest)
    }

    /// The full name of a topic such as `/fmu/out/vehicle_status`.
    pub(super) fn join(&self, topic: &str) -> String {
        format!("{}{topic}", self.0)
    }

    fn split(topic: &str) -> Option<(Self, &str)> {
        let at = FOLDERS.iter().find_map(|folder| topic.find(folder))?;
        let (namespace, rest) = topic.split_at(at);
        Some((Self(namespace.to_owned()), rest))
    }
}

impl fmt::Display for Namespace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() { f.write_str("/") } else { self.0.escape_debug().fmt(f) }
    }
}

impl FromStr for Namespace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = text.strip_prefix('/').unwrap_or(text);
        let is_name = |name: &str| {
            name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
                && name.chars().all(|char| char.is_ascii_alphanumeric() || char == '_')
        };
        match names {
            "" => Ok(Self::default()),
            names if names.split('/').all(is_name) => Ok(Self(format!("/{names}"))),
            _ => Err("a namespace consists of letters, digits, `_` and `/`, such as uav_1".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_vehicle() {
        let find = |topics: &[&str]| {
            let endpoints: Vec<Endpoint> = topics.iter().copied().map(Endpoint::publisher).collect();
            Namespace::of_vehicle(&endpoints).map(|found| found.0)
        };
        assert_eq!(find(&["/rosout", "/fmu/out/wind"]), Ok(String::new()));
        assert_eq!(find(&["/a/b/fmu/in/wind", "/a/b/fmu/out/wind", "/c/wind"]), Ok("/a/b".to_owned()));
        let problem = "there are several vehicles: choose one with --namespace / or /a";
        assert_eq!(find(&["/a/fmu/in/wind", "/fmu/out/wind"]), Err(problem.to_owned()));
    }

    #[test]
    fn reads_names() {
        for (text, expected) in [("", ""), ("/", ""), ("uav_1", "/uav_1"), ("/fleet/uav", "/fleet/uav")] {
            assert_eq!(text.parse(), Ok(Namespace(expected.to_owned())));
        }
        for text in ["1", "a//b", "a/", "a b", "//", "ä"] {
            assert!(text.parse::<Namespace>().is_err(), "{text}");
        }
    }

    #[test]
    fn topics_belong_to_one_vehicle() {
        let own: Namespace = "a".parse().expect("a name");
        assert_eq!(own.strip("/a/fmu/out/wind"), Some("/fmu/out/wind"));
        assert_eq!(own.strip("/fmu/out/wind"), None);
        assert_eq!(own.strip("/a/wind"), None);
        assert_eq!(Namespace::default().strip("/fmu/in/wind"), Some("/fmu/in/wind"));
    }
}
