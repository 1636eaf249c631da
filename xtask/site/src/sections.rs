//! Sections of documents that are too long for one page.

use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag};

use crate::chapters::Chapter;

/// Returns the text of a chapter: the document, or one section of it with its headings raised by one level. The lines
/// before the section are empty, so that line numbers stay the same.
pub(crate) fn of(document: &str, chapter: &Chapter) -> Result<String, String> {
    if chapter.section.is_empty() {
        return Ok(document.to_owned());
    }
    let headings: Vec<(HeadingLevel, usize)> = Parser::new_ext(document, Options::ENABLE_TABLES)
        .into_offset_iter()
        .filter_map(|(event, range)| match event {
            Event::Start(Tag::Heading { level, .. }) => Some((level, range.start)),
            _ => None,
        })
        .collect();
    let is_wanted = |(level, at): &(HeadingLevel, usize)| {
        *level == HeadingLevel::H2
            && document[*at..].lines().next().and_then(|line| line.strip_prefix("## "))
                == Some(chapter.section)
    };
    let Some(first) = headings.iter().position(is_wanted) else {
        return Err(format!("{}: has no section `{}`", chapter.source, chapter.section));
    };
    let below = headings[first + 1..].iter().take_while(|(level, _)| *level > HeadingLevel::H2);
    let below: Vec<usize> = below.map(|(_, at)| *at).collect();
    let end = headings.get(first + 1 + below.len()).map_or(document.len(), |(_, at)| *at);
    let mut text = "\n".repeat(document[..headings[first].1].matches('\n').count());
    let mut done = headings[first].1;
    for at in below {
        text.push_str(raised(&document[done..at]));
        done = at;
    }
    text.push_str(raised(&document[done..end]));
    Ok(text)
}

/// Removes one level from the heading at the start of the text.
fn raised(text: &str) -> &str {
    text.strip_prefix('#').unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chapters::START;

    const DOCUMENT: &str = "# Kite\n\n## Fly\n\n```console\n## wind\n```\n\n### High\n\nText.\n\n## Land\n";

    fn section(section: &'static str) -> Result<String, String> {
        of(DOCUMENT, &Chapter { section, ..START })
    }

    #[test]
    fn a_section_keeps_its_lines_and_becomes_a_page() {
        assert_eq!(section("").as_deref(), Ok(DOCUMENT));
        let page = "\n\n# Fly\n\n```console\n## wind\n```\n\n## High\n\nText.\n\n";
        assert_eq!(section("Fly").as_deref(), Ok(page));
        assert_eq!(section("Land"), Ok("\n".repeat(12) + "# Land\n"));
    }

    #[test]
    fn a_missing_section_is_an_error() {
        let error = format!("{}: has no section `wind`", START.source);
        assert_eq!(section("wind"), Err(error));
    }
}
