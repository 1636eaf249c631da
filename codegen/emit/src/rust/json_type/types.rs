//! Types: a struct for each object and tuple, an enum for each set, a newtype for each named type.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_schema::json_type::{
    Definition, Expression, JsonType, Member, Object, Set, SetValue, SetValues, Typed,
};
use uavspec_schema::value::Value;
use uavspec_schema::{JsonTypeId, Range, prose};

use super::super::context::Context;
use super::super::file::documentation;
use super::super::identifier::{self, Scope, ident, pascal_case};
use super::super::types as literals;
use super::names::{Names, field_names, text};
use crate::facts::{MARKDOWN, with_facts};

/// Name of the variant for unnamed values. The name `Other` could clash, because definitions use `other`.
const UNNAMED: &str = "Unnamed";

/// The type definitions of a module.
pub(super) struct Definitions<'c> {
    context: &'c Context<'c>,
    names: &'c Names,
    /// Names used in the module.
    scope: Scope,
    written: Vec<String>,
    /// Path prefix from this module to the module `json`, which re-exports the types.
    above: TokenStream,
    /// The page-defined type that is being written.
    current: Option<JsonTypeId>,
    /// Anonymous types inside the definition being written.
    inner: Vec<TokenStream>,
}

/// A member of a struct with its Rust type.
pub(super) struct Place<'m> {
    member: &'m Member,
    ident: Ident,
    ty: TokenStream,
    presence: &'static str,
}

impl<'c> Definitions<'c> {
    /// Starts the module that contains the types.
    pub(super) fn new(context: &'c Context<'c>, names: &'c Names) -> Self {
        let mut scope = Scope::default();
        names.types.iter().for_each(|name| drop(scope.unique_type(name)));
        let written = names.types.clone();
        Self { context, names, scope, written, above: TokenStream::new(), current: None, inner: Vec::new() }
    }

    /// Starts the module of a message, which has a separate scope.
    pub(super) fn of_message(context: &'c Context<'c>, names: &'c Names) -> Self {
        Self {
            scope: Scope::default(),
            written: Vec::new(),
            above: quote!(super::),
            ..Self::new(context, names)
        }
    }

    /// The names of all types written so far.
    pub(super) fn names(&self) -> &[String] {
        &self.written
    }

    /// A new name for an anonymous type.
    pub(super) fn new_name(&mut self, name: &str) -> Ident {
        let name = self.scope.unique_type(name);
        let found = ident(&name);
        self.written.push(name);
        found
    }

    /// Declares a type defined on a page, with its inner types.
    pub(super) fn json_type(&mut self, id: JsonTypeId) -> TokenStream {
        let found = self.context.schema.json_type(id);
        let name = ident(self.names.name(id));
        self.current = Some(id);
        let doc = documentation(&text(&found.docs, "Type", &found.name));
        let tokens = match &found.definition {
            Definition::Object(object) => self.object(&doc, &name, object, &object.fields),
            Definition::Tuple(elements) => self.tuple(&doc, &name, elements),
            Definition::Set(set) => set_tokens(found, &name, set),
            Definition::Named(typed) => self.named(&found.docs, &found.name, &name, typed),
        };
        self.current = None;
        let inner = std::mem::take(&mut self.inner);
        quote!(#tokens #(#inner)*)
    }

    /// Removes and returns the inner types of the definition that was written last.
    pub(super) fn take_inner(&mut self) -> Vec<TokenStream> {
        std::mem::take(&mut self.inner)
    }

    /// The struct of an object with these fields.
    pub(super) fn object(
        &mut self,
        doc: &TokenStream,
        name: &Ident,
        object: &Object,
        fields: &[Member],
    ) -> TokenStream {
        let places =
            self.places(name, fields, |member| if member.is_required { "required" } else { "optional" });
        let declaration = self.declaration(doc, name, &places);
        let openness = ident(if object.is_closed { "closed" } else { "open" });
        let entries = places.iter().map(|Place { member, ident, presence, .. }| {
            let (key, presence) = (&member.name, identifier::ident(presence));
            quote!(#ident #key #presence;)
        });
        quote!(#declaration ::uavspec_runtime::json_object! { #name #openness; #(#entries)* })
    }

    fn tuple(&mut self, doc: &TokenStream, name: &Ident, elements: &[Member]) -> TokenStream {
        let places = self.places(name, elements, tuple_presence);
        let declaration = self.declaration(doc, name, &places);
        let entries = places.iter().map(|Place { ident, presence, .. }| {
            let presence = identifier::ident(presence);
            quote!(#ident #presence;)
        });
        quote!(#declaration ::uavspec_runtime::json_tuple! { #name; #(#entries)* })
    }

    fn places<'m>(
        &mut self,
        owner: &Ident,
        members: &'m [Member],
        presence: impl Fn(&Member) -> &'static str,
    ) -> Vec<Place<'m>> {
        let idents = field_names(members);
        let mut places = Vec::with_capacity(members.len());
        for (member, ident) in members.iter().zip(idents) {
            let site = format!("{owner}{}", pascal_case(&member.name));
            let presence = presence(member);
            let ty = match (presence, member.typed.ty.without_null()) {
                ("nullable" | "omissible", Some(plain)) => {
                    let ty = self.expression(&plain, &site, false);
                    quote!(::core::option::Option<#ty>)
                }
                ("optional", _) => {
                    let ty = self.expression(&member.typed.ty, &site, false);
                    quote!(::core::option::Option<#ty>)
                }
                _ => self.expression(&member.typed.ty, &site, false),
            };
            places.push(Place { member, ident, ty, presence });
        }
        places
    }

    fn declaration(&self, doc: &TokenStream, name: &Ident, places: &[Place<'_>]) -> TokenStream {
        let members: Vec<Member> = places.iter().map(|place| place.member.clone()).collect();
        let default = self.names.defaults.of_members(&members).then(|| quote!(Default,));
        let fields = places.iter().map(|Place { member, ident, ty, .. }| {
            let doc = documentation(&member_text(member));
            quote!(#doc pub #ident: #ty)
        });
        quote! {
            #doc
            #[derive(Clone, Debug, #default PartialEq)]
            pub struct #name {
                #(#fields,)*
            }
        }
    }

    /// A newtype, with its range if it has one.
    fn named(
        &mut self,
        docs: &uavspec_schema::Docs,
        page_name: &str,
        name: &Ident,
        typed: &Typed,
    ) -> TokenStream {
        let inner = self.expression(&typed.ty, &format!("{name}Value"), false);
        let text = text(docs, "Type", page_name);
        let doc = documentation(&with_facts(&text, &MARKDOWN.limits(&typed.limits)));
        let default = self.names.defaults.of_expression(&typed.ty).then(|| quote!(Default,));
        let copy = matches!(typed.ty, Expression::Integer | Expression::Number | Expression::Boolean);
        let copy = copy.then(|| quote!(Copy,));
        let order = match typed.ty {
            Expression::Integer | Expression::Boolean | Expression::String => {
                quote!(Eq, PartialOrd, Ord, Hash)
            }
            Expression::Number => quote!(PartialOrd),
            _ => TokenStream::new(),
        };
        let kind = ident(if matches!(typed.ty, Expression::String) { "text" } else { "value" });
        let range = typed.limits.range.as_ref().and_then(|range| range_tokens(name, &typed.ty, range));
        quote! {
            #doc
            #[derive(Clone, #copy Debug, #default PartialEq, #order)]
            pub struct #name(
                /// The value in JSON.
                pub #inner,
            );

            #range

            impl ::core::convert::From<#inner> for #name {
                fn from(value: #inner) -> Self {
                    Self(value)
                }
            }

            ::uavspec_runtime::json_named! { #name #kind; }
        }
    }

    /// The Rust type of an expression. `site` is the name for an anonymous type. `is_indirect` is true inside a list or
    /// map, where a recursive type needs no box.
    fn expression(&mut self, expression: &Expression, site: &str, is_indirect: bool) -> TokenStream {
        let above = &self.above;
        match expression {
            Expression::Any => quote!(::uavspec_runtime::json_type::Json),
            Expression::Null => quote!(()),
            Expression::Boolean => quote!(bool),
            Expression::Integer => quote!(i64),
            Expression::Number => quote!(f64),
            Expression::String => quote!(::uavspec_runtime::alloc::string::String),
            Expression::ErrorCode => quote!(super::super::ErrorCode),
            Expression::ErrorList => quote!(::uavspec_runtime::alloc::vec::Vec<super::super::ErrorCode>),
            Expression::Named(id) => {
                let name = ident(self.names.name(*id));
                let is_boxed =
                    !is_indirect && self.current.is_some_and(|current| self.names.is_recursive(current, *id));
                if is_boxed {
                    quote!(::uavspec_runtime::alloc::boxed::Box<#name>)
                } else {
                    quote!(#above #name)
                }
            }
            Expression::List(element) => {
                let element = self.expression(element, site, true);
                quote!(::uavspec_runtime::alloc::vec::Vec<#element>)
            }
            Expression::Map(value) => {
                let value = self.expression(value, site, true);
                let string = quote!(::uavspec_runtime::alloc::string::String);
                quote!(::uavspec_runtime::alloc::collections::BTreeMap<#string, #value>)
            }
            Expression::OneOf(constants) => self.one_of(constants, site),
            Expression::Either(alternatives) => match expression.without_null() {
                Some(plain) if expression.is_nullable() => {
                    let plain = self.expression(&plain, site, is_indirect);
                    quote!(::core::option::Option<#plain>)
                }
                None => quote!(()),
                Some(_) => self.either(alternatives, site, is_indirect),
            },
        }
    }

    fn one_of(&mut self, constants: &[String], site: &str) -> TokenStream {
        let name = self.new_name(site);
        let value = |constant: &String| SetValue { value: constant.clone(), description: String::new() };
        let values = SetValues::Strings(constants.iter().map(value).collect());
        let doc = documentation("The values that the field allows; all others are invalid.");
        let tokens = set_body(&doc, &name, &Set { values, is_open: false });
        self.inner.push(tokens);
        quote!(#name)
    }

    fn either(&mut self, alternatives: &[Expression], site: &str, is_indirect: bool) -> TokenStream {
        let name = self.new_name(site);
        let mut scope = Scope::default();
        let mut variants = Vec::with_capacity(alternatives.len());
        for alternative in alternatives {
            let variant = ident(&scope.unique_type(&self.variant_name(alternative)));
            let inner = self.expression(alternative, &format!("{name}{variant}"), is_indirect);
            let text = self.context.schema.expression_text(alternative, &str::to_owned);
            let doc = documentation(&format!("A value of type {}.", prose::code(&text)));
            variants.push((doc, variant, inner));
        }
        let declarations = variants.iter().map(|(doc, variant, inner)| quote!(#doc #variant(#inner)));
        let entries = variants.iter().map(|(_, variant, _)| quote!(#variant;));
        let doc = documentation(
            "A value of one of several types. Reading uses the first type that accepts the value.",
        );
        let tokens = quote! {
            #doc
            #[derive(Clone, Debug, PartialEq)]
            pub enum #name {
                #(#declarations,)*
            }

            ::uavspec_runtime::json_either! { #name; #(#entries)* }
        };
        self.inner.push(tokens);
        quote!(#name)
    }

    fn variant_name(&self, expression: &Expression) -> String {
        match expression {
            Expression::Any => "Any".to_owned(),
            Expression::Null => "Null".to_owned(),
            Expression::Boolean => "Boolean".to_owned(),
            Expression::Integer => "Integer".to_owned(),
            Expression::Number => "Number".to_owned(),
            Expression::String => "String".to_owned(),
            Expression::ErrorCode => "ErrorCode".to_owned(),
            Expression::ErrorList => "ErrorList".to_owned(),
            Expression::Named(id) => self.names.name(*id).to_owned(),
            Expression::List(_) => "List".to_owned(),
            Expression::Map(_) => "Map".to_owned(),
            Expression::Either(_) | Expression::OneOf(_) => "Constant".to_owned(),
        }
    }
}

/// The presence of an element: required, nullable, optional, or both optional and nullable.
fn tuple_presence(member: &Member) -> &'static str {
    let is_nullable = member.typed.ty.is_nullable() && member.typed.ty.without_null().is_some();
    match (member.is_required, is_nullable) {
        (true, false) => "required",
        (true, true) => "nullable",
        (false, false) => "optional",
        (false, true) => "omissible",
    }
}

fn set_tokens(found: &JsonType, name: &Ident, set: &Set) -> TokenStream {
    let openness = if set.is_open { "Other values are preserved." } else { "Other values are not allowed." };
    let doc = documentation(&format!("{}\n\n{openness}", text(&found.docs, "Set", &found.name)));
    set_body(&doc, name, set)
}

fn set_body(doc: &TokenStream, name: &Ident, set: &Set) -> TokenStream {
    let openness = ident(if set.is_open { "open" } else { "closed" });
    let (call, ty, values): (_, _, Vec<_>) = match &set.values {
        SetValues::Integers(values) => {
            let entry = |found: &SetValue<i64>| {
                let text = value_text(&found.value.to_string(), &found.description);
                (number_name(found.value), text, literals::integer(found.value.into()))
            };
            (quote!(json_integers), quote!(i64), values.iter().map(entry).collect())
        }
        SetValues::Strings(values) => {
            let entry = |SetValue { value, description }: &SetValue<String>| {
                (pascal_case(value), value_text(value, description), quote!(#value))
            };
            let ty = quote!(::uavspec_runtime::alloc::string::String);
            (quote!(json_strings), ty, values.iter().map(entry).collect())
        }
    };
    let names = variant_names(values.iter().map(|(name, ..)| name.clone()), set.is_open);
    let declarations = names.iter().zip(&values).map(|(variant, (_, text, _))| {
        let doc = documentation(text);
        quote!(#doc #variant)
    });
    let entries = names.iter().zip(&values).map(|(variant, (.., value))| quote!(#variant #value;));
    let other = set.is_open.then(|| {
        let doc = documentation("Any value other than the named ones.");
        quote!(#doc Unnamed(#ty))
    });
    let is_copied = !set.is_open || matches!(set.values, SetValues::Integers(_));
    let copy = is_copied.then(|| quote!(Copy,));
    quote! {
        #doc
        #[derive(Clone, #copy Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum #name {
            #(#declarations,)*
            #other
        }

        ::uavspec_runtime::#call! { #name #openness; #(#entries)* }
    }
}

/// The documentation of a value.
fn value_text(value: &str, description: &str) -> String {
    let value = prose::code(value);
    if description.is_empty() {
        format!("{value}.")
    } else {
        format!("{value}: {}", prose::block(description))
    }
}

/// Unique variant names, which also differ from the name of the variant for unnamed values.
fn variant_names(names: impl Iterator<Item = String>, is_open: bool) -> Vec<Ident> {
    let mut scope = Scope::default();
    if is_open {
        scope.unique_type(UNNAMED);
    }
    let name = |name: String| {
        let name = if name.is_empty() { "Empty".to_owned() } else { name };
        let name = if name.starts_with(|c: char| c.is_ascii_digit()) { format!("Value{name}") } else { name };
        ident(&scope.unique_type(&name))
    };
    names.map(name).collect()
}

fn number_name(value: i64) -> String {
    if value < 0 { format!("Minus{}", value.unsigned_abs()) } else { format!("Value{value}") }
}

/// The range of a numeric newtype, and a method that checks whether a value is in the range.
fn range_tokens(name: &Ident, ty: &Expression, range: &Range) -> Option<TokenStream> {
    let (number, bounds) = match ty {
        Expression::Integer => (quote!(i64), integer_range(range)),
        Expression::Number => (quote!(f64), float_range(range)),
        _ => return None,
    };
    Some(quote! {
        impl #name {
            /// The minimum and the maximum.
            pub const RANGE: ::core::ops::RangeInclusive<#number> = #bounds;

            /// True if the value is in its range.
            pub fn is_in_range(self) -> bool {
                Self::RANGE.contains(&self.0)
            }
        }
    })
}

fn integer_range(range: &Range) -> TokenStream {
    let bound = |value: Option<&Value>, none: TokenStream, round: fn(f64) -> f64| match value {
        None => none,
        Some(Value::Int(value)) => match i64::try_from(*value) {
            Ok(value) => literals::integer(value.into()),
            Err(_) if *value < 0 => quote!(i64::MIN),
            Err(_) => quote!(i64::MAX),
        },
        #[allow(clippy::cast_possible_truncation)]
        // A bound beyond 64 bits becomes the nearest 64-bit integer.
        Some(other) => literals::integer((round(other.as_f64().unwrap_or_default()) as i64).into()),
    };
    let low = bound(range.low.as_ref(), quote!(i64::MIN), f64::ceil);
    let high = bound(range.high.as_ref(), quote!(i64::MAX), f64::floor);
    quote!(#low..=#high)
}

fn float_range(range: &Range) -> TokenStream {
    let bound = |value: Option<&Value>, none: TokenStream| match value.and_then(Value::as_f64) {
        None => none,
        Some(value) => literals::float64(value),
    };
    let low = bound(range.low.as_ref(), quote!(f64::NEG_INFINITY));
    let high = bound(range.high.as_ref(), quote!(f64::INFINITY));
    quote!(#low..=#high)
}

fn member_text(member: &Member) -> String {
    let text = if member.description.is_empty() {
        format!("Field `{}`; the definition has no description.", prose::code(&member.name).trim_matches('`'))
    } else {
        prose::block(&member.description)
    };
    with_facts(&text, &MARKDOWN.limits(&member.typed.limits))
}
