//! A limited map from the ids of UAVs to their data.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use uavspec_flockwave::limits::MAX_ID;

use crate::limits::MAX_UAVS;

/// The time for which a UAV is kept after a report, even if a list doesn't contain it. The list may be older than the
/// report, and some servers report UAVs that they don't list.
const GRACE_PERIOD: Duration = Duration::from_secs(10);

/// A list of ids.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct List {
    /// The ids.
    pub ids: Vec<String>,
    /// True if the list contains all ids of the message.
    pub is_whole: bool,
}

/// The data of a UAV.
#[derive(Debug)]
pub(super) struct Member<T> {
    /// The time of the last unsolicited report.
    pub(super) last_reported: Option<Instant>,
    /// The data.
    pub(super) value: T,
}

/// UAVs by their ids.
#[derive(Debug, Default)]
pub(super) struct Roster<T> {
    /// The UAVs. Only [`admit`](Self::admit) adds them.
    pub(super) members: BTreeMap<String, Member<T>>,
}

impl<T: Default> Roster<T> {
    /// Returns the data of the UAV with this id. Adds the UAV if necessary. Returns `None` if a limit is exceeded.
    pub(super) fn admit(&mut self, id: &str) -> Option<&mut Member<T>> {
        if !self.members.contains_key(id) {
            if id.len() > MAX_ID || self.members.len() >= MAX_UAVS {
                return None;
            }
            self.members.insert(id.to_owned(), Member { last_reported: None, value: T::default() });
        }
        self.members.get_mut(id)
    }

    /// Adds the UAVs in a list. If the list is whole, removes all UAVs that are neither in it nor recently reported.
    /// Returns true if the list is whole and all of its UAVs could be added.
    pub(super) fn update(&mut self, list: &List, now: Instant) -> bool {
        if list.is_whole {
            let listed: BTreeSet<&str> = list.ids.iter().map(String::as_str).collect();
            self.members.retain(|id, member| {
                let is_fresh = member
                    .last_reported
                    .is_some_and(|last_reported| now.saturating_duration_since(last_reported) < GRACE_PERIOD);
                is_fresh || listed.contains(id.as_str())
            });
        }
        let admitted = list.ids.iter().filter(|id| self.admit(id).is_some()).count();
        list.is_whole && admitted == list.ids.len()
    }
}

#[cfg(test)]
mod tests {
    use uavspec_model::clock::Clock;

    use super::*;

    fn list(ids: &[&str]) -> List {
        List { ids: ids.iter().map(|id| (*id).to_owned()).collect(), is_whole: true }
    }

    fn ids(roster: &Roster<u8>) -> Vec<&str> {
        roster.members.keys().map(String::as_str).collect()
    }

    #[test]
    fn removes_unlisted_uavs_unless_recently_reported() {
        let now = Clock::simulated().now();
        let mut roster = Roster::default();
        assert!(roster.update(&list(&["glider-1", "glider-2"]), now));
        roster.admit("glider-2").expect("room").last_reported = Some(now);
        roster.admit("glider-3").expect("room").last_reported = Some(now);
        assert!(roster.update(&list(&["glider-4"]), now + GRACE_PERIOD / 2));
        assert_eq!(ids(&roster), ["glider-2", "glider-3", "glider-4"]);
        assert!(!roster.update(&List { is_whole: false, ..list(&["glider-5"]) }, now + GRACE_PERIOD));
        assert_eq!(ids(&roster).len(), 4, "an incomplete list removes no UAVs");
        assert!(roster.update(&list(&["glider-4"]), now + GRACE_PERIOD));
        assert_eq!(ids(&roster), ["glider-4"]);
    }

    #[test]
    fn limits_the_number_and_length_of_ids() {
        let mut roster = Roster::<u8>::default();
        assert!(roster.admit(&"g".repeat(MAX_ID + 1)).is_none());
        for number in 0..MAX_UAVS {
            assert!(roster.admit(&format!("glider-{number}")).is_some());
        }
        assert!(roster.admit("one too many").is_none());
        assert!(roster.admit("glider-0").is_some());
        assert_eq!(roster.members.len(), MAX_UAVS);
        assert!(
            !roster.update(&List { is_whole: false, ..list(&["one too many"]) }, Clock::simulated().now())
        );
    }
}
