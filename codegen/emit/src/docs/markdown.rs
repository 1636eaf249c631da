//! Markdown building blocks of pages: headings, paragraphs, tables, links.
//!
//! The building blocks are public, so other generators can produce pages with the same look.
//!
//! ```
//! use uavspec_emit::docs::markdown::{Page, Table, code, text_column};
//!
//! let mut table = Table::new(&[text_column("Field"), text_column("Type")]);
//! table.row([code("speed"), code("float32")]);
//! let mut page = Page::with_notice("Made by hand.", "wind.md", "Wind");
//! page.table(&table);
//! assert!(page.finish().text.ends_with("| `speed` | `float32` |\n"));
//! ```

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

use uavspec_schema::prose;
pub(super) use uavspec_schema::prose::gist;
use uavspec_schema::prose::percent_encoded;
use uavspec_schema::terminal::shown;

use crate::file::{self, OutputFile};

/// A page under construction.
#[derive(Debug)]
pub struct Page {
    path: String,
    text: String,
    /// Text appended at the end.
    end: &'static str,
    /// For each English anchor, the number of translated headings that already use it.
    headings: BTreeMap<String, usize>,
}

impl Page {
    /// Creates a page with its main heading, given as Markdown.
    pub(super) fn new(path: &str, heading: &str) -> Self {
        Self::with_notice(&notice(), path, heading)
    }

    /// Creates a page with a notice in a comment, and a main heading in Markdown.
    pub fn with_notice(notice: &str, path: &str, heading: &str) -> Self {
        let mut page = Self::empty(notice, path);
        page.heading(1, heading);
        page
    }

    /// Creates a page without a heading.
    pub(super) fn without_heading(path: &str) -> Self {
        Self::empty(&notice(), path)
    }

    /// Encloses the rest of the page in an element with these attributes, which set the language.
    pub(super) fn begin_language(&mut self, attributes: &str) {
        // The blank line ends the HTML block, so Markdown can follow.
        self.put(format_args!("\n<div {attributes}>\n"));
        self.end = "\n</div>\n";
    }

    fn empty(notice: &str, path: &str) -> Self {
        let text = format!("<!-- {notice} -->\n");
        Self { path: path.to_owned(), text, end: "", headings: BTreeMap::new() }
    }

    /// Adds a heading, given as Markdown.
    pub fn heading(&mut self, level: usize, heading: &str) {
        // Escape a trailing `#`, which would be parsed as a closing sequence.
        let (heading, end) = heading.strip_suffix('#').map_or((heading, ""), |start| (start, "\\#"));
        self.put(format_args!("\n{:#<level$} {heading}{end}\n", ""));
    }

    /// Adds a translated heading, given as Markdown, with the anchor of the English heading.
    pub(super) fn heading_for(&mut self, level: usize, heading: &str, english: &str) {
        let id = heading_anchor(english);
        // mdBook and GitHub append a number to repeated headings, starting with the second one.
        let known = self.headings.entry(id.clone()).or_default();
        let number = std::mem::replace(known, *known + 1);
        self.anchor(&if number == 0 { id } else { format!("{id}-{number}") });
        self.heading(level, heading);
    }

    /// Adds an anchor before a heading. The anchor is a separate block, because mdBook turns each heading into a link,
    /// and links can't be nested.
    pub(super) fn anchor(&mut self, id: &str) {
        self.put(format_args!("\n{}\n", anchor(id)));
    }

    /// Adds a paragraph or another block, given as Markdown. An empty block is skipped.
    pub fn block(&mut self, markdown: &str) {
        if !markdown.is_empty() {
            self.put(format_args!("\n{markdown}\n"));
        }
    }

    /// Adds lines verbatim in a code block. Invisible characters become U+FFFD.
    pub fn listing(&mut self, text: &str) {
        let longest = text.split(|character| character != '`').map(str::len).max().unwrap_or(0);
        let fence = "`".repeat(longest.max(2) + 1);
        self.put(format_args!("\n{fence}text\n"));
        for line in text.lines() {
            let line = line
                .chars()
                .map(|character| if character == '\t' { '\t' } else { prose::visible(character) });
            self.text.extend(line);
            self.gap();
        }
        self.put(format_args!("{fence}\n"));
    }

    /// Adds a list item, given as Markdown.
    pub fn item(&mut self, depth: usize, markdown: &str) {
        self.put(format_args!("{:depth$}- {markdown}\n", "", depth = 2 * depth));
    }

    /// Adds a blank line, for example before a list.
    pub fn gap(&mut self) {
        self.text.push('\n');
    }

    /// Adds a table without its empty columns. Skips a table that has no rows.
    pub fn table(&mut self, table: &Table) {
        if table.is_empty() {
            return;
        }
        let columns = table.used_columns();
        self.gap();
        self.row(columns.iter().map(|column| table.columns[*column].heading));
        self.row(columns.iter().map(|column| table.columns[*column].rule()));
        for row in &table.rows {
            self.row(columns.iter().map(|column| row.get(*column).map_or("", String::as_str)));
        }
    }

    fn row<'c>(&mut self, cells: impl Iterator<Item = &'c str>) {
        self.text.push('|');
        for cell in cells {
            self.text.push(' ');
            self.text.push_str(cell);
            self.text.push_str(" |");
        }
        self.gap();
    }

    fn put(&mut self, text: fmt::Arguments<'_>) {
        append(&mut self.text, text);
    }

    /// Finishes the page.
    pub fn finish(self) -> OutputFile {
        OutputFile { path: self.path, text: self.text + self.end }
    }
}

/// The notice for the start of every file, without comment delimiters.
pub(super) fn notice() -> String {
    file::notice("the definitions")
}

/// Appends formatted text.
pub(super) fn append(to: &mut String, text: fmt::Arguments<'_>) {
    // Writing to a `String` never fails.
    let _ = to.write_fmt(text);
}

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    heading: &'static str,
    is_number: bool,
}

impl Column {
    fn rule(self) -> &'static str {
        if self.is_number { "---:" } else { "---" }
    }
}

/// A column of text.
pub const fn text_column(heading: &'static str) -> Column {
    Column { heading, is_number: false }
}

/// A column of numbers, aligned to the right.
pub const fn number_column(heading: &'static str) -> Column {
    Column { heading, is_number: true }
}

/// A table, whose cells are Markdown.
#[derive(Clone, Debug)]
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates a table without rows.
    pub fn new(columns: &[Column]) -> Self {
        Self { columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// True if the table has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The indexes of the first column and of all columns with at least one nonempty cell.
    fn used_columns(&self) -> Vec<usize> {
        let has_content =
            |column: usize| self.rows.iter().any(|row| row.get(column).is_some_and(|cell| !cell.is_empty()));
        (0..self.columns.len()).filter(|column| *column == 0 || has_content(*column)).collect()
    }

    /// Splits the rows into tables of the given `lengths`.
    pub fn split(self, lengths: impl IntoIterator<Item = usize>) -> Vec<Self> {
        let mut rows = self.rows.into_iter();
        let part =
            |length| Self { columns: self.columns.clone(), rows: rows.by_ref().take(length).collect() };
        lengths.into_iter().map(part).collect()
    }
}

/// Escapes definition text for use on one line.
///
/// Braces are escaped too, because mdBook and GitHub Pages use them in templates, and mdBook uses them in heading
/// attributes.
pub fn inline(text: &str) -> String {
    let escaped = prose::inline(text);
    if escaped.contains('{') { escaped.replace('{', "&#123;") } else { escaped }
}

/// Escapes text for use on one line. The text may contain code in backticks.
pub fn with_code(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        // An unpaired backtick is plain text.
        return inline(text);
    }
    let mut markdown = String::with_capacity(text.len());
    for (index, part) in parts.into_iter().enumerate() {
        if index % 2 == 1 {
            markdown.push_str(&code(part));
            continue;
        }
        // `inline` trims its text, so restore the spaces next to code.
        let (start, end) = (part.len() - part.trim_start().len(), part.trim_end().len());
        markdown.push_str(if start > 0 { " " } else { "" });
        markdown.push_str(&inline(part));
        markdown.push_str(if start < end && end < part.len() { " " } else { "" });
    }
    markdown.trim().to_owned()
}

/// Escapes untrusted text for use on one line of a comment or an issue.
///
/// GitHub and GitLab turn mentions, references to issues, commit hashes, addresses and emoji names into links or images,
/// whether or not they are escaped. Only code is exempt, so words with such a reference become code.
///
/// ```
/// use uavspec_emit::docs::markdown::untrusted;
///
/// assert_eq!(untrusted("see #1 of @everyone *now*"), r"see `#1` of `@everyone` \*now\*");
/// ```
pub fn untrusted(text: &str) -> String {
    let text = shown(text);
    let words: Vec<&str> = text.split(' ').filter(|word| !word.is_empty()).collect();
    let runs = words.chunk_by(|left, right| !is_reference(left) && !is_reference(right));
    let markdown = runs.map(|run| match run {
        [word] if is_reference(word) => code(word),
        words => inline(&words.join(" ")),
    });
    markdown.collect::<Vec<_>>().join(" ")
}

/// True if GitHub or GitLab would find a reference in a word.
fn is_reference(word: &str) -> bool {
    let lower = word.to_ascii_lowercase();
    let follows = |mark: &str, is_wanted: fn(char) -> bool| {
        lower.match_indices(mark).any(|(at, _)| lower[at + mark.len()..].starts_with(is_wanted))
    };
    let is_hash =
        |part: &str| (7..=64).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_hexdigit());
    lower.contains('@')
        || lower.contains("://")
        || lower.contains("www.")
        || ["#", "!", "%", "~", "&", "$", "^"].iter().any(|mark| follows(mark, char::is_alphanumeric))
        || follows("gh-", char::is_numeric)
        || lower.split(|character: char| !character.is_ascii_alphanumeric()).any(is_hash)
        || has_emoji(&lower)
}

/// True if a word contains the name of an emoji, such as `:tada:`.
fn has_emoji(word: &str) -> bool {
    let is_name = |part: &str| {
        part.bytes().any(|byte| byte.is_ascii_alphabetic())
            && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'+' | b'-'))
    };
    let parts: Vec<&str> = word.split(':').collect();
    // Only the parts between two colons are names.
    parts.len() > 2 && parts[1..parts.len() - 1].iter().any(|part| is_name(part))
}

/// Prevents line breaks in Markdown text.
pub(super) fn unbroken(markdown: &str) -> String {
    markdown.replace(' ', "&nbsp;")
}

/// Formats a name or value as code, also inside tables.
pub fn code(text: &str) -> String {
    // Don't use backticks if a character is special in tables or templates even inside backticks.
    if !text.is_empty()
        && text.bytes().all(|byte| matches!(byte, b' '..=b'~') && !matches!(byte, b'`' | b'|' | b'{'))
    {
        return format!("`{text}`");
    }
    let mut escaped = String::from("<code>");
    for character in prose::xml(text).chars() {
        match character {
            // These characters are part of an entity, or harmless.
            '&' | ';' | '#' | ' ' => escaped.push(character),
            _ if character.is_alphanumeric() => escaped.push(character),
            _ => append(&mut escaped, format_args!("&#{};", u32::from(character))),
        }
    }
    escaped + "</code>"
}

/// Creates a link. The text is Markdown.
pub fn link(markdown: &str, href: &str) -> String {
    format!("[{markdown}]({href})")
}

/// Creates an inline anchor.
pub(super) fn anchor(id: &str) -> String {
    format!("<a id=\"{}\"></a>", prose::xml(id))
}

/// The anchor that mdBook and GitHub assign to a plain-text heading.
pub(super) fn heading_anchor(text: &str) -> String {
    let characters = text.trim().chars().filter_map(|character| match character {
        _ if character.is_alphanumeric() || matches!(character, '_' | '-') => Some(character),
        _ if character.is_whitespace() => Some('-'),
        _ => None,
    });
    characters.collect::<String>().to_lowercase()
}

/// The URL of the page `to`, or of an anchor on that page, relative to the page `from`.
pub fn href(from: &str, to: &str, anchor: &str) -> String {
    let mark = if anchor.is_empty() { "" } else { "#" };
    if from == to && !anchor.is_empty() {
        return format!("#{}", percent_encoded(anchor));
    }
    let shared = from.bytes().zip(to.bytes()).take_while(|(left, right)| left == right).count();
    let folder = from.as_bytes()[..shared].iter().rposition(|byte| *byte == b'/').map_or(0, |at| at + 1);
    let up = "../".repeat(from[folder..].matches('/').count());
    format!("{up}{}{mark}{}", percent_encoded(&to[folder..]), percent_encoded(anchor))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_relative_to_the_page() {
        for (from, to, anchor, expected) in [
            ("README.md", "px4/A.md", "", "px4/A.md"),
            ("px4/A.md", "px4/AB.md", "field-x", "AB.md#field-x"),
            ("px4/A.md", "px4/A.md", "field-x", "#field-x"),
            ("px4/A.md", "px5/A.md", "", "../px5/A.md"),
            ("a/error-codes/w.md", "a/error-codes.md", "code-1", "../error-codes.md#code-1"),
            ("a/error-codes/w.md", "README.md", "", "../../README.md"),
            ("README.md", "a (b)/x.md", "", "a%20%28b%29/x.md"),
        ] {
            assert_eq!(href(from, to, anchor), expected, "{from} to {to}");
        }
    }

    #[test]
    fn formats_text_between_backticks_as_code() {
        assert_eq!(
            with_code("`a|b` is *no* `{c}`, but `d`"),
            r"<code>a&#124;b</code> is \*no\* <code>&#123;c&#125;</code>, but `d`"
        );
        assert_eq!(with_code("a ` b"), r"a \` b");
        assert_eq!(with_code("`a` `b`"), "`a` `b`");
    }

    #[test]
    fn references_in_untrusted_text_become_code() {
        for word in [
            "@everyone",
            "(@a/team)",
            "a@b.org",
            "#1",
            "a/b#1",
            "GH-12",
            "gh-1",
            "!7",
            "%2",
            "&3",
            "~label",
            "$4",
            "^5",
            "https://a.b",
            "ftp://a",
            "WWW.a.b",
            "1234567",
            "(0123abcdef)",
            "a:tada:b",
            "x@0123abcdef",
        ] {
            assert_eq!(untrusted(&format!("a {word} b")), format!("a {} b", code(word)));
        }
        for text in ["1,234,567", "08:00:00", "50 %, 1 # 2", "a: b: c", "PX-RANGE-01", "a!", "decade"] {
            assert_eq!(untrusted(text), text);
        }
        assert_eq!(untrusted("a\n<b>  #1"), r"a\\n\<b\> `#1`");
        assert_eq!(untrusted(""), "");
    }

    #[test]
    fn uses_a_longer_fence_than_any_in_the_listing() {
        let mut page = Page::new("p.md", "P");
        page.listing("a\n```\n\tb \u{7}\n");
        assert!(page.finish().text.ends_with("\n````text\na\n```\n\tb \u{fffd}\n````\n"));
    }

    #[test]
    fn escapes_code_for_tables_and_templates() {
        assert_eq!(code("uint8[<=4]"), "`uint8[<=4]`");
        assert_eq!(code("a|b"), "<code>a&#124;b</code>");
        assert_eq!(code("{{#include `x`}}"), "<code>&#123;&#123;#include &#96;x&#96;&#125;&#125;</code>");
        assert_eq!(code("<b>&"), "`<b>&`");
        assert_eq!(code("|<b>"), "<code>&#124;&lt;b&gt;</code>");
    }

    #[test]
    fn drops_empty_columns() {
        let mut table = Table::new(&[text_column("A"), number_column("B"), number_column("C")]);
        table.row(["x".to_owned(), String::new(), "1".to_owned()]);
        table.row(["y".to_owned()]);
        let mut page = Page::new("p.md", "P");
        page.table(&table);
        assert!(page.finish().text.ends_with("\n| A | C |\n| --- | ---: |\n| x | 1 |\n| y |  |\n"));
    }

    #[test]
    fn derives_anchors_from_headings() {
        assert_eq!(heading_anchor("Per-mode requirements (RC, GPS)"), "per-mode-requirements-rc-gps");
    }
}
