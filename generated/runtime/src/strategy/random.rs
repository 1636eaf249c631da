//! The random number generator of the strategies.

use proptest::num::u64::ANY;
use proptest::strategy::{Strategy as _, ValueTree as _};
use proptest::test_runner::{Reason, TestRunner};

/// `SplitMix64`, seeded by the runner once per case. A message may need thousands of numbers, and `SplitMix64` is
/// faster than proptest's generator.
pub(super) struct Random(u64);

impl Random {
    pub(super) fn new(runner: &mut TestRunner) -> Result<Self, Reason> {
        Ok(Self(ANY.new_tree(runner)?.current()))
    }

    /// 64 random bits.
    pub(super) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number less than `end`, or 0 if `end` is 0.
    pub(super) fn below(&mut self, end: usize) -> usize {
        let product = u128::from(self.bits()) * end as u128;
        #[allow(clippy::cast_possible_truncation)] // less than `end`
        let index = (product >> 64) as usize;
        index
    }

    /// True with a probability of 1 in `times`.
    pub(super) fn once_in(&mut self, times: usize) -> bool {
        self.below(times) == 0
    }

    /// An integer from `low` to `high`. Both bounds must fit in a signed or unsigned 64-bit integer.
    pub(super) fn between(&mut self, low: i128, high: i128) -> i128 {
        let span = u128::try_from(high - low).unwrap_or_default() + 1;
        let (upper, lower) = (span >> 64, span & u128::from(u64::MAX));
        let bits = u128::from(self.bits());
        // `span * bits / 2^64`, in two parts to avoid overflow.
        low + (upper * bits + ((lower * bits) >> 64)).cast_signed()
    }

    /// One of `items`.
    pub(super) fn pick<'i, T>(&mut self, items: &'i [T]) -> Option<&'i T> {
        items.get(self.below(items.len()))
    }
}
