//! Enums and flags: open newtypes over the number in a field.

use core::fmt;

use crate::Scalar;
use crate::record::Primitive;

/// An enum, a set of flags or an error code. The type is open: it can also represent values that the definition doesn't
/// name.
pub trait Open: Sized {
    /// The name of the type.
    const NAME: &'static str;
    /// The type of the number.
    const SCALAR: Scalar;
    /// The numbers of the documented values, or the masks of the flags.
    const KNOWN: &'static [i128];
    /// The names of the documented values, without their prefix. Empty for an error code without an abbreviation.
    const NAMES: &'static [&'static str];
    /// True if values are combinations of the documented masks.
    const IS_FLAGS: bool;

    /// Creates a value from the low bits of `bits`.
    fn from_bits(bits: u64) -> Self;
}

/// Formats an enum value as its name, or as its type and number if the value has no name.
pub fn fmt_enum(
    formatter: &mut fmt::Formatter<'_>,
    type_name: &str,
    name: Option<&str>,
    value: impl fmt::Debug,
) -> fmt::Result {
    match name {
        Some(name) => formatter.pad(name),
        None => write!(formatter, "{type_name}({value:?})"),
    }
}

/// Formats the names of the flags that are set, separated by `|`, and the other bits as a number.
pub fn fmt_flags<T: Open, P: Primitive>(
    formatter: &mut fmt::Formatter<'_>,
    value: P,
    unknown: P,
) -> fmt::Result {
    write!(formatter, "{}(", T::NAME)?;
    let mut separator = "";
    for name in flag_names::<T>(value) {
        write!(formatter, "{separator}{name}")?;
        separator = " | ";
    }
    let unknown = unknown.bits();
    if unknown != 0 || separator.is_empty() {
        write!(formatter, "{separator}{unknown:#x}")?;
    }
    formatter.write_str(")")
}

/// The names of the flags that are set in `value`. A flag with several names yields only its first name.
pub fn flag_names<T: Open>(value: impl Primitive) -> impl Iterator<Item = &'static str> {
    let bits = value.bits();
    let flags = T::KNOWN.iter().zip(T::NAMES).enumerate();
    flags.filter_map(move |(index, (mask, name))| {
        // Clears the bits of a sign-extended negative mask above the width of the number.
        let mask_bits = mask & i128::from(u64::MAX >> (64 - 8 * T::SCALAR.size()));
        let is_set = mask_bits != 0 && i128::from(bits) & mask_bits == mask_bits;
        (is_set && !T::KNOWN[..index].contains(mask)).then_some(*name)
    })
}

/// Implements the methods and traits of an enum or of flags for a newtype over a number. The other arguments are the
/// documented values and their names.
#[macro_export]
macro_rules! open {
    ($type:ident: $number:ident; $($known:literal $name:literal;)*) => {
        impl $type {
            /// The name of the value in the definition, without its prefix.
            pub const fn name(self) -> ::core::option::Option<&'static str> {
                #[allow(unreachable_patterns)] // the first name of a value wins
                match self.0 {
                    $($known => ::core::option::Option::Some($name),)*
                    _ => ::core::option::Option::None,
                }
            }

            /// True if the definition names the value.
            pub const fn is_known(self) -> bool {
                self.name().is_some()
            }
        }

        impl ::core::fmt::Debug for $type {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                $crate::__private::fmt_enum(formatter, stringify!($type), self.name(), self.0)
            }
        }

        $crate::__format_enum!($type; $($known $name;)*);
        $crate::__open!($type: $number; false; $($known $name;)*);
    };
    ($type:ident: $number:ident flags; $($known:literal $name:literal;)*) => {
        impl $type {
            /// True if all flags of `other` are set.
            pub const fn contains(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }

            /// True if no flag is set.
            pub const fn is_empty(self) -> bool {
                self.0 == 0
            }

            /// The names of the flags that are set.
            pub fn names(self) -> impl ::core::iter::Iterator<Item = &'static str> {
                $crate::__private::flag_names::<Self>(self.0)
            }

            /// True if the definition names all flags that are set.
            pub const fn is_known(self) -> bool {
                self.unknown() == 0
            }

            #[allow(clippy::identity_op)] // if 0 is among the documented values
            const fn unknown(self) -> $number {
                self.0 & !(0 $(| $known)*)
            }
        }

        impl ::core::ops::BitOr for $type {
            type Output = Self;

            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }

        impl ::core::fmt::Debug for $type {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                $crate::__private::fmt_flags::<Self, $number>(formatter, self.0, self.unknown())
            }
        }

        $crate::__format_flags!($type);
        $crate::__open!($type: $number; true; $($known $name;)*);
    };
}

/// The part of [`open!`](crate::open!) shared by enums and flags.
#[doc(hidden)]
#[macro_export]
macro_rules! __open {
    ($type:ident: $number:ident; $is_flags:literal; $($known:literal $name:literal;)*) => {
        $crate::__documented!($type: $number; $is_flags; $($known $name;)*);

        impl $crate::record::Value for $type {
            const LEAST_SIZE: usize = <$number as $crate::record::Value>::LEAST_SIZE;

            #[inline]
            fn initial() -> Self {
                Self(0)
            }

            #[inline]
            fn write<S: $crate::record::Sink>(&self, sink: &mut S, _: &'static $crate::descriptor::FieldDescriptor) {
                sink.scalar(self.0);
            }

            #[inline]
            fn read<S: $crate::record::Source>(source: &mut S, _: &'static $crate::descriptor::FieldDescriptor) -> Self {
                Self(source.scalar())
            }
        }

        $crate::__view_number!($type $number);

        impl ::core::convert::From<$number> for $type {
            fn from(number: $number) -> Self {
                Self(number)
            }
        }

        impl ::core::convert::From<$type> for $number {
            fn from(value: $type) -> Self {
                value.0
            }
        }

        $crate::__json_field!($type);
    };
}

/// Implements the traits of an error code for a newtype, according to the enabled features.
#[macro_export]
macro_rules! error_code {
    ($type:ident; $($known:literal $name:literal;)*) => {
        $crate::__format_error_code!($type; $($known $name;)*);
        $crate::__documented!($type: u32; false; $($known $name;)*);
        $crate::__json_plain!($type);
    };
}

/// The part shared by enums, flags and error codes.
#[doc(hidden)]
#[macro_export]
macro_rules! __documented {
    ($type:ident: $number:ident; $is_flags:literal; $($known:literal $name:literal;)*) => {
        impl $crate::Open for $type {
            const NAME: &'static str = stringify!($type);
            const SCALAR: $crate::Scalar = <$number as $crate::record::Primitive>::SCALAR;
            const KNOWN: &'static [i128] = &[$($known),*];
            const NAMES: &'static [&'static str] = &[$($name),*];
            const IS_FLAGS: bool = $is_flags;

            #[inline]
            fn from_bits(bits: u64) -> Self {
                Self(<$number as $crate::record::Primitive>::read_le(&bits.to_le_bytes()))
            }
        }

        $crate::__json_number!($type);
        $crate::__arbitrary_number!($type);
        $crate::__schema_number!($type);
    };
}
