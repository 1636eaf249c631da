//! Languages of files.

/// The language of a file.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Language {
    /// Types and values together.
    TypeScript,
    /// Values, as an ECMAScript module.
    JavaScript,
    /// Values, as `CommonJS`.
    CommonJs,
    /// Types of what a `CommonJS` module exports.
    Declarations,
}

impl Language {
    pub(super) fn has_types(self) -> bool {
        matches!(self, Self::TypeScript | Self::Declarations)
    }

    pub(super) fn ending(self) -> &'static str {
        match self {
            Self::TypeScript => "ts",
            Self::JavaScript => "js",
            Self::CommonJs => "cjs",
            Self::Declarations => "d.cts",
        }
    }

    /// The ending by which other modules name it.
    pub(super) fn imported_ending(self) -> &'static str {
        match self {
            Self::TypeScript | Self::JavaScript => "js",
            Self::CommonJs | Self::Declarations => "cjs",
        }
    }
}
