//! Names and module paths of the generated types.

use proc_macro2::TokenStream;
use quote::quote;
use uavspec_schema::translation::Translations;
use uavspec_schema::{MessageId, Schema};

use super::identifier::ident;
use crate::origin::Origins;

/// The location of a message type: the module path from the root, and the name of the type.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) modules: Vec<String>,
    pub(super) type_name: String,
    /// The name of the view type, or an empty string if the message has no fixed size.
    pub(super) view_name: String,
}

impl Place {
    /// The name of the innermost module.
    pub(super) fn module(&self) -> &str {
        self.modules.last().map_or("", String::as_str)
    }
}

/// The context that all parts of the emitter share.
pub(super) struct Context<'s> {
    pub(super) schema: &'s Schema,
    pub(super) translations: &'s Translations,
    pub(super) origins: Origins<'s>,
    /// Locations by [`MessageId`].
    pub(super) places: Vec<Option<Place>>,
    /// Names of enum types, by [`MessageId`].
    pub(super) enum_names: Vec<Vec<String>>,
}

impl Context<'_> {
    pub(super) fn place(&self, id: MessageId) -> &Place {
        // Every listed message, and every message that it refers to, has a location.
        self.places[id.0 as usize].as_ref().unwrap_or(&UNPLACED)
    }

    /// The path of a message type, relative to the module of another message.
    pub(super) fn path(&self, from: MessageId, to: MessageId) -> TokenStream {
        self.public_path(from, to, &self.place(to).type_name)
    }

    /// The path of a view type, relative to the module of another message.
    pub(super) fn view_path(&self, from: MessageId, to: MessageId) -> TokenStream {
        self.public_path(from, to, &self.place(to).view_name)
    }

    fn public_path(&self, from: MessageId, to: MessageId, type_name: &str) -> TokenStream {
        // The package module re-exports the types, so the path doesn't need the message module.
        let modules = &self.place(to).modules;
        self.relative(from, &modules[..modules.len().saturating_sub(1)], type_name)
    }

    /// The path of an enum type, relative to the module of another message.
    pub(super) fn enum_path(&self, from: MessageId, to: MessageId, type_name: &str) -> TokenStream {
        if self.place(from).modules == self.place(to).modules {
            let name = ident(type_name);
            return quote!(#name);
        }
        self.relative(from, &self.place(to).modules, type_name)
    }

    fn relative(&self, from: MessageId, modules: &[String], type_name: &str) -> TokenStream {
        let own = &self.place(from).modules;
        let shared = own.iter().zip(modules).take_while(|(left, right)| left == right).count();
        let ups = (shared..own.len()).map(|_| quote!(super::));
        let downs = modules[shared..].iter().map(|module| {
            let module = ident(module);
            quote!(#module::)
        });
        let name = ident(type_name);
        quote!(#(#ups)* #(#downs)* #name)
    }
}

static UNPLACED: Place = Place { modules: Vec::new(), type_name: String::new(), view_name: String::new() };
