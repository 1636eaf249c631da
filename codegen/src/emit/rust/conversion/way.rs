//! One direction of the conversions between two packages.

use proc_macro2::TokenStream;
use quote::quote;

use crate::conversion::Conversion;
use crate::emit::rust::context::Context;
use crate::emit::rust::identifier::ident;
use crate::schema::MessageId;

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
        let modules =
            place.modules[1..place.modules.len().saturating_sub(1)].iter().map(|module| ident(module));
        let (package, name) = (ident(self.modules[side]), ident(&place.type_name));
        quote!(#package::#(#modules::)* #name)
    }
}
