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

/// Gives a message `set_flags()` from its flags: the field, whether it is set, its group and its label.
#[macro_export]
macro_rules! flags {
    ($type:ident; $($field:ident $name:literal $group:literal $label:literal;)*) => {
        impl $type {
            /// The flags that are set, in declared order.
            pub fn set_flags(&self) -> impl ::core::iter::Iterator<Item = $crate::Flag> {
                [$((
                    // Of a `bool`, a number and an enum alike.
                    u8::from(self.$field) != 0,
                    $crate::Flag { field: $name, group: $group, label: $label },
                )),*]
                .into_iter()
                .filter_map(|(is_set, flag)| is_set.then_some(flag))
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
