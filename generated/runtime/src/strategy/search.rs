//! The search for the simplest value that still fails.

use std::vec::Vec;

use crate::Number;

/// Values in the order of their simplicity; the last is the one that was drawn.
pub(super) enum Domain {
    /// These.
    Listed(Vec<Number>),
    /// The integers from one to the other.
    Integers { simplest: i128, drawn: i128 },
    /// Floats of one sign from one to another of greater magnitude.
    Floats(Floats),
}

/// First the whole numbers on the way, then, from the last of them, all floats up to the one that was drawn.
pub(super) struct Floats {
    /// Magnitudes.
    simplest: f64,
    drawn: f64,
    is_negative: bool,
    is_single: bool,
}

impl Floats {
    pub(super) fn new(simplest: f64, drawn: f64, is_single: bool) -> Self {
        Self {
            simplest: simplest.abs(),
            drawn: drawn.abs(),
            is_negative: drawn.is_sign_negative(),
            is_single,
        }
    }

    /// How many whole numbers there are, and the first. Large floats are all whole: none is counted then.
    fn whole(&self) -> (u64, f64) {
        let limit = if self.is_single { 1_u64 << 24 } else { 1 << 53 };
        let first = self.simplest.floor() + 1.0;
        let count = self.drawn.trunc() - first + 1.0;
        // In either case less than 2^53.
        #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        if count >= 1.0 && self.drawn < limit as f64 { (count as u64, first) } else { (0, self.simplest) }
    }

    /// The magnitude that all floats follow: the last of the whole ones.
    fn base(&self) -> f64 {
        if self.whole().0 == 0 { self.simplest } else { self.drawn.trunc() }
    }

    #[allow(clippy::cast_possible_truncation)] // a float of 32 bits already
    fn key(&self, magnitude: f64) -> u64 {
        if self.is_single { (magnitude as f32).to_bits().into() } else { magnitude.to_bits() }
    }

    #[allow(clippy::cast_possible_truncation)] // keys of floats of 32 bits have no more
    fn of_key(&self, key: u64) -> f64 {
        if self.is_single { f32::from_bits(key as u32).into() } else { f64::from_bits(key) }
    }

    fn top(&self) -> u64 {
        self.whole().0 + self.key(self.drawn).saturating_sub(self.key(self.base()))
    }

    fn at(&self, rank: u64) -> f64 {
        let (count, first) = self.whole();
        #[allow(clippy::cast_precision_loss)] // less than 2^53
        let magnitude = match rank {
            0 => self.simplest,
            rank if rank <= count => first + (rank - 1) as f64,
            rank => self.of_key(self.key(self.base()) + (rank - count)),
        };
        if self.is_negative && rank > 0 { -magnitude } else { magnitude }
    }
}

impl Domain {
    /// The rank of the value that was drawn.
    fn top(&self) -> u64 {
        match self {
            Self::Listed(values) => values.len().saturating_sub(1) as u64,
            Self::Integers { simplest, drawn } => {
                u64::try_from(drawn.abs_diff(*simplest)).unwrap_or(u64::MAX)
            }
            Self::Floats(floats) => floats.top(),
        }
    }

    fn at(&self, rank: u64) -> Option<Number> {
        match self {
            Self::Listed(values) => usize::try_from(rank).ok().and_then(|rank| values.get(rank)).copied(),
            Self::Integers { simplest, drawn } => {
                let distance = i128::from(rank);
                Some(Number::Int(if drawn < simplest { simplest - distance } else { simplest + distance }))
            }
            Self::Floats(floats) => Some(Number::Float(floats.at(rank))),
        }
    }
}

/// A binary search by rank that starts with the simplest value of all.
pub(super) struct Search {
    domain: Domain,
    /// All below are known, or taken, to pass.
    low: u64,
    /// Known to fail.
    high: u64,
    /// What is being tried.
    rank: u64,
}

impl Search {
    pub(super) fn new(domain: Domain) -> Self {
        let top = domain.top();
        Self { domain, low: 0, high: top, rank: top }
    }

    /// The next value to try, now that the one being tried is known to fail.
    pub(super) fn simplify(&mut self) -> Option<Number> {
        self.high = self.rank;
        (self.low < self.high).then(|| self.next())?
    }

    /// The next value to try, now that the one being tried is known to pass.
    pub(super) fn complicate(&mut self) -> Option<Number> {
        if self.rank == self.high {
            return None;
        }
        self.low = self.rank + 1;
        self.next()
    }

    fn next(&mut self) -> Option<Number> {
        self.rank = if self.low == 0 { 0 } else { self.low + (self.high - self.low) / 2 };
        self.domain.at(self.rank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the search ends with where everything from `limit` on fails.
    fn least(domain: Domain, limit: f64) -> Option<Number> {
        let fails = |value: Number| match value {
            #[allow(clippy::cast_precision_loss)] // small numbers
            Number::Int(value) => value as f64 >= limit,
            Number::Float(value) => value >= limit,
        };
        let mut search = Search::new(domain);
        let mut found = None;
        let mut candidate = search.simplify();
        while let Some(value) = candidate {
            candidate = if fails(value) {
                found = Some(value);
                search.simplify()
            } else {
                search.complicate()
            };
        }
        found
    }

    #[test]
    fn the_least_failing_value_is_found() {
        let floats = |drawn, is_single| Domain::Floats(Floats::new(0.0, drawn, is_single));
        assert_eq!(least(floats(153.7, true), 100.5), Some(Number::Float(101.0)));
        assert_eq!(least(floats(1e300, false), 0.0), Some(Number::Float(0.0)));
        let between = least(floats(100.75, true), 100.5);
        assert_eq!(between, Some(Number::Float(100.5)));
        let integers = Domain::Integers { simplest: 1, drawn: 1_000_000 };
        assert_eq!(least(integers, 4711.0), Some(Number::Int(4711)));
        let list = Domain::Listed([0, 3, 5, 9].map(Number::Int).to_vec());
        assert_eq!(least(list, 4.0), Some(Number::Int(5)));
    }

    #[test]
    fn what_is_simplest_already_stays() {
        assert_eq!(least(Domain::Integers { simplest: -3, drawn: -3 }, -10.0), None);
        assert_eq!(least(Domain::Floats(Floats::new(0.5, 0.5, true)), 0.0), None);
    }
}
