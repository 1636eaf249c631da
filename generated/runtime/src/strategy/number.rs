//! Draws and simplifies numbers and characters.

use std::boxed::Box;
use std::vec;
use std::vec::Vec;

use super::fault;
use super::random::Random;
use super::search::{Domain, Floats, Search};
use crate::{Constraint, ConstraintKind, Number, Scalar};

/// A number, or a character as its code point.
pub(super) struct Leaf {
    kind: Kind,
    value: Number,
    /// The state of the search for a simpler value, once it has started.
    progress: Option<Box<Progress>>,
}

#[derive(Clone, Copy)]
enum Kind {
    Number(Scalar, &'static Constraint<'static>),
    Character,
}

enum Progress {
    Search(Search),
    /// Removes one flag at a time.
    Flags {
        /// Index of the next mask to try.
        next: usize,
        /// The value before the last flag was removed.
        before: Option<i128>,
    },
}

impl Leaf {
    /// Draws a number that violates no rule, or `None` if there is no such number.
    pub(super) fn valid(
        scalar: Scalar,
        constraint: &'static Constraint<'static>,
        random: &mut Random,
    ) -> Option<Self> {
        let value = Allowed { scalar, constraint }.draw(random)?;
        Some(Self { kind: Kind::Number(scalar, constraint), value, progress: None })
    }

    /// Draws a number that violates `rule`, or `None` if there is no such number.
    pub(super) fn invalid(
        scalar: Scalar,
        constraint: &'static Constraint<'static>,
        rule: ConstraintKind,
        random: &mut Random,
    ) -> Option<Self> {
        let mut values = fault::values(scalar, constraint, rule);
        if random.once_in(2) {
            // Adds a random number that violates the rule, if the draw finds such a number.
            let any_number = Allowed { scalar, constraint: &Constraint::NONE };
            let far = any_number.draw(random).filter(|value| constraint.violated_by(*value) == Some(rule));
            values.extend(far);
        } else {
            values.truncate(random.below(values.len()) + 1);
        }
        let value = *values.last()?;
        let progress = Some(Box::new(Progress::Search(Search::new(Domain::Listed(values)))));
        Some(Self { kind: Kind::Number(scalar, constraint), value, progress })
    }

    /// A leaf for a character.
    pub(super) fn character(character: char) -> Self {
        Self { kind: Kind::Character, value: Number::Int(u32::from(character).into()), progress: None }
    }

    /// The bits of the value as stored in a field of its type.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the value fits the type of the field
    pub(super) fn bits(&self) -> u64 {
        match (self.value, self.kind) {
            (Number::Int(value), _) => value as u64,
            (Number::Float(value), Kind::Number(Scalar::Float32, _)) => (value as f32).to_bits().into(),
            (Number::Float(value), _) => value.to_bits(),
        }
    }

    /// The value as a character.
    pub(super) fn as_char(&self) -> char {
        u32::try_from(self.bits()).ok().and_then(char::from_u32).unwrap_or_default()
    }

    pub(super) fn simplify(&mut self) -> bool {
        let (kind, value) = (self.kind, self.value);
        let progress = self.progress.get_or_insert_with(|| Box::new(start(kind, value)));
        let next = match (progress.as_mut(), kind, value) {
            (Progress::Search(search), ..) => {
                let next = search.simplify();
                next_valid(kind, value, next, search)
            }
            (Progress::Flags { next, before }, Kind::Number(_, constraint), Number::Int(value)) => {
                let reduced = remove_flag(constraint, value, next);
                *before = reduced.map(|_| value);
                reduced.map(Number::Int)
            }
            (Progress::Flags { .. }, ..) => None,
        };
        self.set(next)
    }

    pub(super) fn complicate(&mut self) -> bool {
        let next = match self.progress.as_deref_mut() {
            Some(Progress::Search(search)) => {
                let next = search.complicate();
                next_valid(self.kind, self.value, next, search)
            }
            Some(Progress::Flags { before, .. }) => before.take().map(Number::Int),
            None => None,
        };
        self.set(next)
    }

    fn set(&mut self, value: Option<Number>) -> bool {
        self.value = value.unwrap_or(self.value);
        value.is_some()
    }
}

/// Skips the invalid values in the search if `value` is valid.
fn next_valid(kind: Kind, value: Number, mut next: Option<Number>, search: &mut Search) -> Option<Number> {
    let Kind::Number(_, constraint) = kind else { return next };
    if constraint.violated_by(value).is_none() {
        while next.is_some_and(|next| constraint.violated_by(next).is_some()) {
            next = search.complicate();
        }
    }
    next
}

/// The value without the next flag that can be removed.
fn remove_flag(constraint: &Constraint<'_>, value: i128, next: &mut usize) -> Option<i128> {
    let known = constraint.known.unwrap_or_default();
    while let Some(mask) = known.get(*next) {
        *next += 1;
        let without = value & !mask;
        if without != value && constraint.violated_by(Number::Int(without)).is_none() {
            return Some(without);
        }
    }
    None
}

fn start(kind: Kind, drawn: Number) -> Progress {
    let Kind::Number(scalar, constraint) = kind else {
        let simplest = Number::Int(u32::from('a').into());
        let values = if drawn == simplest { vec![drawn] } else { vec![simplest, drawn] };
        return Progress::Search(Search::new(Domain::Listed(values)));
    };
    let allowed = Allowed { scalar, constraint };
    let is_flags = constraint.is_flags && constraint.known.is_some();
    match drawn {
        Number::Int(_) if is_flags => Progress::Flags { next: 0, before: None },
        Number::Int(drawn) => Progress::Search(Search::new(allowed.integers_to(drawn))),
        Number::Float(drawn) => Progress::Search(Search::new(allowed.floats_to(drawn))),
    }
}

/// The numbers of a type that violate no rule.
#[derive(Clone, Copy)]
pub(super) struct Allowed<'k> {
    pub(super) scalar: Scalar,
    pub(super) constraint: &'k Constraint<'k>,
}

impl Allowed<'_> {
    fn draw(self, random: &mut Random) -> Option<Number> {
        /// Maximum number of attempts. Every draw is within the bounds of the constraint, but not every draw is valid.
        const DRAWS: usize = 64;
        let is_valid = |drawn: &Number| self.constraint.violated_by(*drawn).is_none();
        (0..DRAWS).find_map(|_| self.draw_once(random).filter(is_valid))
    }

    fn draw_once(self, random: &mut Random) -> Option<Number> {
        if random.once_in(8)
            && let Some(special) = self.special(random)
        {
            return Some(special);
        }
        let drawn = if self.scalar.is_float() {
            self.float(random).map(Number::Float)
        } else {
            self.integer(random).map(Number::Int)
        };
        drawn.or_else(|| self.special(random))
    }

    /// A value that means "no data", if JSON can represent it.
    fn special(self, random: &mut Random) -> Option<Number> {
        let nan = (!self.constraint.forbids_nan && self.scalar.is_float()).then_some(Number::Float(f64::NAN));
        let values: Vec<Number> = self
            .constraint
            .special
            .iter()
            .filter_map(|value| self.representable(*value))
            .chain(nan)
            .collect();
        random.pick(&values).copied()
    }

    /// The value as stored in a field of the type, or `None` if the value doesn't fit.
    fn representable(self, value: Number) -> Option<Number> {
        if !self.scalar.is_float() {
            return matches!(value, Number::Int(value) if fault::fits(self.scalar, value)).then_some(value);
        }
        let value = value.as_f64();
        let max = if self.scalar == Scalar::Float32 { f32::MAX.into() } else { f64::MAX };
        (value.is_nan() || value.abs() <= max).then_some(Number::Float(value))
    }

    /// Minimum and maximum, without special values, or `None` if the range is empty.
    pub(super) fn integers(self) -> Option<(i128, i128)> {
        let (min, max) = if self.scalar == Scalar::Bool { (0, 1) } else { self.scalar.integer_bounds()? };
        #[allow(clippy::cast_possible_truncation)] // saturates, and the type has a smaller range
        let low = self.constraint.low.map_or(min, |low| match low {
            Number::Int(low) => low,
            Number::Float(low) => low.ceil() as i128,
        });
        #[allow(clippy::cast_possible_truncation)]
        let high = self.constraint.high.map_or(max, |high| match high {
            Number::Int(high) => high,
            Number::Float(high) => high.floor() as i128,
        });
        let count = self.constraint.count.map_or(max, i128::from);
        let (low, high) = (low.max(min), high.min(max).min(count));
        (low <= high).then_some((low, high))
    }

    fn integer(self, random: &mut Random) -> Option<i128> {
        let (low, high) = self.integers()?;
        let Some(known) = self.constraint.known else { return Some(plain_integer(low, high, random)) };
        if self.constraint.is_flags {
            return self.flags(known, (low, high), random);
        }
        let allowed = || known.iter().filter(|value| (low..=high).contains(*value));
        allowed().nth(random.below(allowed().count())).copied()
    }

    /// Draws no flag, one flag, all flags, or any combination.
    fn flags(self, known: &[i128], (low, high): (i128, i128), random: &mut Random) -> Option<i128> {
        let all = known.iter().fold(0, |all, mask| all | mask);
        let (min, max) = self.scalar.integer_bounds()?;
        let drawn = (0..16).map(|_| match random.below(8) {
            0 => 0,
            1 => all,
            2 | 3 => random.pick(known).copied().unwrap_or_default(),
            _ => random.between(min, max) & all,
        });
        let mut candidates = drawn.chain([0, all]).chain(known.iter().copied());
        candidates.find(|value| (low..=high).contains(value))
    }

    /// Minimum and maximum, without special values, or `None` if the range is empty.
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    pub(super) fn floats(self) -> Option<(f64, f64)> {
        let number = |number: Option<Number>| number.map(Number::as_f64);
        let count = self.constraint.count.map(f64::from);
        let low = number(self.constraint.low).unwrap_or(f64::MIN);
        let high = number(self.constraint.high).unwrap_or(f64::MAX).min(count.unwrap_or(f64::MAX));
        let (low, high) = if self.scalar == Scalar::Float32 {
            let (up, down) = (low as f32, high as f32);
            let up = if f64::from(up) < low { up.next_up() } else { up };
            let down = if f64::from(down) > high { down.next_down() } else { down };
            (up.max(f32::MIN).into(), down.min(f32::MAX).into())
        } else {
            (low.max(f64::MIN), high.min(f64::MAX))
        };
        (low <= high).then_some((low, high))
    }

    fn float(self, random: &mut Random) -> Option<f64> {
        let (low, high) = self.floats()?;
        let drawn = match random.below(8) {
            0 | 1 => self.remarkable_float(low, high, random),
            // All exponents are equally likely.
            2 | 3 => self.round(f64::from_bits(random.bits()), random),
            // Numbers with one decimal digit, as people write them.
            #[allow(clippy::cast_precision_loss)] // small numbers
            4 => self.round((random.below(20_001) as f64 - 10_000.0) / 10.0, random),
            _ => self.uniform(low, high, random),
        };
        // These draws almost never hit a narrow range, so the fallback is a number within the range.
        let is_allowed = |value: &f64| *value >= low && *value <= high;
        Some(drawn).filter(is_allowed).or_else(|| Some(self.uniform(low, high, random).clamp(low, high)))
    }

    fn remarkable_float(self, low: f64, high: f64, random: &mut Random) -> f64 {
        let is_single = self.scalar == Scalar::Float32;
        let min = if is_single { f64::from(f32::from_bits(1)) } else { f64::from_bits(1) };
        let least_normal = if is_single { f32::MIN_POSITIVE.into() } else { f64::MIN_POSITIVE };
        let below_normal =
            if is_single { f32::MIN_POSITIVE.next_down().into() } else { f64::MIN_POSITIVE.next_down() };
        let values = [
            low,
            high,
            0.0,
            -0.0,
            1.0,
            -1.0,
            min,
            -min,
            least_normal,
            -least_normal,
            below_normal,
            -below_normal,
        ];
        random.pick(&values).copied().unwrap_or(low)
    }

    fn uniform(self, low: f64, high: f64, random: &mut Random) -> f64 {
        #[allow(clippy::cast_precision_loss)] // 53 bits are exact
        let share = (random.bits() >> 11) as f64 / (1_u64 << 53) as f64;
        // `high - low` could overflow to infinity; the two products can't.
        self.round(low * (1.0 - share) + high * share, random)
    }

    /// Rounds the value to the type of the field. If the result is infinite or underflows to zero, draws another value.
    #[allow(clippy::cast_possible_truncation)] // rounding is intended
    fn round(self, value: f64, random: &mut Random) -> f64 {
        if self.scalar != Scalar::Float32 {
            return value;
        }
        let single = value as f32;
        let is_beyond = !single.is_finite() || single == 0.0 && value != 0.0;
        if is_beyond { f32::from_bits((random.bits() >> 32) as u32).into() } else { single.into() }
    }

    /// The integers from the simplest value to `drawn`.
    fn integers_to(self, drawn: i128) -> Domain {
        let range = self.integers();
        let Some(known) = self.constraint.known else {
            return match range {
                Some((low, high)) if (low..=high).contains(&drawn) => {
                    Domain::Integers { simplest: 0.clamp(low, high), drawn }
                }
                Some((low, high)) => Domain::Listed([0.clamp(low, high), drawn].map(Number::Int).to_vec()),
                None => Domain::Listed(vec![Number::Int(drawn)]),
            };
        };
        let in_range = |value: &i128| range.is_some_and(|(low, high)| (low..=high).contains(value));
        let mut values: Vec<i128> = known.iter().copied().filter(in_range).collect();
        values.sort_by_key(|value| (value.unsigned_abs(), *value));
        values.dedup();
        values.truncate(values.iter().position(|value| *value == drawn).unwrap_or(values.len()));
        Domain::Listed(values.into_iter().chain([drawn]).map(Number::Int).collect())
    }

    /// The floats from the simplest value to `drawn`.
    fn floats_to(self, drawn: f64) -> Domain {
        let Some((low, high)) = self.floats() else { return Domain::Listed(vec![Number::Float(drawn)]) };
        let simplest = 0_f64.clamp(low, high);
        if drawn == 0.0 && drawn.is_sign_positive() {
            return Domain::Listed(vec![Number::Float(drawn)]);
        }
        if drawn == 0.0 || !(low..=high).contains(&drawn) {
            return Domain::Listed([simplest, drawn].map(Number::Float).to_vec());
        }
        Domain::Floats(Floats::new(simplest, drawn, self.scalar == Scalar::Float32))
    }
}

fn plain_integer(low: i128, high: i128, random: &mut Random) -> i128 {
    let drawn = match random.below(8) {
        0 => low,
        1 => high,
        2 => random.pick(&[0, 1, -1, low + 1, high - 1]).copied().unwrap_or(low),
        // All bit lengths are equally likely.
        3 | 4 => {
            let magnitude = i128::from(random.bits() >> random.below(64));
            if random.once_in(2) { magnitude } else { -magnitude }
        }
        _ => return random.between(low, high),
    };
    if (low..=high).contains(&drawn) { drawn } else { random.between(low, high) }
}
