//! Seats: the limited places for clients, and the decision about which client gives way to a newcomer.

use std::time::{Duration, Instant};

use super::limits::IDLE_TIME;

/// The place of a client.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seat {
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

impl Seat {
    /// The seat of a client that has sent no request.
    pub(super) fn new(now: Instant) -> Self {
        Self { has_requested: false, last_active: now }
    }

    /// The seat of a client that has just sent a valid request.
    pub(super) fn of_active(now: Instant) -> Self {
        Self { has_requested: true, last_active: now }
    }

    /// The time since the last request, or since the seat was taken.
    pub(super) fn idle_time(self, now: Instant) -> Duration {
        now.saturating_duration_since(self.last_active)
    }
}

/// Decides about a newcomer. If there is no free seat, clients that never sent a request give way first, and then idle
/// clients. Among them, the client that was inactive for the longest time gives way.
pub(super) fn admit<K>(
    taken: impl ExactSizeIterator<Item = (K, Seat)>,
    total: usize,
    now: Instant,
) -> Admission<K> {
    if taken.len() < total {
        return Admission::Free;
    }
    match taken.min_by_key(|(_, seat)| (seat.has_requested, seat.last_active)) {
        Some((key, seat)) if !seat.has_requested || seat.idle_time(now) >= IDLE_TIME => Admission::Evict(key),
        _ => Admission::Refused,
    }
}

#[cfg(test)]
mod tests {
    use uavspec_model::clock::Clock;

    use super::*;

    /// Decides about a newcomer while these seats are taken, and there is no other seat.
    fn admit_to(seats: &[Seat], now: Instant) -> Admission<usize> {
        admit(seats.iter().copied().enumerate(), seats.len(), now)
    }

    /// Three seats, taken one after another.
    fn full(now: Instant) -> [Seat; 3] {
        [0, 1, 2].map(|number| Seat::new(now + Duration::from_millis(number)))
    }

    #[test]
    fn evicts_the_idlest_client_that_never_sent_a_request() {
        let now = Clock::simulated().now();
        let mut seats = full(now);
        assert_eq!(admit_to(&seats, now), Admission::Evict(0));
        seats[0] = Seat::of_active(now);
        assert_eq!(admit_to(&seats, now), Admission::Evict(1));
        assert_eq!(admit(seats.into_iter().enumerate(), 4, now), Admission::Free);
    }

    #[test]
    fn refuses_newcomers_while_all_clients_are_active() {
        let now = Clock::simulated().now();
        let mut seats = full(now);
        for (at, seconds) in [(1, 2), (0, 1), (2, 3)] {
            seats[at] = Seat::of_active(now + Duration::from_secs(seconds));
        }
        assert_eq!(admit_to(&seats, now + IDLE_TIME), Admission::Refused);
        assert_eq!(admit_to(&seats, now + IDLE_TIME + Duration::from_secs(1)), Admission::Evict(0));
    }
}
