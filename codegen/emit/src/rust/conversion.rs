//! Conversions between the messages of two packages, as implementations of `From`.
//!
//! The source is borrowed, because the fields of most messages are copied anyway, and programs often use the source
//! again. Only strings and sequences are cloned.

mod expression;
mod field;
mod way;

use std::fmt::Write as _;

use proc_macro2::TokenStream;
use quote::quote;
use uavspec_dynamic::conversion::{Conversion, Conversions, Step};
use uavspec_schema::prose;

use self::field::Fields;
use self::way::Way;
use super::context::Context;
use super::file::{documentation, header, inner_documentation, layout_file, module_declaration};
use super::identifier::{Scope, ident};
use crate::file::OutputFile;

/// The name of the module.
pub(super) const MODULE: &str = "conversions";

/// The declaration of the module in the root.
pub(super) fn declaration() -> TokenStream {
    let doc = documentation("Conversions between packages.");
    let module = ident(MODULE);
    quote!(#doc #[rustfmt::skip] pub mod #module;)
}

/// The files of all conversions. `module` returns the module of a package.
pub(super) fn files<'c>(
    context: &'c Context<'c>,
    conversions: &'c [Conversions],
    module: &dyn Fn(usize) -> &'c str,
) -> Vec<OutputFile> {
    let name = |package: usize| context.schema.packages[package].name.as_str();
    let mut files = Vec::new();
    let mut declarations = Vec::new();
    let mut scope = Scope::default();
    for found in conversions {
        let both = [(found.old, found.new, &found.forward), (found.new, found.old, &found.backward)];
        for (from, to, conversions) in both {
            let way = Way {
                context,
                modules: [module(from), module(to)],
                names: [name(from), name(to)],
                conversions: conversions.iter().map(AsRef::as_ref).collect(),
            };
            let file = scope.unique(&format!("{}_to_{}", way.modules[0], way.modules[1]));
            let doc = documentation(&format!("From `{}` to `{}`.", way.names[0], way.names[1]));
            let declaration = module_declaration(MODULE, &file);
            declarations.push(quote!(#doc #declaration));
            files.push(OutputFile { path: format!("{MODULE}/{file}.rs"), text: way.file() });
        }
    }
    let doc = inner_documentation(
        "Conversions between packages, as implementations of `From` for references.\n\n\
         The documentation of each conversion lists what it loses.",
    );
    let allowed = allowed();
    let text = header("the definitions") + &layout_file(quote!(#doc #allowed #(#declarations)*));
    files.push(OutputFile { path: format!("{MODULE}.rs"), text });
    files
}

impl Way<'_> {
    fn file(&self) -> String {
        let doc = inner_documentation(&self.text());
        let uses = self.modules.map(|module| {
            let module = ident(module);
            quote!(use super::super::#module;)
        });
        let decided: Vec<TokenStream> = self
            .conversions
            .iter()
            .filter(|conversion| conversion.is_decided())
            .map(|conversion| self.conversion(conversion))
            .collect();
        let uses = (!decided.is_empty()).then(|| quote!(#(#uses)*));
        header(&format!("the definitions of {} and {}", self.names[0], self.names[1]))
            + &layout_file(quote!(#doc #uses #(#decided)*))
    }

    /// The documentation of the module.
    fn text(&self) -> String {
        let mut text =
            format!("Conversions from {} to {}.", prose::code(self.names[0]), prose::code(self.names[1]));
        let undecided: Vec<String> = self
            .conversions
            .iter()
            .filter(|conversion| !conversion.is_decided())
            .map(|conversion| prose::code(&self.context.schema.message(conversion.to).name))
            .collect();
        if !undecided.is_empty() {
            let _ = write!(
                text,
                "\n\nNot converted, because neither the definitions nor hints decide all parts: {}. `lint` lists the \
                 undecided parts.",
                undecided.join(", ")
            );
        }
        text
    }

    fn conversion(&self, conversion: &Conversion) -> TokenStream {
        let doc = documentation(&self.conversion_text(conversion));
        let (source, target) = (self.path(conversion.from, 0), self.path(conversion.to, 1));
        let fields = Fields { way: self, conversion };
        let values = fields.values();
        let reads = |step: &Step| match step {
            Step::Copy(_) => true,
            Step::Fill(_) => false,
            Step::Compute(expression) => {
                let mut has_field = false;
                expression.fields(&mut |_| has_field = true);
                has_field
            }
        };
        let argument = if conversion.steps.iter().any(reads) { quote!(from) } else { quote!(_) };
        quote! {
            #doc
            impl ::core::convert::From<&#source> for #target {
                fn from(#argument: &#source) -> Self {
                    Self { #(#values),* }
                }
            }
        }
    }

    fn conversion_text(&self, conversion: &Conversion) -> String {
        let schema = self.context.schema;
        let (source, target) = (schema.message(conversion.from), schema.message(conversion.to));
        let mut text = format!(
            "Converts {} of {} to {} of {}.",
            prose::code(&source.name),
            prose::code(self.names[0]),
            prose::code(&target.name),
            prose::code(self.names[1])
        );
        let of_kind = |is_wanted: fn(&Step) -> bool| -> Vec<String> {
            let steps = target.fields.iter().zip(&conversion.steps).filter(|(_, step)| is_wanted(step));
            steps.map(|(field, _)| prose::code(&field.name)).collect()
        };
        let filled = of_kind(|step| matches!(step, Step::Fill(_)));
        if !filled.is_empty() {
            let _ = write!(text, "\n\nFields with their neutral value: {}.", filled.join(", "));
        }
        let computed = of_kind(|step| matches!(step, Step::Compute(_)));
        if !computed.is_empty() {
            let _ = write!(text, "\n\nFields with a value from hints: {}.", computed.join(", "));
        }
        if !conversion.unchecked.is_empty() {
            let names = conversion.unchecked.iter().map(|field| prose::code(&target.fields[*field].name));
            let _ = write!(
                text,
                "\n\nFields whose valid values differ, so that the converted value may be invalid: {}.",
                names.collect::<Vec<_>>().join(", ")
            );
        }
        if conversion.losses.is_empty() {
            text += "\n\nNo data is lost.";
            return text;
        }
        text += "\n\nLost data:\n";
        for loss in &conversion.losses {
            let _ = write!(text, "\n- {}", loss.text);
        }
        text
    }
}

/// Allows lints that computed values from hints may violate.
fn allowed() -> TokenStream {
    quote! {
        // Allow these lints, because computed values are generated as the hints state them.
        #![allow(clippy::bool_comparison)]
        #![allow(clippy::cast_possible_truncation)]
        #![allow(clippy::cast_precision_loss)]
        #![allow(clippy::cast_sign_loss)]
        #![allow(clippy::eq_op)]
        #![allow(clippy::float_cmp)]
        #![allow(clippy::nonminimal_bool)]
        #![allow(clippy::overly_complex_bool_expr)]
        #![allow(clippy::too_many_lines)]
    }
}
