//! The order in which connections are visited.

use std::collections::BTreeMap;
use std::time::Duration;

use mio::Token;

/// A connection may cause a cost of one in this number of the elapsed time without falling behind others. Clients that send
/// a request now and then thus don't wait for clients that send many.
const FREE_PART: u32 = 200;

/// The maximum cost that counts against a connection. It limits the time for which others come first.
const MOST_COST: Duration = Duration::from_millis(50);

/// The additional cost that counts against a connection that didn't finish its work in its last turn. A new request thus
/// comes before the work of others, unless that has been waiting for [`FREE_PART`] times this time.
const HANDICAP: Duration = Duration::from_millis(5);

/// The connections that have something to do. The connection that recently caused the least cost comes first. Connections
/// that caused the same cost take turns.
#[derive(Debug, Default)]
pub(super) struct Schedule {
    entries: BTreeMap<Token, Entry>,
    /// The connections to visit, by cost and by the order in which they became ready.
    ready: BTreeMap<(Duration, u64), Token>,
    /// The number of times that connections became ready.
    turns: u64,
}

#[derive(Debug, Default)]
struct Entry {
    /// The cost of the work so far. It is at least the free part of the elapsed time, so earlier work is forgotten.
    cost: Duration,
    /// The position in [`Schedule::ready`].
    position: Option<(Duration, u64)>,
}

impl Schedule {
    /// Adds a connection, which is ready.
    pub(super) fn insert(&mut self, token: Token, elapsed: Duration) {
        self.entries.insert(token, Entry::default());
        self.wake(token, elapsed);
    }

    /// Makes a connection ready. A connection that is ready already keeps its position.
    pub(super) fn wake(&mut self, token: Token, elapsed: Duration) {
        self.queue(token, elapsed, Duration::ZERO);
    }

    /// Makes a connection ready that didn't finish its work in its turn.
    pub(super) fn resume(&mut self, token: Token, elapsed: Duration) {
        self.queue(token, elapsed, HANDICAP);
    }

    fn queue(&mut self, token: Token, elapsed: Duration, handicap: Duration) {
        let Some(entry) = self.entries.get_mut(&token) else { return };
        if entry.position.is_some() {
            return;
        }
        let free = elapsed / FREE_PART;
        entry.cost = entry.cost.clamp(free, free + MOST_COST);
        let position = (entry.cost + handicap, self.turns);
        entry.position = Some(position);
        self.turns += 1;
        self.ready.insert(position, token);
    }

    /// Takes the connection that comes first.
    pub(super) fn next(&mut self) -> Option<Token> {
        let (_, token) = self.ready.pop_first()?;
        if let Some(entry) = self.entries.get_mut(&token) {
            entry.position = None;
        }
        Some(token)
    }

    /// Records the cost of work for a connection.
    pub(super) fn charge(&mut self, token: Token, cost: Duration) {
        if let Some(entry) = self.entries.get_mut(&token) {
            entry.cost += cost;
        }
    }

    pub(super) fn remove(&mut self, token: Token) {
        if let Some(Entry { position: Some(position), .. }) = self.entries.remove(&token) {
            self.ready.remove(&position);
        }
    }

    /// True if no connection is ready.
    pub(super) fn is_empty(&self) -> bool {
        self.ready.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLICE: Duration = Duration::from_micros(100);

    /// A schedule with connections that have been ready since the start.
    struct Busy {
        schedule: Schedule,
        elapsed: Duration,
    }

    impl Busy {
        fn new(count: usize) -> Self {
            let mut schedule = Schedule::default();
            for token in 0..count {
                schedule.insert(Token(token), Duration::ZERO);
            }
            Self { schedule, elapsed: Duration::ZERO }
        }

        fn visit_next(&mut self) -> Token {
            let token = self.schedule.next().expect("a connection");
            self.schedule.charge(token, SLICE);
            self.elapsed += SLICE;
            token
        }

        /// Visits this many connections, all of which stay ready.
        fn visit(&mut self, count: usize) -> Vec<usize> {
            let mut visit = || {
                let token = self.visit_next();
                self.schedule.resume(token, self.elapsed);
                token.0
            };
            (0..count).map(|_| visit()).collect()
        }
    }

    #[test]
    fn equal_connections_take_turns() {
        assert_eq!(Busy::new(3).visit(7), [0, 1, 2, 0, 1, 2, 0]);
    }

    #[test]
    fn a_quiet_connection_comes_before_active_connections() {
        let mut busy = Busy::new(5000);
        let quiet = busy.visit_next();
        busy.visit(20_000);
        for _ in 0..100 {
            busy.schedule.wake(quiet, busy.elapsed);
            assert_eq!(busy.visit_next(), quiet);
            busy.visit(500);
        }
    }

    #[test]
    fn a_newcomer_comes_before_active_connections() {
        let mut busy = Busy::new(5000);
        busy.visit(20_000);
        busy.schedule.insert(Token(5000), busy.elapsed);
        assert_eq!(busy.visit_next(), Token(5000));
    }

    #[test]
    fn earlier_work_is_forgotten() {
        let mut busy = Busy::new(1);
        busy.visit(1_000_000);
        busy.schedule.insert(Token(1), busy.elapsed);
        let visited = busy.visit(2000);
        let most = usize::try_from(MOST_COST.as_micros() / SLICE.as_micros()).expect("a number");
        assert!(visited[most + 20..].contains(&0), "the newcomer doesn't stay first forever");
    }

    #[test]
    fn no_connection_waits_forever_behind_newcomers() {
        let mut busy = Busy::new(1);
        busy.visit(1000);
        for newcomer in 1.. {
            assert!(newcomer < 1_000_000, "a connection waits forever");
            busy.schedule.insert(Token(newcomer), busy.elapsed);
            if busy.visit_next() == Token(0) {
                break;
            }
        }
    }

    #[test]
    fn waking_a_ready_connection_keeps_its_position() {
        let mut busy = Busy::new(3);
        busy.schedule.wake(Token(0), Duration::ZERO);
        assert_eq!(busy.visit(3), [0, 1, 2]);
    }

    #[test]
    fn a_removed_connection_is_never_visited() {
        let mut busy = Busy::new(3);
        busy.schedule.remove(Token(1));
        busy.schedule.wake(Token(1), Duration::ZERO);
        assert_eq!(busy.visit(3), [0, 2, 0]);
    }
}
