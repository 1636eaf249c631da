//! Seats: the places for clients, and the decision which client gives way to a newcomer.

use std::cmp::Reverse;
use std::collections::{BTreeMap, HashMap};
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// The clients of one kind. Their number is limited, in all and per address.
#[derive(Debug)]
pub(super) struct Seats<K> {
    limits: SeatLimits,
    taken: BTreeMap<K, Seat>,
    /// The number of clients by address.
    counts: HashMap<IpAddr, usize>,
}

/// The limits of [`Seats`].
#[derive(Clone, Copy, Debug)]
pub(super) struct SeatLimits {
    /// The maximum number of clients.
    pub(super) total: usize,
    /// The maximum number of clients per address.
    pub(super) per_address: usize,
    /// The time without a request after which a client may have to give way.
    pub(super) idle_time: Duration,
}

#[derive(Clone, Copy, Debug)]
struct Seat {
    address: IpAddr,
    last_active: Instant,
    /// True if the client has sent a valid request.
    has_requested: bool,
}

impl Seat {
    /// The time since the client was last active.
    fn idle_time(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.last_active)
    }
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
    pub(super) fn new(limits: SeatLimits) -> Self {
        Self { limits, taken: BTreeMap::new(), counts: HashMap::new() }
    }

    /// Decides about a newcomer. If there is no free seat, clients that never sent a request give way first, and then
    /// idle clients: in both cases, the idlest client of the busiest address. An active client gives way only if its
    /// address has more clients than that of the newcomer, so that no address can lock out others.
    pub(super) fn admit(&self, address: IpAddr, now: Instant) -> Admission<K> {
        let count = self.count(address);
        let is_crowded = count >= self.limits.per_address;
        if !is_crowded && self.taken.len() < self.limits.total {
            return Admission::Free;
        }
        let candidates = self.taken.iter().filter(|(_, seat)| !is_crowded || seat.address == address);
        let candidates = candidates.map(|(key, seat)| {
            let is_active = seat.has_requested && seat.idle_time(now) < self.limits.idle_time;
            ((seat.has_requested, is_active, Reverse(self.count(seat.address)), seat.last_active), key)
        });
        match candidates.min() {
            Some(((_, is_active, Reverse(rivals), _), key)) if !is_active || rivals > count + 1 => {
                Admission::Evict(key.clone())
            }
            _ => Admission::Refused,
        }
    }

    /// Adds a client.
    pub(super) fn insert(&mut self, key: K, address: IpAddr, now: Instant) {
        self.remove(&key);
        self.taken.insert(key, Seat { address, last_active: now, has_requested: false });
        *self.counts.entry(address).or_default() += 1;
    }

    /// Records that a client is active.
    pub(super) fn touch(&mut self, key: &K, has_requested: bool, now: Instant) {
        if let Some(seat) = self.taken.get_mut(key) {
            seat.last_active = now;
            seat.has_requested |= has_requested;
        }
    }

    /// Removes a client.
    pub(super) fn remove(&mut self, key: &K) {
        let Some(seat) = self.taken.remove(key) else { return };
        if let Some(count) = self.counts.get_mut(&seat.address) {
            *count -= 1;
            if *count == 0 {
                self.counts.remove(&seat.address);
            }
        }
    }

    /// The clients that have been inactive for this time.
    pub(super) fn inactive(&self, time: Duration, now: Instant) -> Vec<K> {
        self.taken
            .iter()
            .filter(|(_, seat)| seat.idle_time(now) >= time)
            .map(|(key, _)| key.clone())
            .collect()
    }

    fn count(&self, address: IpAddr) -> usize {
        self.counts.get(&address).copied().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: SeatLimits = SeatLimits { total: 4, per_address: 3, idle_time: Duration::from_secs(10) };

    fn address(number: u8) -> IpAddr {
        [127, 0, 0, number].into()
    }

    fn seats(taken: &[(u32, u8)], now: Instant) -> Seats<u32> {
        let mut seats = Seats::new(LIMITS);
        for (key, from) in taken {
            seats.insert(*key, address(*from), now + Duration::from_millis((*key).into()));
        }
        seats
    }

    #[test]
    fn evicts_the_idlest_client_that_never_sent_a_request() {
        let now = Instant::now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1)], now);
        assert_eq!(seats.admit(address(2), now), Admission::Free);
        assert_eq!(seats.admit(address(1), now), Admission::Evict(1));
        seats.touch(&1, true, now);
        assert_eq!(seats.admit(address(1), now), Admission::Evict(2));
        seats.touch(&2, false, now + Duration::from_secs(1));
        assert_eq!(seats.admit(address(1), now), Admission::Evict(3));
    }

    #[test]
    fn refuses_newcomers_while_all_clients_of_their_address_are_active() {
        let now = Instant::now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1)], now);
        for key in [2, 1, 3] {
            seats.touch(&key, true, now);
        }
        assert_eq!(seats.admit(address(1), now), Admission::Refused);
        assert_eq!(seats.admit(address(1), now + LIMITS.idle_time), Admission::Evict(1));
    }

    #[test]
    fn no_address_locks_out_another() {
        let now = Instant::now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1), (4, 2)], now);
        for key in 1..=4 {
            seats.touch(&key, true, now);
        }
        assert_eq!(seats.admit(address(3), now), Admission::Evict(1), "the busiest address gives way");
        assert_eq!(seats.admit(address(2), now), Admission::Evict(1));
        seats.remove(&1);
        assert_eq!(seats.admit(address(3), now), Admission::Free);
    }

    #[test]
    fn active_clients_stay_if_others_never_sent_a_request() {
        let now = Instant::now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1), (4, 2)], now);
        for key in 1..=3 {
            seats.touch(&key, true, now);
        }
        assert_eq!(seats.admit(address(3), now), Admission::Evict(4));
    }

    #[test]
    fn lists_inactive_clients() {
        let now = Instant::now();
        let mut seats = seats(&[(1, 1), (2, 1)], now);
        let later = now + Duration::from_secs(5);
        seats.touch(&2, false, later);
        assert_eq!(seats.inactive(Duration::from_secs(5), later + Duration::from_millis(1)), [1]);
    }
}
