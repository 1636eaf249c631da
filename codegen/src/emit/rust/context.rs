//! The names and places of all types that are generated.

use proc_macro2::TokenStream;
use quote::quote;

use super::identifier::ident;
use crate::emit::origin::Origins;
use crate::schema::{MessageId, Schema};

/// The place of a message's type: the path from the root of the module tree, and the type's name.
#[derive(Clone, Debug)]
pub(super) struct Place {
    pub(super) modules: Vec<String>,
    pub(super) type_name: String,
    /// Of a message of fixed size, the name of the type that looks at its bytes.
    pub(super) view_name: String,
}

impl Place {
    /// The names of its public types but for enums.
    pub(super) fn names(&self) -> impl Iterator<Item = &String> {
        [&self.type_name, &self.view_name].into_iter().filter(|name| !name.is_empty())
    }
}

/// All that the parts of the emitter look up.
pub(super) struct Context<'s> {
    pub(super) schema: &'s Schema,
    pub(super) origins: Origins<'s>,
    /// By [`MessageId`].
    pub(super) places: Vec<Option<Place>>,
    /// Names of the types of the enums of each message, by [`MessageId`].
    pub(super) enum_names: Vec<Vec<String>>,
}

impl Context<'_> {
    pub(super) fn place(&self, id: MessageId) -> &Place {
        // Every listed message has a place, and so has every message that it refers to.
        self.places[id.0 as usize].as_ref().unwrap_or(&UNPLACED)
    }

    /// The path of a message's type as the module of another message writes it.
    pub(super) fn path(&self, from: MessageId, to: MessageId) -> TokenStream {
        self.public_path(from, to, &self.place(to).type_name)
    }

    /// The path of a message's view type as the module of another message writes it.
    pub(super) fn view_path(&self, from: MessageId, to: MessageId) -> TokenStream {
        self.public_path(from, to, &self.place(to).view_name)
    }

    fn public_path(&self, from: MessageId, to: MessageId, type_name: &str) -> TokenStream {
        // Types are re-exported by the package's module, so the message's own module is left out.
        let modules = &self.place(to).modules;
        self.relative(from, &modules[..modules.len().saturating_sub(1)], type_name)
    }

    /// The path of an enum's type as the module of another message writes it.
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
