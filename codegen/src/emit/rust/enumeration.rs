//! Enums and flags: open newtypes over the number that the field holds.

use std::fmt::Write as _;

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_runtime::Scalar;

use super::identifier::{Scope, ident, upper_case};
use super::{documentation, message, types};
use crate::schema::{Enum, Message};

/// The type of an enum with all that belongs to it.
pub(super) fn tokens(owner: &Message, found: &Enum, name: &Ident) -> TokenStream {
    let users: Vec<&str> = owner
        .fields
        .iter()
        .filter(|field| {
            field.enumeration.is_some_and(|reference| owner.enums.get(reference.index) == Some(found))
        })
        .map(|field| field.name.as_str())
        .collect();
    let what = if found.is_flags { "Flags" } else { "Values" };
    let of = match users.as_slice() {
        [] => format!("`{}_*` of `{}`", found.prefixes.join("_*`, `"), owner.name),
        users => format!("`{}` of `{}`", users.join("`, `"), owner.name),
    };
    let rest = if found.is_flags {
        "Any of them may be set, and bits without a name are kept as they are."
    } else {
        "Open: a value without a name is kept as it is."
    };
    let doc = documentation(&format!("{what} of {of}.\n\n{rest}"));
    let primitive = types::primitive(found.scalar);
    let names = member_names(found);
    let constants = found.members.iter().zip(&names).map(|(member, name)| {
        let mut text = message::constant_text(&owner.constants[member.constant]);
        if let Some(first) = found.alias_of(member) {
            let _ = write!(text, "\n\nAnother name of `{}`.", first.name);
        }
        let doc = documentation(&text);
        let value = number(found, member.value);
        quote!(#doc pub const #name: Self = Self(#value);)
    });
    let known = found.members.iter().map(|member| number(found, member.value));
    let behaviour = if found.is_flags { flags(found, name, &names) } else { open_enum(found, name, &names) };
    quote! {
        #doc
        #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct #name(pub #primitive);

        impl #name {
            #(#constants)*
        }

        #behaviour

        ::uavspec_runtime::open! { #name: #primitive; #(#known),*; }
    }
}

fn member_names(found: &Enum) -> Vec<Ident> {
    let mut scope = Scope::default();
    found.members.iter().map(|member| ident(&scope.unique(&upper_case(&member.name)))).collect()
}

fn open_enum(found: &Enum, name: &Ident, names: &[Ident]) -> TokenStream {
    let arms = found.members.iter().zip(names).filter(|(member, _)| found.alias_of(member).is_none()).map(
        |(member, name)| {
            let text = &member.name;
            quote!(Self::#name => ::core::option::Option::Some(#text),)
        },
    );
    let type_name = name.to_string();
    quote! {
        impl #name {
            /// The name that the definition gives to the value, without its prefix.
            pub const fn name(self) -> ::core::option::Option<&'static str> {
                match self {
                    #(#arms)*
                    _ => ::core::option::Option::None,
                }
            }

            /// Whether the definition names the value.
            pub const fn is_known(self) -> bool {
                self.name().is_some()
            }
        }

        impl ::core::fmt::Debug for #name {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::uavspec_runtime::fmt_enum(formatter, #type_name, self.name(), self.0)
            }
        }
    }
}

fn flags(found: &Enum, name: &Ident, names: &[Ident]) -> TokenStream {
    let single: Vec<_> = found
        .members
        .iter()
        .zip(names)
        .filter(|(member, _)| member.value != 0 && found.alias_of(member).is_none())
        .collect();
    let count = types::integer(single.len() as i128);
    let entries = single.iter().map(|(member, name)| {
        let text = &member.name;
        quote!((Self::#name, #text))
    });
    let all = found.members.iter().fold(0, |all, member| all | member.value);
    let all = number(found, all);
    let unknown = unsigned(found.scalar, &quote!(self.0 & !#all));
    let type_name = name.to_string();
    quote! {
        impl #name {
            const NAMES: [(Self, &'static str); #count] = [#(#entries),*];

            /// Whether all flags of `other` are set.
            pub const fn contains(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }

            /// Whether no flag is set.
            pub const fn is_empty(self) -> bool {
                self.0 == 0
            }

            /// The names of the flags that are set.
            pub fn names(self) -> impl ::core::iter::Iterator<Item = &'static str> {
                Self::NAMES.into_iter().filter(move |(flag, _)| self.contains(*flag)).map(|(_, name)| name)
            }

            /// Whether the definition names all flags that are set.
            pub const fn is_known(self) -> bool {
                self.0 & !#all == 0
            }
        }

        impl ::core::ops::BitOr for #name {
            type Output = Self;

            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }

        impl ::core::fmt::Debug for #name {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::uavspec_runtime::fmt_flags(formatter, #type_name, self.names(), #unknown)
            }
        }
    }
}

/// A value of an enum, or a mask in hexadecimal.
fn number(found: &Enum, value: i128) -> TokenStream {
    if !found.is_flags || value < 0 {
        return types::integer(value);
    }
    let literal: Result<proc_macro2::Literal, _> = format!("0x{value:x}").parse();
    literal.map_or_else(|_| types::integer(value), |literal| quote!(#literal))
}

/// A `u64` of the bits of a number, without sign extension.
fn unsigned(scalar: Scalar, number: &TokenStream) -> TokenStream {
    match scalar {
        Scalar::UInt64 => quote!(#number),
        Scalar::Int64 => quote!((#number).cast_unsigned()),
        Scalar::Int8 | Scalar::Int16 | Scalar::Int32 => quote!((#number).cast_unsigned().into()),
        _ => quote!((#number).into()),
    }
}
