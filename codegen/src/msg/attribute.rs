//! Attributes: annotations whose text says more about a field, and restricts none of its values.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_codegen::msg::attribute::FRAME;
//!
//! assert_eq!(FRAME.name, "frame");
//! assert_eq!(schema.messages[0].fields[1].attribute(&FRAME), None);
//! ```

/// A kind of attribute. All stages treat attributes alike, by what stands here.
#[derive(Debug, PartialEq, Eq)]
pub struct Attribute {
    /// Its name, as in `[@frame NED]`. The printed model and the keys of translations use it, too.
    pub name: &'static str,
    /// Its form, as messages show it.
    pub form: &'static str,
    /// Texts that definitions put between brackets by mistake, without the name: `[NED]`.
    pub bare: &'static [&'static str],
    /// The words of the documentation, with the text in place of the name between braces. Translations of the
    /// generator's words have an entry for them.
    pub words: &'static str,
    /// The keyword of JSON Schemas.
    pub keyword: &'static str,
}

/// All attributes, in the order in which they are written and documented.
pub static ATTRIBUTES: &[&Attribute] = &[&FRAME];

/// The coordinate frame.
pub static FRAME: Attribute = Attribute {
    name: "frame",
    form: "[@frame name]",
    bare: &["NED", "ENU", "FRD", "FLU", "NWU", "ECEF", "Body", "body"],
    words: "frame: {frame}",
    keyword: "x-frame",
};

impl Attribute {
    /// The words of the documentation, in English.
    pub(crate) fn said(&self, text: &str) -> String {
        self.words.replace(&format!("{{{}}}", self.name), text)
    }
}
