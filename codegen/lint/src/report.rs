//! Machine-readable reports of findings, in several formats.
//!
//! The checks of definitions and the conformance suite both produce a [`Report`]. The formats are independent of spans
//! and rules.
//!
//! ```
//! use uavspec_schema::{diagnostic::Level, finding::Finding};
//! use uavspec_lint::report::{Entry, rule_url};
//! use uavspec_schema::{SourceMap, source::Span};
//!
//! let mut sources = SourceMap::default();
//! let id = sources.add("Wind.msg", "float32 speed\n".into()).unwrap();
//! let finding = Finding::new("unit-missing", Level::Warning, sources.span(id), "`speed` has no unit");
//! let entry = Entry::of(&finding, &sources);
//! assert_eq!((entry.place.path.as_str(), entry.url), ("Wind.msg", rule_url("unit-missing")));
//! ```

pub mod codequality;
mod fingerprint;
mod github;
mod json;
pub mod junit;
mod model;
pub mod sarif;
#[cfg(test)]
mod tests;
mod totals;

use uavspec_schema::json_text;

pub use self::model::{
    Entry, Format, Place, READING_PAGE, Region, Report, RuleInfo, rule_page, rule_url, site_url,
};
pub use self::totals::{RuleTotal, Totals};

impl Report {
    /// The report as text. A nonempty report ends with a newline.
    pub fn to_text(&self, format: Format) -> String {
        self.write(format, None)
    }

    /// Like [`to_text`](Self::to_text), with the totals of the run if the format has a place for them. JSON lists and
    /// `JUnit` XML have no such place.
    pub fn to_text_with_totals(&self, format: Format, totals: &Totals) -> String {
        self.write(format, Some(totals))
    }

    fn write(&self, format: Format, totals: Option<&Totals>) -> String {
        match format {
            Format::Json => json::write(self),
            Format::Github => github::write(self, totals),
            Format::Sarif => sarif::write(self, totals),
            Format::Codequality => codequality::write(self),
            Format::Junit => junit::of_findings(self),
        }
    }
}

impl Totals {
    /// The totals without findings, in a format. SARIF, `JUnit` and Code Quality reports can't contain only totals.
    pub fn to_summary(&self, format: Format) -> Option<String> {
        match format {
            Format::Json => Some(json_text::pretty(&self.to_json())),
            Format::Github => Some(github::summary(self)),
            Format::Sarif | Format::Codequality | Format::Junit => None,
        }
    }
}
