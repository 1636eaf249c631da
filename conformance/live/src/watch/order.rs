//! The order of UAVs on the screen.

use std::cmp::{Ordering, Reverse};

use super::fleet::Uav;

/// A sort order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By id, in natural order: glider-2 before glider-10.
    #[default]
    Id,
    /// Most severe error codes first.
    Severity,
    /// Lowest charge first.
    Battery,
}

impl Order {
    /// The name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Id => "id",
            Self::Severity => "severity",
            Self::Battery => "battery",
        }
    }

    /// The next order. The first order follows the last one.
    #[must_use]
    pub(crate) fn next(self) -> Self {
        match self {
            Self::Id => Self::Severity,
            Self::Severity => Self::Battery,
            Self::Battery => Self::Id,
        }
    }

    /// Compares two UAVs with their ids.
    pub(super) fn compare(self, one: (&str, &Uav), other: (&str, &Uav)) -> Ordering {
        let by_id = || natural(one.0, other.0);
        match self {
            Self::Id => by_id(),
            Self::Severity => Reverse(one.1.worst()).cmp(&Reverse(other.1.worst())).then_with(by_id),
            Self::Battery => charge(one.1).cmp(&charge(other.1)).then_with(by_id),
        }
    }
}

/// The sort key for the charge. UAVs with an unknown charge come last.
fn charge(uav: &Uav) -> (bool, i64) {
    let percent = uav
        .state
        .as_ref()
        .and_then(|state| state.battery.known())
        .and_then(|battery| battery.percent.known());
    percent.map_or((true, 0), |percent| (false, *percent))
}

/// Compares two texts; numbers within them are compared by value.
fn natural(one: &str, other: &str) -> Ordering {
    let (mut left, mut right) = (one.as_bytes(), other.as_bytes());
    while let (Some(first), Some(second)) = (left.first(), right.first()) {
        let is_number = first.is_ascii_digit() && second.is_ascii_digit();
        let order = if is_number {
            let (left_number, right_number) = (digits(&mut left), digits(&mut right));
            left_number.len().cmp(&right_number.len()).then_with(|| left_number.cmp(right_number))
        } else {
            let order = first.cmp(second);
            (left, right) = (&left[1..], &right[1..]);
            order
        };
        if order.is_ne() {
            return order;
        }
    }
    // The order is defined even for ids that differ only in leading zeros.
    left.len().cmp(&right.len()).then_with(|| one.cmp(other))
}

/// Removes the number at the start of a text, and returns it without leading zeros.
fn digits<'t>(text: &mut &'t [u8]) -> &'t [u8] {
    let length = text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let (number, rest) = text.split_at(length);
    *text = rest;
    let zeros = number.iter().take_while(|digit| **digit == b'0').count();
    &number[zeros..]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn compares_numbers_by_value() {
        let mut ids = ["glider-10", "glider-2", "glider-02", "glider", "a", "glider-2b", "7", "07", "80", ""];
        ids.sort_by(|one, other| natural(one, other));
        assert_eq!(
            ids,
            ["", "07", "7", "80", "a", "glider", "glider-02", "glider-2", "glider-2b", "glider-10"]
        );
    }

    proptest! {
        #[test]
        fn is_a_total_order(ids in proptest::collection::vec("[a0-2é]{0,4}", 3)) {
            let [one, two, three] = &ids[..] else { return Ok(()) };
            prop_assert_eq!(natural(one, two), natural(two, one).reverse());
            prop_assert_eq!(natural(one, two).is_eq(), one == two);
            if natural(one, two).is_le() && natural(two, three).is_le() {
                prop_assert!(natural(one, three).is_le());
            }
        }
    }
}
