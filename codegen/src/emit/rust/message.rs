//! A message: its struct, constants, traits, layout assertion and JSON, then its enums.

use std::fmt::Write as _;

use proc_macro2::{Ident, TokenStream};
use quote::quote;

use super::identifier::{Scope, ident, snake_case, upper_case};
use super::{Context, documentation, enumeration, types};
use crate::emit::prose;
use crate::schema::{Element, Field, Message, MessageId, Shape, Slot, Special, UorbLayout};
use crate::unit;
use crate::value::Value;

/// Everything that the module of a message holds.
pub(super) fn tokens(context: &Context<'_>, id: MessageId) -> TokenStream {
    let message = context.schema.message(id);
    let parts = Parts {
        context,
        id,
        message,
        name: ident(&context.place(id).type_name),
        fields: field_names(message),
    };
    let definition = parts.definition();
    let default = parts.default();
    let constants = parts.constants();
    let traits = parts.message_trait();
    let layout = message.uorb.as_ref().map(|layout| parts.layout(layout));
    let json = parts.json();
    let enums = message
        .enums
        .iter()
        .zip(&context.enum_names[id.0 as usize])
        .map(|(found, name)| enumeration::tokens(message, found, &ident(name)));
    quote!(#definition #default #constants #traits #layout #json #(#enums)*)
}

struct Parts<'c> {
    context: &'c Context<'c>,
    id: MessageId,
    message: &'c Message,
    name: Ident,
    fields: Vec<Ident>,
}

fn field_names(message: &Message) -> Vec<Ident> {
    let mut scope = Scope::default();
    message.fields.iter().map(|field| ident(&scope.unique(&snake_case(&field.name)))).collect()
}

impl Parts<'_> {
    fn definition(&self) -> TokenStream {
        let Self { name, fields, .. } = self;
        let doc = documentation(&self.message_text());
        let types = self.message.fields.iter().map(|field| types::field(self.context, self.id, field));
        let docs = self.message.fields.iter().map(|field| documentation(&self.field_text(field)));
        let default = self.derives_default().then(|| quote!(, Default));
        quote! {
            #doc
            #[derive(Clone, Debug, PartialEq #default)]
            pub struct #name {
                #(#docs pub #fields: #types,)*
            }
        }
    }

    fn derives_default(&self) -> bool {
        self.message.fields.iter().all(|field| types::derives_default(self.context, self.id, field))
    }

    fn default(&self) -> Option<TokenStream> {
        if self.derives_default() {
            return None;
        }
        let Self { name, fields, .. } = self;
        let values = self.message.fields.iter().map(|field| types::default(self.context, self.id, field));
        Some(quote! {
            impl ::core::default::Default for #name {
                fn default() -> Self {
                    Self { #(#fields: #values),* }
                }
            }
        })
    }

    /// Constants that are no members of an enum.
    fn constants(&self) -> Option<TokenStream> {
        let Self { name, message, .. } = self;
        let is_member = |index: usize| {
            message.enums.iter().flat_map(|found| &found.members).any(|member| member.constant == index)
        };
        let mut scope = Scope::default();
        let constants: Vec<TokenStream> = message
            .constants
            .iter()
            .enumerate()
            .filter(|(index, _)| !is_member(*index))
            .map(|(_, constant)| {
                let name = ident(&scope.unique(&upper_case(&constant.name)));
                let doc = documentation(&constant_text(constant));
                let ty = types::constant(constant.ty);
                let value = types::literal(constant.ty, &constant.value);
                quote!(#doc pub const #name: #ty = #value;)
            })
            .collect();
        (!constants.is_empty()).then(|| quote!(impl #name { #(#constants)* }))
    }

    fn message_trait(&self) -> TokenStream {
        let Self { name, message, .. } = self;
        let package = &self.context.schema.package_of(message).name;
        let message_name = &message.name;
        let topics = &message.topics;
        let integer = |value: u64| types::integer(value.into());
        let version = types::option(message.version.map(|version| integer(version.into())));
        let queue_length = integer(message.queue_length.unwrap_or(1).into());
        let hash = hexadecimal(message.hash);
        let type_hash = &message.type_hash;
        let cdr_size = types::option(message.cdr.is_fixed.then(|| integer(message.cdr.least)));
        quote! {
            impl ::uavspec_runtime::Message for #name {
                const PACKAGE: &'static str = #package;
                const NAME: &'static str = #message_name;
                const TOPICS: &'static [&'static str] = &[#(#topics),*];
                const VERSION: ::core::option::Option<u32> = #version;
                const QUEUE_LENGTH: u32 = #queue_length;
                const HASH: u32 = #hash;
                const TYPE_HASH: &'static str = #type_hash;
                const CDR_SIZE: ::core::option::Option<usize> = #cdr_size;
            }
        }
    }

    /// Sizes and offsets.
    fn layout(&self, layout: &UorbLayout) -> TokenStream {
        let name = &self.name;
        let size = types::integer(layout.size as i128);
        let no_padding = types::integer(layout.size_no_padding as i128);
        let is_nested = |field: &&Field| matches!(field.ty.element, Element::Message(_));
        let nested = self.message.fields.iter().filter(is_nested).count();
        let scalars = types::integer((self.message.fields.len() - nested) as i128);
        let members = layout.slots.iter().filter_map(|slot| Some(self.member(slot, slot.field?)));
        quote! {
            ::uavspec_runtime::uorb_message! {
                #name, #size, #no_padding, #scalars;
                #(#members)*
            }
        }
    }

    fn member(&self, slot: &Slot, field: usize) -> TokenStream {
        let field = &self.message.fields[field];
        let name = &slot.name;
        let offset = types::integer(slot.offset as i128);
        let count = match field.ty.shape {
            Shape::Array(length) => types::integer(length.into()),
            Shape::Single | Shape::Bounded(_) | Shape::Sequence => quote!(1),
        };
        match field.ty.element {
            Element::Message(nested) => {
                let path = self.context.path(self.id, nested);
                quote!(nested #name #offset #path, #count;)
            }
            Element::Scalar(scalar) => {
                let size = types::integer(scalar.size() as i128);
                quote!(#name #offset #size #count;)
            }
            // Messages with strings have no layout.
            Element::String { .. } => TokenStream::new(),
        }
    }

    fn json(&self) -> TokenStream {
        let Self { name, fields, message, .. } = self;
        let message_name = &message.name;
        let names = message.fields.iter().map(|field| &field.name);
        let words = types::integer(message.fields.len().div_ceil(64) as i128);
        let indices = (0..message.fields.len()).map(proc_macro2::Literal::usize_unsuffixed);
        quote! {
            #[cfg(feature = "serde")]
            ::uavspec_runtime::json_record! {
                #name, #message_name, #words;
                #(#indices #fields #names;)*
            }
        }
    }

    fn message_text(&self) -> String {
        let message = self.message;
        let mut text = if message.docs.summary.is_empty() {
            format!("The message `{}`, which its definition says no more of.", message.name)
        } else {
            prose::inline(&message.docs.summary)
        };
        if !message.docs.description.is_empty() {
            text += "\n\n";
            text += &prose::block(&message.docs.description);
        }
        let mut facts: Vec<(&str, String)> = Vec::new();
        if !message.topics.is_empty() {
            let topics: Vec<String> = message.topics.iter().map(|topic| prose::code(topic)).collect();
            facts.push(("topics", topics.join(", ")));
        }
        if let Some(version) = message.version {
            facts.push(("message version", version.to_string()));
        }
        if let Some(length) = message.queue_length {
            facts.push(("queue length", length.to_string()));
        }
        if let Some(layout) = &message.uorb {
            facts.push(("uORB", format!("{} bytes, hash `0x{:08x}`", layout.size, message.hash)));
        }
        let cdr = if message.cdr.is_fixed { "bytes" } else { "bytes or more" };
        facts.push(("CDR", format!("{} {cdr}", message.cdr.least)));
        text += "\n\n| | |\n|---|---|";
        for (name, value) in facts {
            let _ = write!(text, "\n| {name} | {value} |");
        }
        text
    }

    fn field_text(&self, field: &Field) -> String {
        let mut text = if field.description.is_empty() {
            format!("The field `{}`, which its definition says no more of.", field.name)
        } else {
            prose::block(&field.description)
        };
        let facts = self.field_facts(field);
        if !facts.is_empty() {
            let facts = facts.join("; ");
            let (first, rest) = facts.split_at(1);
            let _ = write!(text, "\n\n{}{rest}.", first.to_uppercase());
        }
        text
    }

    fn field_facts(&self, field: &Field) -> Vec<String> {
        let mut facts = Vec::new();
        if let Some(group) = field.group {
            facts.push(format!("group: {}", prose::inline(&self.message.groups[group].summary)));
        }
        match field.unit.as_deref() {
            None | Some(unit::NONE) => {}
            Some(symbol) => facts.push(match unit::lookup(symbol) {
                Some(unit) => format!("unit: {} ({})", prose::inline(symbol), unit.name),
                None => format!("unit: {}", prose::inline(symbol)),
            }),
        }
        if let Some(range) = &field.range {
            facts.extend(
                range_text(range.low.as_ref(), range.high.as_ref()).map(|range| format!("range: {range}")),
            );
        }
        if let Some(invalid) = &field.invalid {
            facts.push(format!("no data: {}", special_text(invalid)));
        }
        if let Some(uncontrolled) = &field.uncontrolled {
            facts.push(format!("not controlled: {}", special_text(uncontrolled)));
        }
        if let Some(frame) = &field.frame {
            facts.push(format!("frame: {}", prose::inline(frame)));
        }
        if let Some(array) = field.counts {
            facts.push(format!("counts the entries in use of [`{0}`](Self::{0})", self.fields[array]));
        }
        match (field.ty.shape, field.ty.element) {
            (Shape::Bounded(bound), _) => facts.push(format!("at most {bound} elements")),
            (_, Element::String { bound: Some(bound), .. }) => {
                facts.push(format!("at most {bound} characters"));
            }
            _ => {}
        }
        facts
    }
}

/// The documentation of a constant, with the parameters that a command takes.
pub(super) fn constant_text(constant: &crate::schema::Constant) -> String {
    let mut text = match constant.name.as_str() {
        _ if !constant.description.is_empty() => prose::block(&constant.description),
        "MESSAGE_VERSION" => "Version of the message, raised when its fields change.".to_owned(),
        "ORB_QUEUE_LENGTH" => "How many messages a topic holds before the oldest is lost.".to_owned(),
        name => format!("The constant `{name}`, which its definition says no more of."),
    };
    if constant.parameters.iter().any(|parameter| !is_unused(&parameter.description)) {
        text += "\n\n| parameter | unit | meaning |\n|---|---|---|";
        for (index, parameter) in constant.parameters.iter().enumerate() {
            let unit = parameter
                .unit
                .as_deref()
                .filter(|unit| *unit != unit::NONE)
                .map(prose::inline)
                .unwrap_or_default();
            let range = parameter
                .range
                .as_ref()
                .and_then(|range| range_text(range.low.as_ref(), range.high.as_ref()));
            let range = range.map(|range| format!(" ({range})")).unwrap_or_default();
            let _ = write!(
                text,
                "\n| {} | {unit} | {}{range} |",
                index + 1,
                prose::inline(&parameter.description)
            );
        }
    }
    text
}

fn is_unused(description: &str) -> bool {
    matches!(description, "" | "Unused" | "Empty")
}

fn range_text(low: Option<&Value>, high: Option<&Value>) -> Option<String> {
    match (low, high) {
        (Some(low), Some(high)) => Some(format!("{low} to {high}")),
        (Some(low), None) => Some(format!("{low} or more")),
        (None, Some(high)) => Some(format!("at most {high}")),
        (None, None) => None,
    }
}

fn special_text(special: &Special) -> String {
    let value =
        special.value.as_ref().map_or_else(|| "empty".to_owned(), |value| prose::code(&value.to_string()));
    if special.text.is_empty() { value } else { format!("{value} ({})", prose::inline(&special.text)) }
}

fn hexadecimal(value: u32) -> TokenStream {
    // Eight digits in any case: a hash is easier to compare so.
    let literal: Result<proc_macro2::Literal, _> = format!("0x{value:08x}").parse();
    literal.map_or_else(|_| types::integer(value.into()), |literal| quote!(#literal))
}
