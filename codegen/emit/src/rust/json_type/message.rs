//! Messages: a module with the bodies of each message, and an enum of all messages for each direction.

use proc_macro2::{Ident, TokenStream};
use quote::quote;
use uavspec_schema::json_type::{Direction, JsonMessage, JsonPart, Member, Object};
use uavspec_schema::{JsonMessageId, Package, prose};

use super::super::context::Context;
use super::super::file::{documentation, header_of, inner_documentation, layout_file, module_declaration};
use super::super::identifier::{Scope, ident, module_name, pascal_case};
use super::names::{MODULE, Names, TYPES, is_struct_field, text};
use super::types::Definitions;
use crate::file::OutputFile;

/// Name of the variant for undefined message types.
const OTHER: &str = "Other";

/// A message with its names.
struct Place<'s> {
    message: &'s JsonMessage,
    module: String,
    variant: Ident,
}

/// The content of the module `json`, and the files of the messages.
pub(super) fn files(
    context: &Context<'_>,
    package: &Package,
    names: &Names,
    module: &str,
) -> (TokenStream, Vec<OutputFile>) {
    let places = places(context, &package.json_messages);
    let modules = places.iter().map(|place| {
        let doc = documentation(&format!("Bodies of {}.", prose::code(&place.message.name)));
        let declaration = module_declaration(MODULE, &place.module);
        quote!(#doc #declaration)
    });
    let enums = Direction::ALL.map(|direction| direction_tokens(&places, direction));
    let root = quote!(#(#modules)* #(#enums)*);
    let files = places.iter().map(|place| OutputFile {
        path: format!("{module}/{MODULE}/{}.rs", place.module),
        text: header_of(context, package, place.message.span)
            + &layout_file(message_tokens(context, names, place.message)),
    });
    (root, files.collect())
}

fn places<'s>(context: &Context<'s>, ids: &[JsonMessageId]) -> Vec<Place<'s>> {
    let (mut modules, mut variants) = (Scope::default(), Scope::default());
    modules.unique(TYPES);
    variants.unique_type(OTHER);
    let place = |id: &JsonMessageId| {
        let message = context.schema.json_message(*id);
        Place {
            message,
            module: modules.unique(&module_name(&message.name)),
            variant: ident(&variants.unique_type(&pascal_case(&message.name))),
        }
    };
    ids.iter().map(place).collect()
}

/// The enum of all messages of a direction, if there are any.
fn direction_tokens(places: &[Place<'_>], direction: Direction) -> Option<TokenStream> {
    let has_part = |place: &&Place<'_>| place.message.parts.iter().any(|part| part.direction == direction);
    let places: Vec<&Place<'_>> = places.iter().filter(has_part).collect();
    if places.is_empty() {
        return None;
    }
    let name = ident(direction.title());
    let variants = places.iter().map(|place| {
        let (variant, module) = (&place.variant, ident(&place.module));
        let summary = if place.message.docs.summary.is_empty() {
            format!("Message {}.", prose::code(&place.message.name))
        } else {
            format!("{}: {}", prose::code(&place.message.name), prose::inline(&place.message.docs.summary))
        };
        let doc = documentation(&summary);
        quote!(#doc #variant(#module::#name))
    });
    let entries = places.iter().map(|Place { variant, message, module }| {
        let (module, name) = (ident(module), &message.name);
        quote!(#variant #module #name;)
    });
    let doc = documentation(match direction {
        Direction::Request => "A message from a client that expects a response.",
        Direction::Response => "A response to a request.",
        Direction::Notification => "An unsolicited message from a server.",
    });
    let other = documentation("A message of another type, as JSON.");
    Some(quote! {
        #doc
        #[derive(Clone, Debug, PartialEq)]
        pub enum #name {
            #(#variants,)*
            #other
            Other(::uavspec_runtime::json_type::Json),
        }

        ::uavspec_runtime::json_messages! { #name; #(#entries)* }
    })
}

fn message_tokens(context: &Context<'_>, names: &Names, message: &JsonMessage) -> TokenStream {
    let doc = inner_documentation(&format!(
        "Bodies of {}.\n\n{}",
        prose::code(&message.name),
        text(&message.docs, "Message", &message.name)
    ));
    let mut definitions = Definitions::of_message(context, names);
    for part in &message.parts {
        definitions.new_name(part.direction.title());
    }
    let parts: Vec<TokenStream> =
        message.parts.iter().map(|part| part_tokens(&mut definitions, message, part)).collect();
    quote!(#doc #(#parts)*)
}

fn part_tokens(definitions: &mut Definitions<'_>, message: &JsonMessage, part: &JsonPart) -> TokenStream {
    let name = ident(part.direction.title());
    let mut lines = format!("Body of a {} of type {}.", part.direction, prose::code(&message.name));
    let description = prose::block(&part.docs.text());
    if !description.is_empty() {
        lines += "\n\n";
        lines += &description;
    }
    if !part.answers.is_empty() {
        let answers: Vec<String> = part.answers.iter().map(|answer| prose::code(answer)).collect();
        lines += "\n\nResponses: ";
        lines += &answers.join(", ");
        lines.push('.');
    }
    let fields: Vec<Member> =
        part.body.fields.iter().filter(|field| is_struct_field(field)).cloned().collect();
    let body = Object { fields: Vec::new(), is_closed: part.body.is_closed };
    let tokens = definitions.object(&documentation(&lines), &name, &body, &fields);
    let inner = definitions.take_inner();
    quote!(#tokens #(#inner)*)
}
