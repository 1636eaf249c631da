//! Strategies for property tests with [`proptest`].
//!
//! Every message, enum, set of flags and error code implements [`Arbitrary`](proptest::arbitrary::Arbitrary), so
//! `any::<BatteryStatus>()` works, alone or within other strategies. `any` generates [`valid`] values, which have no
//! violations and can be represented in JSON. Edge cases are frequent: the limits of ranges and types, values that mean
//! "no data", NaN if it is allowed, `-0.0`, subnormal floats and multi-byte characters. Sequences, strings and text are
//! often empty or full.
//!
//! [`invalid`] generates messages that violate one rule in one field, together with the rule and the path of the field.
//! [`undocumented`] generates enum values, flags and error codes that the definition doesn't name.
//!
//! ```
//! # use uavspec_runtime::{Definition, Message, record};
//! # #[derive(Clone, Default, PartialEq)]
//! # struct Wind {
//! #     speed: f32,
//! # }
//! # impl Message for Wind {
//! #     const DEFINITION: Definition = Definition::new("example", "Wind");
//! # }
//! # record! {
//! #     Wind[1];
//! #     0 speed = float32("speed", 0).within(&number().from(int(0)).not_nan());
//! # }
//! use uavspec_runtime::proptest::prelude::*;
//! use uavspec_runtime::strategy::{invalid, valid};
//!
//! proptest!(|(wind in valid::<Wind>())| prop_assert!(wind.validate().is_empty()));
//!
//! let strategy = invalid::<Wind>().expect("the speed has a range");
//! proptest!(|(invalid in strategy)| {
//!     let violations = invalid.value.validate();
//!     let found = (violations[0].rule, violations[0].path.to_string());
//!     prop_assert_eq!(found, (invalid.rule, invalid.path));
//! });
//! ```
//!
//! The strategies are built from proptest's strategies, according to the message descriptor, and proptest simplifies
//! failing cases. Messages therefore need no additional code.

mod message;
mod number;
mod replay;

use core::fmt::Debug;
use std::string::{String, ToString as _};

use proptest::strategy::{BoxedStrategy, Strategy as _, Union};

use self::message::ROOM;
use self::number::Numbers;
use self::replay::Node;
use crate::{Constraint, ConstraintKind, Message, Open};

/// A strategy for messages that have no violations and that JSON can represent.
pub fn valid<T: Message>() -> BoxedStrategy<T> {
    message::valid(T::DESCRIPTOR, ROOM).prop_map(Node::message).boxed()
}

/// A strategy for messages that violate one rule in one field. `None` if no value of the message can violate a rule.
///
/// The messages never exceed sequence or string bounds that are greater than 4096. Simplification may lead to a violation
/// of another rule or in another field.
pub fn invalid<T: Message>() -> Option<BoxedStrategy<InvalidMessage<T>>> {
    let faults = message::faults(T::DESCRIPTOR, ROOM);
    if faults.is_empty() {
        return None;
    }
    Some(Union::new(faults).prop_filter_map("not one violation", InvalidMessage::new).boxed())
}

/// A strategy for the documented values of an enum or error code, or for combinations of the documented flags.
pub fn documented<T: Open + Debug + 'static>() -> BoxedStrategy<T> {
    numbers::<T>().valid().prop_map(T::from_bits).boxed()
}

/// A strategy for values that the definition doesn't name, or for flags with at least one unnamed bit. `None` if all
/// values have names.
pub fn undocumented<T: Open + Debug + 'static>() -> Option<BoxedStrategy<T>> {
    let bits = numbers::<T>().violating(ConstraintKind::Enum)?;
    Some(bits.prop_map(T::from_bits).boxed())
}

/// The numbers of an enum, of flags or of error codes.
fn numbers<T: Open>() -> Numbers {
    let known = Constraint { known: Some(T::KNOWN), names: T::NAMES, ..Constraint::NONE };
    Numbers { scalar: T::SCALAR, constraint: Constraint { is_flags: T::IS_FLAGS, ..known } }
}

/// A message that violates one rule.
#[derive(Clone, Debug, PartialEq)]
pub struct InvalidMessage<T> {
    /// The message.
    pub value: T,
    /// The violated rule.
    pub rule: ConstraintKind,
    /// The path of the invalid field, in the format of [`Violation`](crate::Violation): `events[2].id`.
    pub path: String,
}

impl<T: Message> InvalidMessage<T> {
    /// Reads a message, or returns `None` if it doesn't violate exactly one rule.
    fn new(node: Node) -> Option<Self> {
        let value: T = node.message();
        let violations = value.validate();
        let [violation] = violations.as_slice() else { return None };
        Some(Self { rule: violation.rule, path: violation.path.to_string(), value })
    }
}

/// Implements `Arbitrary` for a message.
#[doc(hidden)]
#[macro_export]
macro_rules! __arbitrary_record {
    ($type:ident) => {
        impl $crate::proptest::arbitrary::Arbitrary for $type {
            type Parameters = ();
            type Strategy = $crate::proptest::strategy::BoxedStrategy<Self>;

            fn arbitrary_with((): ()) -> Self::Strategy {
                $crate::strategy::valid()
            }
        }
    };
}

/// Implements `Arbitrary` for an enum, flags or an error code.
#[doc(hidden)]
#[macro_export]
macro_rules! __arbitrary_number {
    ($type:ident) => {
        impl $crate::proptest::arbitrary::Arbitrary for $type {
            type Parameters = ();
            type Strategy = $crate::proptest::strategy::BoxedStrategy<Self>;

            fn arbitrary_with((): ()) -> Self::Strategy {
                $crate::strategy::documented()
            }
        }
    };
}
