//! The error codes of a package: one open newtype for all tables.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_schema::{ErrorCode, Package, prose};

use super::context::Context;
use super::file::{documentation, header_of, header_of_package, inner_documentation, layout_file};
use super::identifier::ident;
use super::types;
use crate::identifier::error_code_names;

/// Creates the module text.
pub(super) fn emit(context: &Context<'_>, package: &Package) -> String {
    let mut codes: Vec<&ErrorCode> = package.error_tables.iter().flat_map(|table| &table.codes).collect();
    // Sort the codes, because the ranges of tables may overlap.
    codes.sort_by_key(|code| code.code);
    let header = match package.error_tables.as_slice() {
        [table] => header_of(context, package, table.span),
        _ => header_of_package(package),
    };
    header + &layout_file(tokens(package, &codes))
}

fn tokens(package: &Package, codes: &[&ErrorCode]) -> TokenStream {
    let module_doc = inner_documentation(&format!("Error codes of package `{}`.", package.name));
    let names: Vec<Ident> = error_code_names(codes).iter().map(|name| ident(name)).collect();
    let name_of = |number: &u32| {
        if let Some(index) = codes.iter().position(|code| code.code == *number) {
            let name = &names[index];
            quote!(ErrorCode::#name)
        } else {
            let code = types::integer((*number).into());
            quote!(ErrorCode(#code))
        }
    };
    let constants = codes.iter().zip(&names).map(|(code, name)| {
        let doc = documentation(&text(code));
        let value = types::integer(code.code.into());
        quote!(#doc pub const #name: Self = Self(#value);)
    });
    let entries = codes.iter().zip(&names).map(|(code, name)| {
        let abbreviation =
            types::option(code.abbreviation.as_ref().map(|abbreviation| quote!(#abbreviation)));
        let description = &code.description;
        let see_also = code.see_also.iter().map(name_of);
        let alternatives = code.alternatives.iter().map(name_of);
        quote!(Entry {
            code: ErrorCode::#name,
            abbreviation: #abbreviation,
            description: #description,
            see_also: &[#(#see_also),*],
            alternatives: &[#(#alternatives),*],
        })
    });
    let known = codes.iter().map(|code| {
        let value = types::integer(code.code.into());
        let abbreviation = code.abbreviation.as_deref().unwrap_or_default();
        quote!(#value #abbreviation;)
    });
    let count = types::integer(codes.len() as i128);
    let type_doc = documentation(
        "An error code. Unlisted codes are valid.\n\n\
         A constant is named after the abbreviation of its code. If codes of different severities share \
         an abbreviation, the name includes the severity.",
    );
    quote! {
        #module_doc
        #type_doc
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct ErrorCode(pub u32);

        impl ErrorCode {
            #(#constants)*
        }

        impl ErrorCode {
            /// All listed codes, in order.
            pub fn all() -> impl ::core::iter::ExactSizeIterator<Item = Self> + ::core::iter::DoubleEndedIterator {
                ENTRIES.iter().map(|entry| entry.code)
            }

            /// The severity `(code & 0xFF) >> 6`, which is also defined for unlisted codes.
            pub const fn severity(self) -> ::uavspec_runtime::Severity {
                ::uavspec_runtime::Severity::of(self.0)
            }

            /// The class of the code. Each class is a range of numbers.
            pub const fn class(self) -> ::uavspec_runtime::ErrorClass {
                ::uavspec_runtime::ErrorClass::of(self.0)
            }

            /// True if the code is in a table.
            pub fn is_known(self) -> bool {
                self.entry().is_some()
            }

            /// The short name for small displays.
            pub fn abbreviation(self) -> ::core::option::Option<&'static str> {
                self.entry()?.abbreviation
            }

            /// The description.
            pub fn description(self) -> ::core::option::Option<&'static str> {
                ::core::option::Option::Some(self.entry()?.description)
            }

            /// Codes that the description refers to.
            pub fn see_also(self) -> &'static [Self] {
                self.entry().map_or(&[], |entry| entry.see_also)
            }

            /// Codes for the same condition at other severities. Only one of these codes is used at a time.
            pub fn alternatives(self) -> &'static [Self] {
                self.entry().map_or(&[], |entry| entry.alternatives)
            }

            fn entry(self) -> ::core::option::Option<&'static Entry> {
                let found = ENTRIES.binary_search_by_key(&self, |entry| entry.code);
                found.ok().map(|index| &ENTRIES[index])
            }
        }

        /// Formats the number, followed by the abbreviation if there is one.
        impl ::core::fmt::Display for ErrorCode {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                match self.abbreviation() {
                    ::core::option::Option::Some(abbreviation) => ::core::write!(formatter, "{} {abbreviation}", self.0),
                    ::core::option::Option::None => ::core::write!(formatter, "{}", self.0),
                }
            }
        }

        impl ::core::fmt::Debug for ErrorCode {
            fn fmt(&self, formatter: &mut ::core::fmt::Formatter<'_>) -> ::core::fmt::Result {
                ::core::write!(formatter, "ErrorCode({self})")
            }
        }

        impl ::core::convert::From<u32> for ErrorCode {
            fn from(code: u32) -> Self {
                Self(code)
            }
        }

        impl ::core::convert::From<ErrorCode> for u32 {
            fn from(code: ErrorCode) -> Self {
                code.0
            }
        }

        /// A table entry.
        struct Entry {
            code: ErrorCode,
            abbreviation: ::core::option::Option<&'static str>,
            description: &'static str,
            see_also: &'static [ErrorCode],
            alternatives: &'static [ErrorCode],
        }

        /// Entries sorted by code.
        static ENTRIES: [Entry; #count] = [#(#entries),*];

        ::uavspec_runtime::error_code! { ErrorCode; #(#known)* }
    }
}

fn text(code: &ErrorCode) -> String {
    let description = prose::block(&code.description);
    match &code.abbreviation {
        Some(abbreviation) => format!("{} {}: {description}", code.code, prose::code(abbreviation)),
        None => format!("{}: {description}", code.code),
    }
}
