//! Strategies for numbers. Proptest simplifies to the first item of a selection, and tries the first options of a union.

use core::ops::BitOr as _;
use std::vec::Vec;

use proptest::arbitrary::any;
use proptest::num;
use proptest::num::i128::BinarySearch;
use proptest::prop_oneof;
use proptest::sample::{select, subsequence};
use proptest::strategy::{BoxedStrategy, NewTree, Strategy, ValueTree as _};
use proptest::test_runner::TestRunner;

use crate::{Constraint, ConstraintKind, Number, Scalar};

/// Draws integers like another strategy, and simplifies each by binary search from 0.
#[derive(Debug)]
struct Searched<S>(S);

impl<S: Strategy<Value = i128>> Strategy for Searched<S> {
    type Tree = BinarySearch;
    type Value = i128;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        Ok(BinarySearch::new(self.0.new_tree(runner)?.current()))
    }
}

/// The numbers of a type. A constraint may limit them.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    pub(super) scalar: Scalar,
    pub(super) constraint: Constraint<'static>,
}

impl Numbers {
    /// The bits of numbers that violate no rule and that JSON can represent.
    pub(super) fn valid(self) -> BoxedStrategy<u64> {
        let is_valid = move |number: &Number| self.constraint.violated_by(*number).is_none();
        let numbers = self.allowed().prop_filter("all numbers violate the definition", is_valid);
        numbers.prop_map(move |number| self.bits(number)).boxed()
    }

    /// The bits of numbers that violate `rule`, or `None` if there is no such number.
    pub(super) fn violating(self, rule: ConstraintKind) -> Option<BoxedStrategy<u64>> {
        let violates = move |number: &Number| self.constraint.violated_by(*number) == Some(rule);
        let mut near = if self.scalar.is_float() { self.floats_nearby() } else { self.integers_nearby() };
        near.retain(violates);
        let nearest = *near.first()?;
        let far = Self { constraint: Constraint::NONE, ..self }.allowed();
        let far = far.prop_map(move |number| if violates(&number) { number } else { nearest });
        Some(prop_oneof![select(near), far].prop_map(move |number| self.bits(number)).boxed())
    }

    /// The bits of a number as stored in a field of the type.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the number fits the type
    fn bits(self, number: Number) -> u64 {
        match number {
            Number::Int(value) => value as u64,
            Number::Float(value) if self.scalar == Scalar::Float32 => (value as f32).to_bits().into(),
            Number::Float(value) => value.to_bits(),
        }
    }

    /// Numbers that violate no rule, unless the constraint is unusual: flags within a range, or an empty range.
    fn allowed(self) -> BoxedStrategy<Number> {
        let ordinary = if self.scalar.is_float() { self.floats() } else { self.integers() };
        let special = self.special();
        if special.is_empty() { ordinary } else { prop_oneof![7 => ordinary, 1 => select(special)].boxed() }
    }

    /// The values that mean "no data", if JSON can represent them.
    fn special(self) -> Vec<Number> {
        let is_float = self.scalar.is_float();
        let nan = (is_float && !self.constraint.forbids_nan).then_some(f64::NAN);
        let stated = self.constraint.special.iter().copied();
        let stated = stated.map(|value| if is_float { Number::Float(value.as_f64()) } else { value });
        let representable = stated.filter(|value| match *value {
            Number::Int(value) => self.fits(value),
            Number::Float(value) => is_float && (value.is_nan() || value.abs() <= self.greatest_float()),
        });
        representable.chain(nan.map(Number::Float)).collect()
    }

    fn integers(self) -> BoxedStrategy<Number> {
        let (low, high) = self.integer_range();
        let documented = self.documented();
        let integers = if self.scalar == Scalar::Bool {
            any::<bool>().prop_map(i128::from).boxed()
        } else if self.constraint.is_flags {
            // No flag, one flag and all flags are as likely as any other count.
            let masks = subsequence(documented.clone(), 0..=documented.len());
            masks.prop_map(|masks| masks.into_iter().fold(0, i128::bitor)).boxed()
        } else if documented.is_empty() {
            let in_range = move |value: i128| value.clamp(low, high);
            // All bit lengths are equally likely.
            let lengths = (low..=high, 0..8 * self.scalar.size());
            let lengths = lengths.prop_map(move |(value, shift)| in_range(value >> shift));
            let edges = select([0, low, high, 1, -1, low + 1, high - 1].map(in_range).to_vec());
            let drawn = prop_oneof![4 => lengths, 2 => low..=high, 2 => edges];
            Searched(drawn).prop_map(in_range).boxed()
        } else {
            select(documented).boxed()
        };
        integers.prop_map(Number::Int).boxed()
    }

    /// The masks of the documented flags, or the documented values that are in range, from the simplest.
    fn documented(self) -> Vec<i128> {
        let (low, high) = self.integer_range();
        let mut values = self.constraint.known.unwrap_or_default().to_vec();
        values.retain(|value| self.constraint.is_flags || (low..=high).contains(value));
        values.sort_by_key(|value| (value.unsigned_abs(), *value));
        values.dedup();
        values
    }

    /// True if a field of the type can contain the integer.
    fn fits(self, value: i128) -> bool {
        self.scalar.integer_bounds().is_some_and(|(min, max)| (min..=max).contains(&value))
    }

    /// Minimum and maximum, without special values; for an empty range, the limits of the type.
    #[allow(clippy::cast_possible_truncation)] // saturates, and the type has a smaller range
    fn integer_range(self) -> (i128, i128) {
        let (min, max) = self.scalar.integer_bounds().unwrap_or((0, 1));
        let low = self.constraint.low.map_or(min, |low| match low {
            Number::Int(low) => low,
            Number::Float(low) => low.ceil() as i128,
        });
        let high = self.constraint.high.map_or(max, |high| match high {
            Number::Int(high) => high,
            Number::Float(high) => high.floor() as i128,
        });
        let count = self.constraint.count.map_or(max, i128::from);
        let (low, high) = (low.max(min), high.min(max).min(count));
        if low <= high { (low, high) } else { (min, max) }
    }

    /// Integers next to the allowed values, single flags, and the extremes of the type.
    fn integers_nearby(self) -> Vec<Number> {
        /// The maximum number of documented values whose neighbours are tried.
        const NEIGHBOURS: usize = 32;
        let Some((min, max)) = self.scalar.integer_bounds() else { return Vec::new() };
        let (low, high) = self.integer_range();
        let known = self.constraint.known.unwrap_or_default();
        let flags = (0..64).map(|bit| 1 << bit).filter(|_| self.constraint.is_flags);
        let ends = [known.iter().max(), known.iter().min()].into_iter().flatten();
        let allowed = [high, low].into_iter().chain(known.iter().take(NEIGHBOURS).chain(ends).copied());
        let neighbours = allowed.flat_map(|value| [value + 1, value - 1]);
        let integers = flags.chain(neighbours).chain([max, min]).filter(|value| self.fits(*value));
        integers.map(Number::Int).collect()
    }

    fn floats(self) -> BoxedStrategy<Number> {
        let (low, high) = self.float_range();
        // Numbers with one decimal digit, as people write them.
        let decimals = (-1_000..=1_000).prop_map(|tenths| f64::from(tenths) / 10.0);
        let edges = select(std::vec![0.0, low, high, 1.0, -1.0]);
        // All exponents are equally likely.
        let exponents = if self.scalar == Scalar::Float32 {
            use num::f32::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
            (POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO).prop_map(f64::from).boxed()
        } else {
            use num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
            (POSITIVE | NEGATIVE | NORMAL | SUBNORMAL | ZERO).boxed()
        };
        let floats = prop_oneof![1 => decimals, 4 => low..=high, 1 => edges, 2 => exponents];
        floats.prop_map(move |value| Number::Float(self.round(value.clamp(low, high)))).boxed()
    }

    /// The nearest float of the type.
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    fn round(self, value: f64) -> f64 {
        if self.scalar == Scalar::Float32 { (value as f32).into() } else { value }
    }

    fn greatest_float(self) -> f64 {
        if self.scalar == Scalar::Float32 { f32::MAX.into() } else { f64::MAX }
    }

    /// Minimum and maximum, without special values; for an empty range, the limits of the type.
    fn float_range(self) -> (f64, f64) {
        let max = self.greatest_float();
        let low = self.constraint.low.map_or(-max, Number::as_f64).max(-max);
        let high = self.constraint.high.map_or(max, Number::as_f64).min(max);
        let high = high.min(self.constraint.count.map_or(max, f64::from));
        let (up, down) = (self.round(low), self.round(high));
        let low = if up < low { self.neighbours(low)[0] } else { up };
        let high = if down > high { self.neighbours(high)[1] } else { down };
        if low <= high { (low, high) } else { (-max, max) }
    }

    /// The next greater and the next smaller float, starting from the float of the type that is nearest to `value`.
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    fn neighbours(self, value: f64) -> [f64; 2] {
        if self.scalar == Scalar::Float32 {
            let value = value as f32;
            [value.next_up().into(), value.next_down().into()]
        } else {
            [value.next_up(), value.next_down()]
        }
    }

    /// NaN, and the finite floats next to the allowed floats.
    fn floats_nearby(self) -> Vec<Number> {
        let (low, high) = self.float_range();
        let neighbours = [self.neighbours(high)[0], self.neighbours(low)[1]];
        let finite = neighbours.into_iter().filter(|value| value.is_finite());
        finite.chain([f64::NAN]).map(Number::Float).collect()
    }
}
