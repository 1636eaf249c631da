//! Attributes: annotations that describe a field in text and don't restrict its values.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_schema::msg::attribute::FRAME;
//!
//! assert_eq!(FRAME.name, "frame");
//! assert_eq!(schema.messages[0].fields[1].attribute(&FRAME), None);
//! ```

/// A kind of attribute. All stages handle attributes generically, using the data in this struct.
#[derive(Debug, PartialEq, Eq)]
pub struct Attribute {
    /// The name, as in `[@frame NED]`; also used in the printed model and in translation keys.
    pub name: &'static str,
    /// The syntax, as shown in messages.
    pub form: &'static str,
    /// Arguments that some definitions give without the attribute name, by mistake: `[NED]`.
    pub bare: &'static [&'static str],
    /// The text in the documentation. The name in braces is a placeholder for the argument. Translations use the
    /// English text as their key.
    pub words: &'static str,
    /// The keyword in JSON Schemas.
    pub keyword: &'static str,
}

/// All attributes, in the order of output.
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
    /// The text in the documentation, in English.
    pub fn to_text(&self, text: &str) -> String {
        self.words.replace(&format!("{{{}}}", self.name), text)
    }
}
