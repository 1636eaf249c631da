//! The search for the simplest value that still fails.

use std::vec::Vec;

use crate::Number;

/// Values in order of simplicity, simplest first. The last value is the drawn value.
pub(super) enum Domain {
    /// The listed values.
    Listed(Vec<Number>),
    /// The integers from `simplest` to `drawn`.
    Integers { simplest: i128, drawn: i128 },
    /// Floats of one sign, in order of magnitude.
    Floats(Floats),
}

/// A search order for floats: the whole numbers between two magnitudes, then all floats from the last whole number to
/// the drawn float.
pub(super) struct Floats {
    /// The magnitude of the simplest float.
    simplest: f64,
    /// The magnitude of the drawn float.
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

    /// The count of whole numbers, and the first whole number. For large floats, which are all whole, the count is 0.
    fn whole(&self) -> (u64, f64) {
        let limit = if self.is_single { 1_u64 << 24 } else { 1 << 53 };
        let first = self.simplest.floor() + 1.0;
        let count = self.drawn.trunc() - first + 1.0;
        // Both values are less than 2^53.
        #[allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        if count >= 1.0 && self.drawn < limit as f64 { (count as u64, first) } else { (0, self.simplest) }
    }

    /// The magnitude from which the search continues with all floats: the last whole number.
    fn base(&self) -> f64 {
        if self.whole().0 == 0 { self.simplest } else { self.drawn.trunc() }
    }

    #[allow(clippy::cast_possible_truncation)] // a 32-bit float already
    fn key(&self, magnitude: f64) -> u64 {
        if self.is_single { (magnitude as f32).to_bits().into() } else { magnitude.to_bits() }
    }

    #[allow(clippy::cast_possible_truncation)] // keys of 32-bit floats have 32 bits
    fn value_of(&self, key: u64) -> f64 {
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
            rank => self.value_of(self.key(self.base()) + (rank - count)),
        };
        // 0 is simpler than -0.
        if self.is_negative && magnitude != 0.0 { -magnitude } else { magnitude }
    }
}

impl Domain {
    /// The rank of the drawn value.
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

/// A binary search by rank, which tries the simplest value first.
pub(super) struct Search {
    domain: Domain,
    /// All ranks below this rank pass, or are assumed to pass.
    low: u64,
    /// A rank that is known to fail.
    high: u64,
    /// The rank that is being tried.
    rank: u64,
}

impl Search {
    pub(super) fn new(domain: Domain) -> Self {
        let top = domain.top();
        Self { domain, low: 0, high: top, rank: top }
    }

    /// The next value to try after the current one failed.
    pub(super) fn simplify(&mut self) -> Option<Number> {
        self.high = self.rank;
        (self.low < self.high).then(|| self.next())?
    }

    /// The next value to try after the current one passed.
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

    /// The result of the search if all values from `limit` upwards fail.
    fn min(domain: Domain, limit: f64) -> Option<Number> {
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
    fn finds_the_smallest_failing_value() {
        let floats = |drawn, is_single| Domain::Floats(Floats::new(0.0, drawn, is_single));
        assert_eq!(min(floats(153.7, true), 100.5), Some(Number::Float(101.0)));
        assert_eq!(min(floats(1e300, false), 0.0), Some(Number::Float(0.0)));
        let between = min(floats(100.75, true), 100.5);
        assert_eq!(between, Some(Number::Float(100.5)));
        let integers = Domain::Integers { simplest: 1, drawn: 1_000_000 };
        assert_eq!(min(integers, 4711.0), Some(Number::Int(4711)));
        let list = Domain::Listed([0, 3, 5, 9].map(Number::Int).to_vec());
        assert_eq!(min(list, 4.0), Some(Number::Int(5)));
    }

    #[test]
    fn tries_the_simplest_negative_value() {
        for (simplest, drawn, is_single) in [(-10.0, -60.5, false), (-0.5, -0.75, true), (0.0, -2.5, true)] {
            let floats = || Domain::Floats(Floats::new(simplest, drawn, is_single));
            assert_eq!(min(floats(), f64::MIN), Some(Number::Float(simplest)));
            let Some(Number::Float(first)) = floats().at(0) else { panic!("no value") };
            assert_eq!(first.is_sign_negative(), simplest < 0.0, "{first}");
        }
    }

    #[test]
    fn finds_nothing_simpler_than_the_simplest_value() {
        assert_eq!(min(Domain::Integers { simplest: -3, drawn: -3 }, -10.0), None);
        assert_eq!(min(Domain::Floats(Floats::new(0.5, 0.5, true)), 0.0), None);
    }
}
