//! Flags of a message: its `bool` fields, for people to read.

/// A field that says yes or no, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Flag {
    /// Name of the field.
    pub field: &'static str,
    /// The group that the definition puts it in; empty where that has none.
    pub group: &'static str,
    /// What the definition says of it.
    pub label: &'static str,
}

impl Flag {
    /// The flags whose entry in `are_set` is true. A text is a field, its group and its label.
    #[doc(hidden)]
    pub fn set<const N: usize>(
        are_set: [bool; N],
        texts: &'static [[&'static str; 3]; N],
    ) -> impl Iterator<Item = Self> {
        let flags = are_set.into_iter().zip(texts);
        flags.filter_map(|(is_set, [field, group, label])| is_set.then_some(Self { field, group, label }))
    }
}

/// Gives a message `set_flags()`. A line holds the field, its name, its group and its label; a field that is not a
/// `bool` is followed by the comparison that makes it one.
#[macro_export]
macro_rules! flags {
    ($type:ident; $($field:ident $(. $inner:tt)? $(!= $unset:literal)? $name:literal $group:literal $label:literal;)*) => {
        impl $type {
            /// The flags that are set, in declared order.
            pub fn set_flags(&self) -> impl ::core::iter::Iterator<Item = $crate::Flag> {
                $crate::Flag::set(
                    [$(self.$field $(.$inner)? $(!= $unset)?),*],
                    &[$([$name, $group, $label]),*],
                )
            }
        }
    };
}

/// Gives a message whose flags each report a failure when they are set `contains_failure()`.
#[macro_export]
macro_rules! failure_flags {
    ($type:ident;) => {
        impl $type {
            /// Whether any flag is set: each of them reports a failure.
            pub fn contains_failure(&self) -> bool {
                self.set_flags().next().is_some()
            }
        }
    };
}
