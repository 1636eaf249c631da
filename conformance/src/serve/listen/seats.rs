//! Seats: the places for clients, and the decision which client gives way to a newcomer.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::net::IpAddr;
use std::time::{Duration, Instant};

/// The clients of one kind. Their number is limited, in all and per address. All decisions take logarithmic time, because
/// floods of newcomers cause many of them.
#[derive(Debug)]
pub(super) struct Seats<K> {
    limits: SeatLimits,
    taken: BTreeMap<K, Seat>,
    addresses: HashMap<IpAddr, Clients<K>>,
    /// The addresses of clients that never sent a request. The busiest address comes first.
    unproven: BTreeSet<(Reverse<usize>, Instant, IpAddr)>,
    /// The addresses of clients that have sent requests. The busiest address comes first.
    proven: BTreeSet<(Reverse<usize>, Instant, IpAddr)>,
    /// The addresses of clients that have sent requests. The address of the idlest client comes first.
    idlest: BTreeSet<(Instant, IpAddr)>,
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

/// The clients of an address, with the time at which they were last active. The idlest client comes first.
#[derive(Debug)]
struct Clients<K> {
    unproven: BTreeSet<(Instant, K)>,
    proven: BTreeSet<(Instant, K)>,
}

impl<K> Default for Clients<K> {
    fn default() -> Self {
        Self { unproven: BTreeSet::new(), proven: BTreeSet::new() }
    }
}

impl<K: Ord + Clone> Clients<K> {
    fn count(&self) -> usize {
        self.unproven.len() + self.proven.len()
    }

    fn of(&mut self, has_requested: bool) -> &mut BTreeSet<(Instant, K)> {
        if has_requested { &mut self.proven } else { &mut self.unproven }
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
        Self {
            limits,
            taken: BTreeMap::new(),
            addresses: HashMap::new(),
            unproven: BTreeSet::new(),
            proven: BTreeSet::new(),
            idlest: BTreeSet::new(),
        }
    }

    /// Decides about a newcomer. If there is no free seat, clients that never sent a request give way first, and then
    /// idle clients: in both cases, the idlest client of the busiest address, if it has one. An active client gives way
    /// only if its address has more clients than that of the newcomer, so that no address can lock out others.
    pub(super) fn admit(&self, address: IpAddr, now: Instant) -> Admission<K> {
        let own = self.addresses.get(&address);
        let count = own.map_or(0, Clients::count);
        let is_idle = |since: Instant| now.saturating_duration_since(since) >= self.limits.idle_time;
        if let Some(own) = own
            && count >= self.limits.per_address
        {
            let idle = own.proven.first().filter(|(since, _)| is_idle(*since));
            return evict(own.unproven.first().or(idle));
        }
        if self.taken.len() < self.limits.total {
            return Admission::Free;
        }
        let idlest_of = |address: &IpAddr| self.addresses.get(address).and_then(|own| own.proven.first());
        if let Some((.., busiest)) = self.unproven.first() {
            return evict(self.addresses.get(busiest).and_then(|own| own.unproven.first()));
        }
        let busiest = self.proven.first();
        match (busiest, self.idlest.first()) {
            (Some((_, since, busiest)), _) if is_idle(*since) => evict(idlest_of(busiest)),
            (_, Some((since, idlest))) if is_idle(*since) => evict(idlest_of(idlest)),
            (Some((Reverse(rivals), _, busiest)), _) if *rivals > count + 1 => evict(idlest_of(busiest)),
            _ => Admission::Refused,
        }
    }

    /// Adds a client.
    pub(super) fn insert(&mut self, key: K, address: IpAddr, now: Instant) {
        self.remove(&key);
        self.update(address, |clients| _ = clients.unproven.insert((now, key.clone())));
        self.taken.insert(key, Seat { address, last_active: now, has_requested: false });
    }

    /// Records that a client is active.
    pub(super) fn touch(&mut self, key: &K, has_requested: bool, now: Instant) {
        let Some(seat) = self.taken.get_mut(key) else { return };
        let before = *seat;
        seat.last_active = now;
        seat.has_requested |= has_requested;
        let seat = *seat;
        self.update(seat.address, |clients| {
            clients.of(before.has_requested).remove(&(before.last_active, key.clone()));
            clients.of(seat.has_requested).insert((now, key.clone()));
        });
    }

    /// Removes a client.
    pub(super) fn remove(&mut self, key: &K) {
        let Some(seat) = self.taken.remove(key) else { return };
        self.update(seat.address, |clients| {
            clients.of(seat.has_requested).remove(&(seat.last_active, key.clone()));
        });
    }

    /// The clients that have been inactive for this time.
    pub(super) fn inactive(&self, time: Duration, now: Instant) -> Vec<K> {
        self.taken
            .iter()
            .filter(|(_, seat)| now.saturating_duration_since(seat.last_active) >= time)
            .map(|(key, _)| key.clone())
            .collect()
    }

    /// Changes the clients of an address, and its ranks among all addresses.
    fn update(&mut self, address: IpAddr, change: impl FnOnce(&mut Clients<K>)) {
        let clients = self.addresses.entry(address).or_default();
        let ranks = |clients: &Clients<K>| {
            let oldest = |clients: &BTreeSet<(Instant, K)>| clients.first().map(|(since, _)| *since);
            (Reverse(clients.count()), oldest(&clients.unproven), oldest(&clients.proven))
        };
        let (count, unproven, proven) = ranks(clients);
        if let Some(since) = unproven {
            self.unproven.remove(&(count, since, address));
        }
        if let Some(since) = proven {
            self.proven.remove(&(count, since, address));
            self.idlest.remove(&(since, address));
        }
        change(clients);
        let (count, unproven, proven) = ranks(clients);
        if let Some(since) = unproven {
            self.unproven.insert((count, since, address));
        }
        if let Some(since) = proven {
            self.proven.insert((count, since, address));
            self.idlest.insert((since, address));
        }
        if count == Reverse(0) {
            self.addresses.remove(&address);
        }
    }
}

fn evict<K: Clone>(client: Option<&(Instant, K)>) -> Admission<K> {
    client.map_or(Admission::Refused, |(_, key)| Admission::Evict(key.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::Clock;

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
        let now = Clock::simulated().now();
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
        let now = Clock::simulated().now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1)], now);
        for key in [2, 1, 3] {
            seats.touch(&key, true, now);
        }
        assert_eq!(seats.admit(address(1), now), Admission::Refused);
        assert_eq!(seats.admit(address(1), now + LIMITS.idle_time), Admission::Evict(1));
    }

    #[test]
    fn no_address_locks_out_another() {
        let now = Clock::simulated().now();
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
        let now = Clock::simulated().now();
        let mut seats = seats(&[(1, 1), (2, 1), (3, 1), (4, 2)], now);
        for key in 1..=3 {
            seats.touch(&key, true, now);
        }
        assert_eq!(seats.admit(address(3), now), Admission::Evict(4));
    }

    #[test]
    fn lists_inactive_clients() {
        let now = Clock::simulated().now();
        let mut seats = seats(&[(1, 1), (2, 1)], now);
        let later = now + Duration::from_secs(5);
        seats.touch(&2, false, later);
        assert_eq!(seats.inactive(Duration::from_secs(5), later + Duration::from_millis(1)), [1]);
    }
}
