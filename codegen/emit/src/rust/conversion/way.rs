//! One direction of the conversions between two packages.

use proc_macro2::TokenStream;
use quote::quote;
use uavspec_dynamic::conversion::Conversion;
use uavspec_schema::{EnumRef, MessageId};

use crate::rust::context::Context;
use crate::rust::identifier::ident;

/// The modules of both packages, in one direction.
pub(super) struct Way<'c> {
    pub(super) context: &'c Context<'c>,
    /// The modules of the source and the target package.
    pub(super) modules: [&'c str; 2],
    /// The names of the source and the target package.
    pub(super) names: [&'c str; 2],
    pub(super) conversions: Vec<&'c Conversion>,
}

impl Way<'_> {
    /// The path of a message's type.
    pub(super) fn path(&self, id: MessageId, side: usize) -> TokenStream {
        let place = self.context.place(id);
        let modules = place.modules.split_last().map_or(&[][..], |(_, modules)| modules);
        self.scoped(modules, side, &place.type_name)
    }

    /// The path of an enum's type.
    pub(super) fn enumeration(&self, reference: EnumRef, side: usize) -> TokenStream {
        let name = &self.context.enum_names[reference.message.0 as usize][reference.index];
        self.scoped(&self.context.place(reference.message).modules, side, name)
    }

    /// The path of a type. The modules of both packages are imported.
    fn scoped(&self, modules: &[String], side: usize, name: &str) -> TokenStream {
        let is_imported = modules.first().is_some_and(|module| module == self.modules[side]);
        let ups = (!is_imported).then(|| quote!(super::super::));
        let modules = modules.iter().map(|module| ident(module));
        let name = ident(name);
        quote!(#ups #(#modules::)* #name)
    }
}
