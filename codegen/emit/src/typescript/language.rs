//! The languages of generated files.

/// The language of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Language {
    /// TypeScript: types and values.
    TypeScript,
    /// JavaScript: values as an ECMAScript module.
    JavaScript,
    /// JavaScript: values as a `CommonJS` module.
    CommonJs,
    /// TypeScript declarations of a `CommonJS` module.
    Declarations,
}

impl Language {
    pub(super) fn has_types(self) -> bool {
        matches!(self, Self::TypeScript | Self::Declarations)
    }

    pub(super) fn extension(self) -> &'static str {
        match self {
            Self::TypeScript => "ts",
            Self::JavaScript => "js",
            Self::CommonJs => "cjs",
            Self::Declarations => "d.cts",
        }
    }

    /// The file extension used to import this file from other modules.
    pub(super) fn imported_extension(self) -> &'static str {
        match self {
            Self::TypeScript | Self::JavaScript => "js",
            Self::CommonJs | Self::Declarations => "cjs",
        }
    }
}
