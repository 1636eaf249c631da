//! Seats: the places for clients, and the decision which client gives way to a newcomer.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The clients of one kind. Their number is limited.
#[derive(Debug)]
pub(super) struct Seats<K> {
    total: usize,
    idle_time: Duration,
    taken: BTreeMap<K, Seat>,
}

#[derive(Clone, Copy, Debug)]
struct Seat {
    /// True if the client has sent a valid request.
    has_requested: bool,
    last_active: Instant,
}

/// The decision about a newcomer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Admission<K> {
    /// There is a free seat.
    Free,
    /// This client gives way.
    Evict(K),
    /// There is no free seat, and no client has to give way.
    Refused,
}

impl<K: Ord + Clone> Seats<K> {
    /// Creates seats for this many clients. After `idle_time` without a request, a client may have to give way.
    pub(super) fn new(total: usize, idle_time: Duration) -> Self {
        Self { total, idle_time, taken: BTreeMap::new() }
    }

    /// Decides about a newcomer. If there is no free seat, clients that never sent a request give way first, and then
    /// idle clients. Among them, the client that was inactive for the longest time gives way.
    pub(super) fn admit(&self, now: Instant) -> Admission<K> {
        if self.taken.len() < self.total {
            return Admission::Free;
        }
        let idlest = self.taken.iter().min_by_key(|(_, seat)| (seat.has_requested, seat.last_active));
        match idlest {
            Some((key, seat)) if !seat.has_requested || seat.is_inactive(self.idle_time, now) => {
                Admission::Evict(key.clone())
            }
            _ => Admission::Refused,
        }
    }

    /// Adds a client.
    pub(super) fn insert(&mut self, key: K, now: Instant) {
        self.taken.insert(key, Seat { has_requested: false, last_active: now });
    }

    /// Records that a client is active.
    pub(super) fn touch(&mut self, key: &K, has_requested: bool, now: Instant) {
        if let Some(seat) = self.taken.get_mut(key) {
            seat.has_requested |= has_requested;
            seat.last_active = now;
        }
    }

    /// Removes a client.
    pub(super) fn remove(&mut self, key: &K) {
        self.taken.remove(key);
    }

    /// The clients that have been inactive for this time.
    pub(super) fn inactive(&self, time: Duration, now: Instant) -> Vec<K> {
        let inactive = self.taken.iter().filter(|(_, seat)| seat.is_inactive(time, now));
        inactive.map(|(key, _)| key.clone()).collect()
    }
}

impl Seat {
    fn is_inactive(self, time: Duration, now: Instant) -> bool {
        now.saturating_duration_since(self.last_active) >= time
    }
}

#[cfg(test)]
mod tests {
    use uavspec_model::clock::Clock;

    use super::*;

    const IDLE_TIME: Duration = Duration::from_secs(10);

    /// Three seats, taken by the clients 1, 2 and 3, one after another.
    fn full(now: Instant) -> Seats<u32> {
        let mut seats = Seats::new(3, IDLE_TIME);
        for key in 1..=3 {
            assert_eq!(seats.admit(now), Admission::Free);
            seats.insert(key, now + Duration::from_millis(key.into()));
        }
        seats
    }

    #[test]
    fn evicts_the_idlest_client_that_never_sent_a_request() {
        let now = Clock::simulated().now();
        let mut seats = full(now);
        assert_eq!(seats.admit(now), Admission::Evict(1));
        seats.touch(&1, true, now);
        assert_eq!(seats.admit(now), Admission::Evict(2));
        seats.touch(&2, false, now + Duration::from_secs(1));
        assert_eq!(seats.admit(now), Admission::Evict(3));
        seats.remove(&2);
        assert_eq!(seats.admit(now), Admission::Free);
    }

    #[test]
    fn refuses_newcomers_while_all_clients_are_active() {
        let now = Clock::simulated().now();
        let mut seats = full(now);
        for key in [2, 1, 3] {
            seats.touch(&key, true, now + Duration::from_secs(key.into()));
        }
        assert_eq!(seats.admit(now + IDLE_TIME), Admission::Refused);
        assert_eq!(seats.admit(now + IDLE_TIME + Duration::from_secs(1)), Admission::Evict(1));
    }

    #[test]
    fn lists_inactive_clients() {
        let now = Clock::simulated().now();
        let mut seats = full(now);
        let later = now + Duration::from_secs(5);
        seats.touch(&2, false, later);
        assert_eq!(seats.inactive(Duration::from_secs(4), later), [1, 3]);
    }
}
