//! Options of the emitter.

use uavspec_lint::release::Releases;

/// Options that the definitions don't determine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// Title of the book and of its first page.
    pub title: String,
    /// True to include pages about the rules of uavspec.
    pub rules: bool,
    /// Markdown list of additional pages, appended to the table of contents.
    pub more_contents: String,
    /// Folders of the other outputs, relative to the documentation.
    pub siblings: Siblings,
    /// The releases of the packages. Pages show the history of each definition in these releases.
    pub releases: Releases,
}

/// Folders of other outputs, with `/` as the path separator. `None` means that this output is not generated.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Siblings {
    /// JSON Schemas.
    pub schemas: Option<String>,
    /// Test vectors.
    pub vectors: Option<String>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            title: "Interface definitions".to_owned(),
            rules: false,
            more_contents: String::new(),
            siblings: Siblings::default(),
            releases: Releases::new(),
        }
    }
}
