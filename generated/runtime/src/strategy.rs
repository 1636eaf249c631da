//! Values for property tests: strategies of [`proptest`].
//!
//! Every message, enum, set of flags and error code implements
//! [`Arbitrary`](proptest::arbitrary::Arbitrary), so that `any::<BatteryStatus>()` works, also as a part of
//! other strategies. What it gives is [`valid`]: [`Message::validate`] finds nothing in it and JSON can carry
//! it. The values that programs stumble over are frequent: the ends of ranges and of types, the values that
//! mean "no data", NaN where it has a meaning, `-0.0`, subnormal floats, sequences, strings and text that are
//! empty or full, characters of several bytes.
//!
//! [`broken`] gives the opposite: a value that breaks one rule in one place, and says which and where.
//! [`undocumented`] gives values of an enum, bits of flags or error codes that no definition names.
//!
//! ```
//! # use uavspec_runtime::{Definition, Message, record};
//! # #[derive(Clone, Debug, Default, PartialEq)]
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
//! use uavspec_runtime::strategy::{broken, valid};
//!
//! proptest!(|(wind in valid::<Wind>())| prop_assert!(wind.validate().is_empty()));
//!
//! let broken = broken::<Wind>().expect("the speed has a range");
//! proptest!(|(broken in broken)| {
//!     let found = broken.value.validate();
//!     prop_assert_eq!((found[0].rule, found[0].path.to_string()), (broken.rule, broken.path));
//! });
//! ```
//!
//! Values are drawn from the description of a message, number by number, and read from the list of numbers
//! as from any payload. So a message costs no code of its own here, and a case with three hundred numbers
//! takes some ten microseconds. A failing case is simplified number by number: towards zero, or
//! what is next to it in the range; towards the first documented values; element by element of sequences and
//! characters of text.

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
use crate::{Constraint, Message, Open, Path, Rule};

/// Messages without a broken rule, which JSON can carry.
pub const fn valid<T: Message>() -> Valid<T> {
    Valid(PhantomData)
}

/// Messages that break one rule in one place; none where the definition leaves nothing to break.
///
/// What has a bound above 4096 is never made too long.
pub fn broken<T: Message>() -> Option<Breaking<T>> {
    let faults = fault::count(T::DESCRIPTOR);
    (faults > 0).then_some(Breaking { faults, of: PhantomData })
}

/// The documented values of an enum or of error codes, or any set of the documented flags.
pub const fn documented<T: Open>() -> Documented<T> {
    Documented(PhantomData)
}

/// Values that no definition names, or flags with at least one such bit; none where all are named.
pub fn undocumented<T: Open>() -> Option<Undocumented<T>> {
    let has_any = !fault::values(T::SCALAR, constraint::<T>(), Rule::Enum).is_empty();
    has_any.then_some(Undocumented(PhantomData))
}

/// See [`valid`].
pub struct Valid<T>(PhantomData<T>);

/// See [`broken`].
pub struct Breaking<T> {
    /// In how many ways a value can be broken.
    faults: usize,
    of: PhantomData<T>,
}

/// See [`documented`].
pub struct Documented<T>(PhantomData<T>);

/// See [`undocumented`].
pub struct Undocumented<T>(PhantomData<T>);

/// A message that breaks one rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken<T> {
    /// The message.
    pub value: T,
    /// The rule.
    pub rule: Rule,
    /// Where, as [`Violation`](crate::Violation) shows its path: `events[2].id`.
    pub path: String,
}

impl<T: Message + Debug> Strategy for Valid<T> {
    type Tree = ValidTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let root = Draw::new(Random::new(runner)?).message(T::DESCRIPTOR, None)?;
        Ok(ValidTree { root, of: PhantomData })
    }
}

impl<T: Message + Debug> Strategy for Breaking<T> {
    type Tree = BrokenTree<T>;
    type Value = Broken<T>;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let mut random = Random::new(runner)?;
        let fault = random.below(self.faults);
        let root = Draw::new(random).message(T::DESCRIPTOR, Some(fault))?;
        Ok(BrokenTree { root, of: PhantomData })
    }
}

impl<T: Open + Debug> Strategy for Documented<T> {
    type Tree = OpenTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let leaf = Leaf::valid(T::SCALAR, constraint::<T>(), &mut Random::new(runner)?);
        let leaf = leaf.ok_or("it has no documented value")?;
        Ok(OpenTree { leaf, of: PhantomData })
    }
}

impl<T: Open + Debug> Strategy for Undocumented<T> {
    type Tree = OpenTree<T>;
    type Value = T;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let leaf = Leaf::broken(T::SCALAR, constraint::<T>(), Rule::Enum, &mut Random::new(runner)?);
        let leaf = leaf.ok_or("all its values are documented")?;
        Ok(OpenTree { leaf, of: PhantomData })
    }
}

/// What the documentation of an enum, flags or error codes allows.
fn constraint<T: Open>() -> &'static Constraint<'static> {
    struct Of<T>(PhantomData<T>);

    impl<T: Open> Of<T> {
        const CONSTRAINT: &'static Constraint<'static> =
            &Constraint { known: Some(T::KNOWN), names: T::NAMES, is_flags: T::IS_FLAGS, ..Constraint::NONE };
    }

    Of::<T>::CONSTRAINT
}

/// A message of [`Valid`], being simplified.
pub struct ValidTree<T> {
    root: Node,
    of: PhantomData<T>,
}

/// A message of [`Breaking`], being simplified.
pub struct BrokenTree<T> {
    root: Node,
    of: PhantomData<T>,
}

/// A value of [`Documented`] or [`Undocumented`], being simplified.
pub struct OpenTree<T> {
    leaf: Leaf,
    of: PhantomData<T>,
}

impl<T: Message + Debug> ValueTree for ValidTree<T> {
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

impl<T: Message + Debug> ValueTree for BrokenTree<T> {
    type Value = Broken<T>;

    fn current(&self) -> Broken<T> {
        let mut path = Path::to(T::DESCRIPTOR);
        let rule = fault::locate(T::DESCRIPTOR, &self.root, &mut path);
        Broken { value: Replay::of(&self.root).message(), rule, path: path.to_string() }
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

/// What a derive would ask of `T` is not needed.
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

plain!(Valid "valid"; Breaking "broken"; Documented "documented"; Undocumented "undocumented";);

/// Gives a message its `Arbitrary`.
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

/// Gives an enum, flags or an error code its `Arbitrary`.
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
