//! The events of a package: for each component a module with its enums, its events and their descriptors.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};
use uavspec_schema::translation::{Language, SOURCE_LANGUAGE, event_key};
use uavspec_schema::{Event, EventArgument, EventComponent, EventEnum, Package, prose};

use super::context::Context;
use super::file::{documentation, header_of, inner_documentation, layout_file, module_declaration};
use super::identifier::{Scope, ident, module_name, pascal_case, snake_case, upper_case};
use super::types;
use crate::file::OutputFile;

/// The names of the types in a component's module.
struct Names {
    module: String,
    enums: Vec<Ident>,
    events: Vec<Ident>,
}

/// Declares the modules of all components, and creates their files.
pub(super) fn files(
    context: &Context<'_>,
    package: &Package,
    module: &str,
) -> (TokenStream, Vec<OutputFile>) {
    if package.components.is_empty() {
        return (TokenStream::new(), Vec::new());
    }
    let mut modules = Scope::default();
    let names: Vec<Names> =
        package.components.iter().map(|component| self::names(component, &mut modules)).collect();
    let declarations = package.components.iter().zip(&names).map(|(component, names)| {
        let doc = documentation(&format!("Events of the component {}.", prose::code(&component.namespace)));
        let declaration = module_declaration(module, &names.module);
        quote!(#doc #declaration)
    });
    let searches = names.iter().map(|names| {
        let module = ident(&names.module);
        quote!(.or_else(|| #module::event(id)))
    });
    let tokens = quote! {
        #(#declarations)*

        /// The descriptor of the event with an id, in any component.
        pub fn event(id: u32) -> ::core::option::Option<&'static ::uavspec_runtime::event::EventDescriptor> {
            ::core::option::Option::None #(#searches)*
        }
    };
    let file = |(index, component): (usize, &EventComponent)| OutputFile {
        path: format!("{module}/{}.rs", names[index].module),
        text: header_of(context, package, component.span)
            + &layout_file(Emitter { context, package, component, names: &names, index }.tokens()),
    };
    let files = package.components.iter().enumerate().map(file).collect();
    (tokens, files)
}

fn names(component: &EventComponent, modules: &mut Scope) -> Names {
    let mut types = Scope::default();
    let mut name = |name: &str| ident(&types.unique_type(&pascal_case(name)));
    Names {
        module: modules.unique(&module_name(&component.namespace)),
        events: component.events.iter().map(|event| name(&event.name)).collect(),
        enums: component.enums.iter().map(|found| name(found.name.trim_end_matches("_t"))).collect(),
    }
}

struct Emitter<'e> {
    context: &'e Context<'e>,
    package: &'e Package,
    component: &'e EventComponent,
    names: &'e [Names],
    /// The index of the component.
    index: usize,
}

impl Emitter<'_> {
    fn tokens(&self) -> TokenStream {
        let Self { component, .. } = self;
        let doc =
            inner_documentation(&format!("Events of the component {}.", prose::code(&component.namespace)));
        let own = &self.names[self.index];
        let enums = component.enums.iter().zip(&own.enums).map(|(found, name)| self.enumeration(found, name));
        let events = component.events.iter().zip(&own.events).map(|(event, name)| self.event(event, name));
        let mut by_id: Vec<(u32, &Ident)> =
            component.events.iter().zip(&own.events).map(|(event, name)| (event.id, name)).collect();
        by_id.sort_unstable();
        let (count, by_id) = (types::integer(by_id.len() as i128), by_id.into_iter().map(|(_, name)| name));
        quote! {
            #doc
            #(#enums)*
            #(#events)*

            /// The descriptors of all events, sorted by id.
            pub static EVENTS: [&::uavspec_runtime::event::EventDescriptor; #count] =
                [#(<#by_id as ::uavspec_runtime::event::Event>::DESCRIPTOR),*];

            /// The descriptor of the event with an id.
            pub fn event(id: u32) -> ::core::option::Option<&'static ::uavspec_runtime::event::EventDescriptor> {
                let found = EVENTS.binary_search_by_key(&id, |event| event.id);
                found.ok().map(|at| EVENTS[at])
            }
        }
    }

    fn enumeration(&self, found: &EventEnum, name: &Ident) -> TokenStream {
        let is_bits = found.separator.is_some();
        let text = match found.description.as_str() {
            "" => format!("The type {}.", prose::code(&found.name)),
            description => prose::block(description),
        };
        let doc = documentation(&text);
        let primitive = types::primitive(found.scalar);
        let mut scope = Scope::default();
        scope.unique("LABELS");
        let constants = found.entries.iter().map(|entry| {
            let text = if entry.description.is_empty() { &entry.name } else { &entry.description };
            let doc = documentation(&prose::block(text));
            let name = ident(&scope.unique(&upper_case(&entry.name)));
            let value = types::integer(entry.value);
            quote!(#doc pub const #name: Self = Self(#value);)
        });
        let constants: Vec<TokenStream> = constants.collect();
        let flags = is_bits.then(|| quote!(flags));
        let known = found.entries.iter().map(|entry| {
            let (value, name) = (types::integer(entry.value), &entry.name);
            quote!(#value #name;)
        });
        let bits = types::option(found.separator.as_ref().map(|separator| {
            let bits = types::integer(8 * found.scalar.size() as i128);
            quote!((#bits, #separator))
        }));
        let key = event_key(self.package, self.component, &found.name);
        let all = self.languages().map(|(tag, language)| {
            let entries = found.entries.iter().map(|entry| {
                let value = types::integer(entry.value);
                let label = translated(language, &format!("{key}/{}", entry.name), &entry.description);
                quote!((#value, #label))
            });
            quote!(::uavspec_runtime::event::EnumLabels { language: #tag, bits: #bits, entries: &[#(#entries),*] })
        });
        quote! {
            #doc
            #[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
            #[repr(transparent)]
            pub struct #name(pub #primitive);

            impl #name {
                #(#constants)*
                /// The labels of the values.
                pub const LABELS: &'static [::uavspec_runtime::event::EnumLabels] = &[#(#all),*];
            }

            ::uavspec_runtime::open! { #name: #primitive #flags; #(#known)* }
        }
    }

    fn event(&self, event: &Event, name: &Ident) -> TokenStream {
        let Self { component, .. } = self;
        let mut text = prose::block(&event.message);
        if !event.description.is_empty() {
            text = format!("{text}\n\n{}", prose::block(&event.description));
        }
        let doc = documentation(&text);
        let mut scope = Scope::default();
        let fields = event.arguments.iter().map(|argument| {
            let field = ident(&scope.unique(&snake_case(&argument.name)));
            (argument, field)
        });
        let fields: Vec<(&EventArgument, Ident)> = fields.collect();
        let declared = fields.iter().map(|(argument, field)| {
            let text = match argument.description.as_str() {
                "" => format!("The argument {}.", prose::code(&argument.name)),
                description => prose::block(description),
            };
            let (doc, ty) = (documentation(&text), self.argument_type(argument));
            quote!(#doc pub #field: #ty)
        });
        let reads = fields.iter().map(|(argument, field)| {
            let number = types::primitive(argument.scalar);
            if argument.enumeration.is_some() {
                quote!(#field: source.take::<#number>().into())
            } else {
                quote!(#field: source.take())
            }
        });
        let writes = fields.iter().map(|(argument, field)| {
            let number = types::primitive(argument.scalar);
            if argument.enumeration.is_some() {
                quote!(sink.put(<#number>::from(self.#field));)
            } else {
                quote!(sink.put(self.#field);)
            }
        });
        let arguments = event.arguments.iter().map(|argument| {
            let (name, scalar) = (&argument.name, ident(&format!("{:?}", argument.scalar)));
            let labels = if argument.enumeration.is_some() {
                let ty = self.argument_type(argument);
                quote!(#ty::LABELS)
            } else {
                quote!(&[])
            };
            quote!(::uavspec_runtime::event::ArgumentDescriptor::new(
                #name, ::uavspec_runtime::Scalar::#scalar, #labels
            ))
        });
        let key = event_key(self.package, component, &event.name);
        let texts = self.languages().map(|(tag, language)| {
            let message = translated(language, &key, &event.message);
            let description = translated(language, &format!("{key}/description"), &event.description);
            quote!(::uavspec_runtime::event::EventTexts::new(#tag, #message, #description))
        });
        let (id, namespace, own_name, group) =
            (types::integer(event.id.into()), &component.namespace, &event.name, &event.group);
        // An event without arguments reads and writes nothing.
        let [source, sink] = ["source", "sink"]
            .map(|name| if fields.is_empty() { format_ident!("_{name}") } else { format_ident!("{name}") });
        quote! {
            #doc
            #[derive(Clone, Copy, Debug, Default, PartialEq)]
            pub struct #name {
                #(#declared,)*
            }

            impl ::uavspec_runtime::event::Event for #name {
                const DESCRIPTOR: &'static ::uavspec_runtime::event::EventDescriptor =
                    &::uavspec_runtime::event::EventDescriptor {
                        id: #id,
                        namespace: #namespace,
                        name: #own_name,
                        group: #group,
                        arguments: &[#(#arguments),*],
                        texts: &[#(#texts),*],
                    };

                fn read(#source: &mut ::uavspec_runtime::event::ArgumentReader<'_>) -> Self {
                    Self { #(#reads),* }
                }

                fn write(&self, #sink: &mut ::uavspec_runtime::event::ArgumentWriter) {
                    #(#writes)*
                }
            }
        }
    }

    fn argument_type(&self, argument: &EventArgument) -> TokenStream {
        match argument.enumeration {
            Some(found) => self.path(found.component, &self.names[found.component].enums[found.index]),
            None => types::primitive(argument.scalar),
        }
    }

    /// The path of an item in the module of a component.
    fn path(&self, component: usize, name: &Ident) -> TokenStream {
        if component == self.index {
            return quote!(#name);
        }
        let module = ident(&self.names[component].module);
        quote!(super::#module::#name)
    }

    /// English, and the languages into which the component is translated.
    fn languages(&self) -> impl Iterator<Item = (&str, Option<&Language>)> {
        let unit = uavspec_schema::translation::events_unit(self.package, self.component);
        let others =
            self.context.translations.languages.iter().filter(move |language| language.covers(&unit));
        let others = others.map(|language| (language.tag.as_str(), Some(language)));
        std::iter::once((SOURCE_LANGUAGE, None)).chain(others)
    }
}

/// The text in a language, or `text` if it is not translated.
fn translated<'t>(language: Option<&'t Language>, key: &str, text: &'t str) -> &'t str {
    language.and_then(|language| language.get(key)).unwrap_or(text)
}
