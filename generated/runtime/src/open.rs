//! Enums and flags: open newtypes over the number that a field holds.

use core::fmt;

/// An enum or flags. Open: a value that the definition doesn't name is kept as it is.
pub trait Open {
    /// The numbers of the documented values, or the masks of the flags.
    const KNOWN: &'static [i128];
}

/// Writes an open enum: the name of its value, or its type and number where that is unknown.
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

/// Writes flags: the names of those that are set between `|`, and what is left as a number.
pub fn fmt_flags(
    formatter: &mut fmt::Formatter<'_>,
    type_name: &str,
    names: impl Iterator<Item = &'static str>,
    unknown: u64,
) -> fmt::Result {
    write!(formatter, "{type_name}(")?;
    let mut separator = "";
    for name in names {
        write!(formatter, "{separator}{name}")?;
        separator = " | ";
    }
    if unknown != 0 || separator.is_empty() {
        write!(formatter, "{separator}{unknown:#x}")?;
    }
    formatter.write_str(")")
}

/// Implements [`Open`](crate::Open) and conversions for a newtype over a number.
#[macro_export]
macro_rules! open {
    ($type:ident: $number:ident; $($known:literal),*;) => {
        impl $crate::Open for $type {
            const KNOWN: &'static [i128] = &[$($known),*];
        }

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

        impl $crate::uorb::Viewed for $type {
            type View<'b> = Self;
            const STRIDE: usize = <$number as $crate::uorb::Viewed>::STRIDE;

            #[inline]
            fn view_at(bytes: &[u8], offset: usize) -> Self {
                Self(<$number as $crate::uorb::Viewed>::view_at(bytes, offset))
            }
        }

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

        $crate::__json_number!($type);
        $crate::__json_field!($type);
    };
}

/// Gives the newtype over an error code what the features ask for.
#[macro_export]
macro_rules! error_code {
    ($type:ident;) => {
        $crate::__json_number!($type);
    };
}
