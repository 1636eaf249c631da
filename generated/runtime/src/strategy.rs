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
//! The strategies draw a list of numbers according to the message descriptor, then decode this list into a message,
//! like a payload. Messages therefore need no additional code, and a case with three hundred numbers takes about ten
//! microseconds.
//!
//! A failing case is simplified one number at a time. Numbers move towards zero, or towards the number closest to zero
//! in their range. Documented values move towards the smallest one. Sequence elements and text characters are removed.

mod draw;
mod fault;
mod number;
mod random;
mod replay;
mod search;
mod tree;

use core::fmt::{self, Debug};
use core::marker::PhantomData;
use std::string::{String, ToString as _};

use proptest::strategy::{NewTree, Strategy, ValueTree};
use proptest::test_runner::TestRunner;

use self::draw::Draw;
use self::number::Leaf;
use self::random::Random;
use self::replay::Replay;
use self::tree::Node;
use crate::{Constraint, ConstraintKind, Message, Open, Path};

/// A strategy for messages that have no violations and that JSON can represent.
pub const fn valid<T: Message>() -> Valid<T> {
    Valid(PhantomData)
}

/// A strategy for messages that violate one rule in one field. `None` if no value of the message can violate a rule.
///
/// The messages never exceed sequence or string bounds that are greater than 4096.
pub fn invalid<T: Message>() -> Option<Invalid<T>> {
    let faults = fault::count(T::DESCRIPTOR);
    (faults > 0).then_some(Invalid { faults, marker: PhantomData })
}

/// A strategy for the documented values of an enum or error code, or for combinations of the documented flags.
pub const fn documented<T: Open>() -> Documented<T> {
    Documented(PhantomData)
}

/// A strategy for values that the definition doesn't name, or for flags with at least one unnamed bit. `None` if all
/// values have names.
pub fn undocumented<T: Open>() -> Option<Undocumented<T>> {
    let has_any = !fault::values(T::SCALAR, constraint::<T>(), ConstraintKind::Enum).is_empty();
    has_any.then_some(Undocumented(PhantomData))
}

/// The strategy of [`valid`].
pub struct Valid<T>(PhantomData<T>);

/// The strategy of [`invalid`].
pub struct Invalid<T> {
    /// Number of possible faults.
    faults: usize,
    marker: PhantomData<T>,
}

/// The strategy of [`documented`].
pub struct Documented<T>(PhantomData<T>);

/// The strategy of [`undocumented`].
pub struct Undocumented<T>(PhantomData<T>);

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

impl<T: Message> Strategy for Valid<T> {
    type Tree = ValidTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let root = Draw::new(Random::new(runner)?).message(T::DESCRIPTOR, None)?;
        Ok(ValidTree { root, marker: PhantomData })
    }
}

impl<T: Message> Strategy for Invalid<T> {
    type Tree = InvalidTree<T>;
    type Value = InvalidMessage<T>;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let mut random = Random::new(runner)?;
        let fault = random.below(self.faults);
        let root = Draw::new(random).message(T::DESCRIPTOR, Some(fault))?;
        Ok(InvalidTree { root, marker: PhantomData })
    }
}

impl<T: Open + Debug> Strategy for Documented<T> {
    type Tree = OpenTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let leaf = Leaf::valid(T::SCALAR, constraint::<T>(), &mut Random::new(runner)?);
        let leaf = leaf.ok_or("the type has no documented value")?;
        Ok(OpenTree { leaf, marker: PhantomData })
    }
}

impl<T: Open + Debug> Strategy for Undocumented<T> {
    type Tree = OpenTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let leaf =
            Leaf::invalid(T::SCALAR, constraint::<T>(), ConstraintKind::Enum, &mut Random::new(runner)?);
        let leaf = leaf.ok_or("all values of the type are documented")?;
        Ok(OpenTree { leaf, marker: PhantomData })
    }
}

/// The constraint that allows the documented values of an enum, flags or error codes.
fn constraint<T: Open>() -> &'static Constraint<'static> {
    struct Of<T>(PhantomData<T>);

    impl<T: Open> Of<T> {
        const CONSTRAINT: &'static Constraint<'static> =
            &Constraint { known: Some(T::KNOWN), names: T::NAMES, is_flags: T::IS_FLAGS, ..Constraint::NONE };
    }

    Of::<T>::CONSTRAINT
}

/// A [`Valid`] message during simplification.
pub struct ValidTree<T> {
    root: Node,
    marker: PhantomData<T>,
}

/// An [`Invalid`] message during simplification.
pub struct InvalidTree<T> {
    root: Node,
    marker: PhantomData<T>,
}

/// A [`Documented`] or [`Undocumented`] value during simplification.
pub struct OpenTree<T> {
    leaf: Leaf,
    marker: PhantomData<T>,
}

impl<T: Message> ValueTree for ValidTree<T> {
    type Value = T;

    fn current(&self) -> T {
        Replay::of(&self.root).message()
    }

    fn simplify(&mut self) -> bool {
        self.root.simplify()
    }

    fn complicate(&mut self) -> bool {
        self.root.complicate()
    }
}

impl<T: Message> ValueTree for InvalidTree<T> {
    type Value = InvalidMessage<T>;

    fn current(&self) -> InvalidMessage<T> {
        let mut path = Path::to(T::DESCRIPTOR);
        let rule = fault::locate(T::DESCRIPTOR, &self.root, &mut path);
        InvalidMessage { value: Replay::of(&self.root).message(), rule, path: path.to_string() }
    }

    fn simplify(&mut self) -> bool {
        self.root.simplify()
    }

    fn complicate(&mut self) -> bool {
        self.root.complicate()
    }
}

impl<T: Open + Debug> ValueTree for OpenTree<T> {
    type Value = T;

    fn current(&self) -> T {
        T::from_bits(self.leaf.bits())
    }

    fn simplify(&mut self) -> bool {
        self.leaf.simplify()
    }

    fn complicate(&mut self) -> bool {
        self.leaf.complicate()
    }
}

/// Implements traits without the `T` bounds that a derive would add.
macro_rules! plain {
    ($($type:ident $name:literal;)*) => {$(
        impl<T> Clone for $type<T> {
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<T> Copy for $type<T> {}

        impl<T> Debug for $type<T> {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(formatter, concat!($name, " {}"), core::any::type_name::<T>())
            }
        }
    )*};
}

plain!(Valid "valid"; Invalid "invalid"; Documented "documented"; Undocumented "undocumented";);

/// Implements `Arbitrary` for a message.
#[doc(hidden)]
#[macro_export]
macro_rules! __arbitrary_record {
    ($type:ident) => {
        impl $crate::proptest::arbitrary::Arbitrary for $type {
            type Parameters = ();
            type Strategy = $crate::strategy::Valid<Self>;

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
            type Strategy = $crate::strategy::Documented<Self>;

            fn arbitrary_with((): ()) -> Self::Strategy {
                $crate::strategy::documented()
            }
        }
    };
}
