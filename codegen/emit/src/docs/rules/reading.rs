//! The parser errors. Parser errors are not rules: if a definition has errors, nothing is generated.

use std::fmt::Write as _;

use uavspec_lint::report::READING_PAGE;
use uavspec_schema::diagnostic::{Problem, ProblemKind};

use super::chapter::{OVERVIEW, rule_link};
use crate::docs::markdown::{Page, code, href, link, with_code};
use crate::file::OutputFile;

/// Heading of the page.
pub(super) const TITLE: &str = "Parser errors";

pub(super) fn path() -> String {
    format!("rules/{READING_PAGE}.md")
}

pub(super) fn page() -> OutputFile {
    let path = path();
    let mut page = Page::new(&path, TITLE);
    let rules = link("rules", &href(&path, OVERVIEW, ""));
    page.block(&format!(
        "uavspec generates no output from a definition with one of these errors. The errors can't be \
         ignored. Words in braces are placeholders. Parser warnings are listed among the {rules}."
    ));
    // Only codes that are also rules have a separate page.
    let (rules, others): (Vec<&ProblemKind>, Vec<&ProblemKind>) =
        Problem::KINDS.iter().partition(|kind| uavspec_lint::rule(kind.code).is_some());
    for kind in others {
        // URLs point to the anchor of this heading, which GitHub and mdBook derive from the text.
        page.heading(2, &code(kind.code));
        page.gap();
        page.item(0, &format!("{}: {}", kind.level.name(), with_code(&template(kind.message))));
        page.item(0, &format!("help: {}", with_code(&template(kind.hint))));
    }
    page.heading(2, "Warnings");
    page.gap();
    for kind in rules {
        page.item(0, &rule_link(&path, kind.code));
    }
    page.finish()
}

/// Removes the format specifications from a template: `{byte:02x}` becomes `{byte}`.
fn template(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('{') {
        let (field, after) = after.split_once('}').unwrap_or((after, ""));
        let name = field.split_once(':').map_or(field, |(name, _)| name).replace('_', " ");
        // Writing to a `String` can't fail.
        let _ = write!(shown, "{before}{{{name}}}");
        rest = after;
    }
    shown + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn templates_have_no_format_specifications() {
        assert_eq!(template("0x{byte:02x} of `{type_name}`"), "0x{byte} of `{type name}`");
        assert_eq!(template("none"), "none");
    }
}
