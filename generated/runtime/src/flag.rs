//! Flags of a message: its `bool` fields with readable labels.

/// A flag of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Flag {
    /// The name of the field.
    pub field: &'static str,
    /// The group of the field in the definition, or an empty string.
    pub group: &'static str,
    /// The description in the definition.
    pub label: &'static str,
}

impl Flag {
    /// The flags whose entry in `are_set` is true. Each entry of `texts` is a field name, a group and a label.
    #[doc(hidden)]
    pub fn set<const N: usize>(
        are_set: [bool; N],
        texts: &'static [[&'static str; 3]; N],
    ) -> impl Iterator<Item = Self> {
        let flags = are_set.into_iter().zip(texts);
        flags.filter_map(|(is_set, [field, group, label])| is_set.then_some(Self { field, group, label }))
    }
}

/// Implements `set_flags()` for a message. Each line consists of a field, its name, its group and its label. A field
/// that is not a `bool` is followed by a comparison that yields a `bool`.
#[macro_export]
macro_rules! flags {
    ($type:ident; $($field:ident $(. $inner:tt)? $(!= $unset:literal)? $name:literal $group:literal $label:literal;)*) => {
        impl $type {
            /// The flags that are set, in declaration order.
            pub fn set_flags(&self) -> impl ::core::iter::Iterator<Item = $crate::Flag> {
                $crate::Flag::set(
                    [$(self.$field $(.$inner)? $(!= $unset)?),*],
                    &[$([$name, $group, $label]),*],
                )
            }
        }
    };
}

/// Implements `contains_failure()` for a message. Every flag of the message must report a failure.
#[macro_export]
macro_rules! failure_flags {
    ($type:ident;) => {
        impl $type {
            /// True if any flag is set. Every flag of this message reports a failure.
            pub fn contains_failure(&self) -> bool {
                self.set_flags().next().is_some()
            }
        }
    };
}
