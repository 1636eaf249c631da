//! Options of the emitter.

/// What the definitions don't say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Title of the book and of its first page.
    pub title: String,
    /// Whether the rules of uavspec itself are described, too.
    pub rules: bool,
    /// What stands at the end of the table of contents: a Markdown list of pages that others write.
    pub more_contents: String,
    /// The folders of what is generated beside the documentation, as seen from its own.
    pub beside: Beside,
}

/// Folders of other output, with `/` between the parts of their paths; none where there is no such output.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Beside {
    /// Of the JSON Schemas.
    pub schemas: Option<String>,
    /// Of the test vectors.
    pub vectors: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            title: "Interface definitions".to_owned(),
            rules: false,
            more_contents: String::new(),
            beside: Beside::default(),
        }
    }
}
