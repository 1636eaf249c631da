//! Enums and flags as open newtypes over their integer type.

use std::fmt::Write as _;

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_schema::{Enum, Message};

use super::file::documentation;
use super::identifier::{Scope, ident, upper_case};
use super::text::constant_text;
use super::types;

/// Declares the type of an enum with its constants and traits.
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
    let owner_text = match users.as_slice() {
        [] => format!("`{}_*` in `{}`", found.prefixes.join("_*`, `"), owner.name),
        users => format!("`{}` in `{}`", users.join("`, `"), owner.name),
    };
    let rest = if found.is_flags {
        "Any combination is valid, and unnamed bits are preserved."
    } else {
        "Unnamed values are preserved."
    };
    let doc = documentation(&format!("{what} of {owner_text}.\n\n{rest}"));
    let primitive = types::primitive(found.scalar);
    let names = member_names(found);
    let constants = found.with_aliases().zip(&names).map(|((member, alias_of), name)| {
        let mut text = constant_text(&owner.constants[member.constant]);
        if let Some(first) = alias_of {
            let _ = write!(text, "\n\nAlias of `{}`.", first.name);
        }
        let doc = documentation(&text);
        let value = number(found, member.value);
        quote!(#doc pub const #name: Self = Self(#value);)
    });
    let flags = found.is_flags.then(|| quote!(flags));
    let known = found.members.iter().map(|member| {
        let (value, name) = (number(found, member.value), &member.name);
        quote!(#value #name;)
    });
    quote! {
        #doc
        #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct #name(pub #primitive);

        impl #name {
            #(#constants)*
        }

        ::uavspec_runtime::open! { #name: #primitive #flags; #(#known)* }
    }
}

fn member_names(found: &Enum) -> Vec<Ident> {
    let mut scope = Scope::default();
    found.members.iter().map(|member| ident(&scope.unique(&upper_case(&member.name)))).collect()
}

/// A value of an enum, or a mask in hexadecimal notation.
fn number(found: &Enum, value: i128) -> TokenStream {
    if !found.is_flags || value < 0 {
        return types::integer(value);
    }
    let literal: Result<proc_macro2::Literal, _> = format!("0x{value:x}").parse();
    literal.map_or_else(|_| types::integer(value), |literal| quote!(#literal))
}
