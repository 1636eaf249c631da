//! The fuzz targets for inputs whose parsers are private. A function reads arbitrary bytes, and panics if a property
//! does not hold. `cargo xtask fuzz` runs the functions.

use std::path::Path;

use crate::cli;
use crate::load::Config;
use crate::source::{SourceMap, Span};
use crate::translation::catalogue;

/// Reads `uavspec.toml`. An error must name a line of the file.
pub fn configuration(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = Path::new("uavspec.toml");
    let Err(failure) = Config::parse(path, text.to_owned()).and_then(Config::plan) else { return };
    let failure = failure.to_string();
    let line = failure.split_once("uavspec.toml:").and_then(|(_, rest)| rest.split(':').next()?.parse().ok());
    let lines = text.split('\n').count();
    assert!(line.is_none_or(|line: usize| (1..=lines).contains(&line)), "{lines} lines: {failure}");
}

/// Reads a translation catalogue. A catalogue without problems must stay the same if it is printed and read again.
pub fn translations(data: &[u8]) {
    let Some((read, is_correct)) = read_catalogue(data.to_vec()) else { return };
    if !is_correct {
        return;
    }
    let printed = catalogue::print(&read);
    let again = read_catalogue(printed.clone().into_bytes());
    assert_eq!(again, Some((read, true)), "{printed}");
}

/// The catalogue, and true if it has no problems.
fn read_catalogue(data: Vec<u8>) -> Option<(catalogue::Catalogue, bool)> {
    let mut sources = SourceMap::default();
    let id = sources.add("uk.po", data).ok()?;
    let (read, places, diagnostics) = catalogue::parse(&sources, id);
    assert_eq!(read.entries.len(), places.len());
    for diagnostic in &diagnostics {
        check_span(&sources, diagnostic.span);
    }
    Some((read, diagnostics.is_empty()))
}

/// Reads a list of known findings. If nothing is found, all entries are outdated, and the fixed list must be empty.
pub fn known_findings(data: &[u8]) {
    let Ok(fixed) = cli::without_findings(data.to_vec()) else { return };
    let again = cli::without_findings(fixed.clone().into_bytes());
    let again = again.unwrap_or_else(|failure| panic!("the fixed list is invalid: {failure}\n{fixed}"));
    assert_eq!(again, fixed, "a second fix changes the list");
}

/// A span must be within its source, and must not split a character.
fn check_span(sources: &SourceMap, span: Span) {
    let whole = sources.span(sources.source_of(span));
    assert!(whole.start <= span.start && span.end <= whole.end, "{span:?} in {whole:?}");
    // Panics within a character.
    let _ = sources.slice(span);
}

#[cfg(test)]
mod tests {
    use super::{configuration, known_findings, translations};

    #[test]
    fn the_properties_hold_for_correct_and_truncated_files() {
        let config = "[output]\nrust = \"out\"\n\n[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
        let list = "# list\n\n[[known]]\nrule = \"unit-missing\"\nsubject = \"px4/*\"\ncount = 1\nreason = \"old\"\n";
        let catalogue = "# note\nmsgid \"\"\nmsgstr \"\"\n\"Language: uk\\n\"\n\n#, fuzzy\nmsgctxt \"a\"\nmsgid \"b\"\nmsgstr \"c\"\n";
        for (check, text) in
            [(configuration as fn(&[u8]), config), (known_findings, list), (translations, catalogue)]
        {
            for end in 0..=text.len() {
                check(&text.as_bytes()[..end]);
            }
        }
    }
}
