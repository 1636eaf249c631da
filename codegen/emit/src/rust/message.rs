//! Messages: struct, constants, traits, codecs, flags and enums.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_runtime::{Number, Scalar};
use uavspec_schema::value::Value;
use uavspec_schema::{Dialect, Element, Field, Message, MessageId, Restriction, Shape, UorbLayout, prose};

use super::context::Context;
use super::file::documentation;
use super::identifier::{Scope, ident, snake_case, upper_case};
use super::text::constant_text;
use super::{enumeration, types};
use crate::facts::{MARKDOWN, with_facts};

/// The width at which a long literal is wrapped.
const LINE_WIDTH: usize = 90;

/// The content of a message module.
pub(super) fn tokens(context: &Context<'_>, id: MessageId) -> TokenStream {
    let message = context.schema.message(id);
    let parts = Parts {
        context,
        id,
        message,
        name: ident(&context.place(id).type_name),
        fields: field_names(message),
        offsets: message.uorb.as_ref().map(UorbLayout::offsets).unwrap_or_default(),
    };
    let definition = parts.definition();
    let default = parts.default();
    let constants = parts.constants();
    let traits = parts.message_trait();
    let record = parts.record();
    let format = parts.format();
    let flags = parts.flags();
    let enums = message
        .enums
        .iter()
        .zip(&context.enum_names[id.0 as usize])
        .map(|(found, name)| enumeration::tokens(message, found, &ident(name)));
    quote!(#definition #default #constants #traits #record #format #flags #(#enums)*)
}

struct Parts<'c> {
    context: &'c Context<'c>,
    id: MessageId,
    message: &'c Message,
    name: Ident,
    fields: Vec<Ident>,
    /// The offsets of the fields in memory, by index.
    offsets: BTreeMap<usize, usize>,
}

/// The names of the fields of the struct.
pub(super) fn field_names(message: &Message) -> Vec<Ident> {
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
            #[derive(Clone, PartialEq #default)]
            pub struct #name {
                #(#docs pub #fields: #types,)*
            }
        }
    }

    fn derives_default(&self) -> bool {
        self.message.fields.iter().all(types::derives_default)
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

    /// Constants outside enums.
    fn constants(&self) -> Option<TokenStream> {
        let Self { name, message, .. } = self;
        let enums = message.enums.iter();
        let members: BTreeSet<usize> =
            enums.flat_map(|found| &found.members).map(|member| member.constant).collect();
        let mut scope = Scope::default();
        let constants: Vec<TokenStream> = message
            .constants
            .iter()
            .enumerate()
            .filter(|(index, _)| !members.contains(index))
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

    /// The implementation of the `Message` trait.
    fn message_trait(&self) -> TokenStream {
        let Self { name, message, .. } = self;
        let package = &self.context.schema.package_of(message).name;
        let message_name = &message.name;
        let topics = &message.topics;
        let version = types::option(message.version.map(|version| types::integer(version.into())));
        let queue_length = types::integer(message.queue_length.unwrap_or(1).into());
        let hash = hexadecimal(message.hash);
        let type_hash = &message.type_hash;
        let cdr_size = types::option(message.cdr.is_fixed.then(|| types::integer(message.cdr.min.into())));
        quote! {
            impl ::uavspec_runtime::Message for #name {
                const DEFINITION: ::uavspec_runtime::Definition = ::uavspec_runtime::Definition {
                    package: #package,
                    name: #message_name,
                    topics: &[#(#topics),*],
                    version: #version,
                    queue_length: #queue_length,
                    hash: #hash,
                    type_hash: #type_hash,
                    cdr_size: #cdr_size,
                };
            }
        }
    }

    /// The macro call that declares the fields and implements the codecs.
    fn record(&self) -> TokenStream {
        let Self { context, id, message, name, fields, .. } = self;
        let views = message.fields.iter().map(|field| {
            let view = message.uorb.as_ref().map(|_| types::view(context, *id, field));
            view.map(|view| quote!(: #view))
        });
        let indices = (0..message.fields.len()).map(proc_macro2::Literal::usize_unsuffixed);
        let descriptors = (0..message.fields.len()).map(|index| self.descriptor(index));
        let head = message.uorb.as_ref().map(|layout| {
            let view = ident(&self.context.place(self.id).view_name);
            let size = types::integer(layout.size as i128);
            let no_padding = types::integer(layout.size_no_padding as i128);
            quote!(, #view, #size, #no_padding)
        });
        let count = proc_macro2::Literal::usize_unsuffixed(fields.len());
        quote! {
            ::uavspec_runtime::record! {
                #name [#count] #head;
                #(#indices #fields #views = #descriptors;)*
            }
        }
    }

    /// The descriptor of a field, built with `uavspec_runtime::descriptor::field`.
    fn descriptor(&self, index: usize) -> TokenStream {
        let Self { context, id, message, .. } = self;
        let field = &message.fields[index];
        let name = &field.name;
        let offset = types::integer(self.offsets.get(&index).copied().unwrap_or(0) as i128);
        let element = match field.ty.element {
            Element::Text(length) => {
                let length = types::integer(length.into());
                quote!(text(#name, #offset).array(#length))
            }
            Element::Scalar(scalar) => {
                let maker = ident(scalar.name());
                quote!(#maker(#name, #offset))
            }
            Element::String { wide, bound } => {
                let maker = if wide { quote!(wstring) } else { quote!(string) };
                let bound = bound.map(|bound| {
                    let bound = types::integer(bound.into());
                    quote!(.at_most(#bound))
                });
                quote!(#maker(#name, #offset) #bound)
            }
            Element::Message(nested) => {
                let path = context.path(*id, nested);
                quote!(message::<#path>(#name, #offset))
            }
        };
        let shape = match field.ty.shape {
            Shape::Single => None,
            Shape::Array(length) => Some((quote!(array), Some(length))),
            Shape::Bounded(bound) => Some((quote!(bounded), Some(bound))),
            Shape::Sequence => Some((quote!(sequence), None)),
        };
        let shape = shape.map(|(method, length)| {
            let length = length.map(|length| types::integer(length.into()));
            quote!(.#method(#length))
        });
        let restriction = context.schema.restriction(message, field).map(|restriction| {
            let restriction = self.restriction(field, &restriction);
            quote!(.within(#restriction))
        });
        quote!(#element #shape #restriction)
    }

    fn restriction(&self, field: &Field, restriction: &Restriction) -> TokenStream {
        let demands = restriction.demands.iter().map(|(method, argument)| {
            let (method, argument) = (ident(method), number(*argument));
            quote!(.#method(#argument))
        });
        let special = (!restriction.special.is_empty()).then(|| {
            let special = restriction.special.iter().map(|value| number(*value));
            quote!(.or(&[#(#special),*]))
        });
        let count = restriction.limits.count.map(|length| {
            let length = types::integer(length.into());
            quote!(.counting(#length))
        });
        let known = field.enumeration.filter(|_| restriction.known.is_some()).map(|reference| {
            let path = types::enumeration(self.context, self.id, reference);
            if restriction.limits.is_flags { quote!(.flags::<#path>()) } else { quote!(.values::<#path>()) }
        });
        let nan = restriction.limits.forbids_nan.then(|| quote!(.not_nan()));
        quote!(&number() #(#demands)* #special #count #known #nan)
    }

    /// The defmt format string. Because the string is a single literal, it is stored only on the host.
    fn format(&self) -> TokenStream {
        let Self { message, name, fields, .. } = self;
        let mut words = vec![message.name.clone()];
        for (index, field) in message.fields.iter().enumerate() {
            let start = if index == 0 { "{{ " } else { "" };
            let end = if index + 1 == message.fields.len() { " }}" } else { "," };
            words.push(format!("{start}{}: {}{end}", field.name, placeholder(field)));
        }
        let text = wrapped(&words);
        quote!(::uavspec_runtime::format_record! { #name #text; #(#fields)*; })
    }

    /// The `set_flags()` method, for messages with flags.
    fn flags(&self) -> Option<TokenStream> {
        let Self { name, message, fields, .. } = self;
        let reports_failures = self.reports_failures();
        let mut entries = Vec::new();
        for (field, ident) in message.fields.iter().zip(fields) {
            let is_set = match (field.ty.element, field.ty.shape) {
                (Element::Scalar(Scalar::Bool), Shape::Single) => None,
                (Element::Scalar(Scalar::UInt8), Shape::Single) if reports_failures => {
                    let number = field.enumeration.map(|_| quote!(.0));
                    Some(quote!(#number != 0))
                }
                _ => continue,
            };
            let group = field.group.and_then(|group| message.groups.get(group));
            let group = group.map_or("", |group| group.summary.as_str());
            let field_name = &field.name;
            let label = field.description.lines().next().unwrap_or_default();
            entries.push(quote!(#ident #is_set #field_name #group #label;));
        }
        let failures = reports_failures.then(|| quote!(::uavspec_runtime::failure_flags! { #name; }));
        (!entries.is_empty()).then(|| quote!(::uavspec_runtime::flags! { #name; #(#entries)* } #failures))
    }

    /// True if every flag of the message reports a failure, as PX4 documents for `FailsafeFlags`.
    fn reports_failures(&self) -> bool {
        types::dialect(self.context, self.id) == Dialect::Px4 && self.message.name == "FailsafeFlags"
    }

    fn message_text(&self) -> String {
        let message = self.message;
        let mut text = if message.docs.summary.is_empty() {
            format!("Message `{}`; the definition has no description.", message.name)
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
        let is_px4 = types::dialect(self.context, self.id) == Dialect::Px4;
        if let Some(layout) = message.uorb.as_ref().filter(|_| is_px4) {
            facts.push(("uORB", format!("{} bytes, hash `0x{:08x}`", layout.size, message.hash)));
        }
        let cdr = if message.cdr.is_fixed { "" } else { "at least " };
        facts.push(("CDR", format!("{cdr}{} bytes", message.cdr.min)));
        text += "\n\n| | |\n|---|---|";
        for (name, value) in facts {
            let _ = write!(text, "\n| {name} | {value} |");
        }
        text
    }

    fn field_text(&self, field: &Field) -> String {
        let text = if field.description.is_empty() {
            format!("Field `{}`; the definition has no description.", field.name)
        } else {
            prose::block(&field.description)
        };
        let mut facts = MARKDOWN.field(self.message, field);
        if let Some(array) = field.counts {
            facts.push(format!("number of used entries in [`{0}`](Self::{0})", self.fields[array]));
        }
        match (field.ty.shape, field.ty.element) {
            (Shape::Bounded(bound), _) => facts.push(format!("at most {bound} elements")),
            (_, Element::String { bound: Some(bound), .. }) => {
                facts.push(format!("at most {bound} characters"));
            }
            _ => {}
        }
        with_facts(&text, &facts)
    }
}

/// A string literal of words, wrapped with escaped line breaks.
fn wrapped(words: &[String]) -> proc_macro2::Literal {
    let mut literal = String::from("\"");
    // In the output, the type name precedes the literal, and the literal starts with the message name.
    let mut width = words.first().map_or(0, |name| 2 * name.len());
    for (index, word) in words.iter().enumerate() {
        if index > 0 {
            literal.push(' ');
            width += word.len() + 1;
            if width > LINE_WIDTH {
                literal.push_str("\\\n        ");
                width = word.len();
            }
        }
        literal.extend(word.chars().flat_map(char::escape_default));
    }
    literal.push('"');
    let plain = || proc_macro2::Literal::string(&words.join(" "));
    literal.parse().unwrap_or_else(|_| plain())
}

/// The defmt placeholder of a field. If defmt supports the field's type, the placeholder names it, so the device
/// doesn't need to send it.
fn placeholder(field: &Field) -> String {
    let primitive = match field.ty.element {
        Element::Scalar(scalar) if field.enumeration.is_none() => types::primitive(scalar).to_string(),
        Element::String { .. } => "str".to_owned(),
        Element::Scalar(_) | Element::Text(_) | Element::Message(_) => "?".to_owned(),
    };
    // Byte arrays are the only arrays with a defmt type.
    let element = if primitive == "u8" { "u8" } else { "?" };
    match field.ty.shape {
        Shape::Single => format!("{{={primitive}}}"),
        Shape::Array(length) => format!("{{=[{element}; {length}]}}"),
        Shape::Bounded(_) | Shape::Sequence => format!("{{=[{element}]}}"),
    }
}

/// A number in a constraint.
fn number(value: Number) -> TokenStream {
    match value {
        Number::Int(value) => {
            let value = types::integer(value);
            quote!(int(#value))
        }
        Number::Float(value) => {
            let value = types::literal(Element::Scalar(Scalar::Float64), &Value::Float(value));
            quote!(float(#value))
        }
    }
}

fn hexadecimal(value: u32) -> TokenStream {
    // Write eight digits, which make hashes easier to compare.
    let literal: Result<proc_macro2::Literal, _> = format!("0x{value:08x}").parse();
    literal.map_or_else(|_| types::integer(value.into()), |literal| quote!(#literal))
}
