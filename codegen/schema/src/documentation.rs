//! Extracts documentation from comments: the header, groups and declarations.

use crate::msg::Dialect;
use crate::msg::ast::{Comment, Line, Part};
use crate::source::Span;

/// A text, split into a summary and a description.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Docs {
    /// The first paragraph, on one line.
    pub summary: String,
    /// The other paragraphs, with line breaks, separated by empty lines.
    pub description: String,
}

impl Docs {
    fn from_lines(lines: &[&str]) -> Self {
        let mut paragraphs: Vec<Vec<&str>> = vec![Vec::new()];
        for line in lines {
            let text = line.strip_prefix(' ').unwrap_or(line).trim_end();
            if text.is_empty() {
                paragraphs.push(Vec::new());
            } else if let Some(paragraph) = paragraphs.last_mut().filter(|_| !is_ruler(text)) {
                paragraph.push(text);
            }
        }
        paragraphs.retain(|paragraph| !paragraph.is_empty());
        let Some((first, rest)) = paragraphs.split_first() else { return Self::default() };
        let summary = first.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
        let description = rest.iter().map(|paragraph| paragraph.join("\n")).collect::<Vec<_>>().join("\n\n");
        Self { summary, description }
    }

    /// The summary and the description as one text.
    pub fn text(&self) -> String {
        join([self.summary.as_str(), self.description.as_str()], "\n\n")
    }
}

/// True for lines that repeat one character: `-----`, `#####`.
pub fn is_ruler(text: &str) -> bool {
    text.len() > 1 && text.bytes().all(|byte| matches!(byte, b'#' | b'-' | b'=' | b'*' | b'_' | b'/'))
}

fn join<'a>(texts: impl IntoIterator<Item = &'a str>, separator: &str) -> String {
    texts.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join(separator)
}

/// The documentation in the comments of a part.
#[derive(Debug, Default)]
pub struct Commentary<'s> {
    /// The documentation of the part.
    pub docs: Docs,
    /// The headings of groups, in order.
    pub groups: Vec<Docs>,
    /// The documentation of each declaration, in order.
    pub items: Vec<ItemDocs>,
    /// The topics, in the listed order.
    pub topics: Vec<(&'s str, Span)>,
}

/// The documentation of a declaration.
#[derive(Debug, Default)]
pub struct ItemDocs {
    /// The text.
    pub description: String,
    /// The index of the group, if the declaration belongs to one.
    pub group: Option<usize>,
}

/// Reads all comments of a part.
pub fn read<'s>(part: &Part<'s>, dialect: Dialect) -> Commentary<'s> {
    let mut reader = Reader::default();
    let header_len = part.lines.iter().take_while(|line| own_comment(line).is_some()).count();
    let (header, body) = part.lines.split_at(header_len);
    let mut header_texts = Vec::new();
    for comment in header.iter().filter_map(own_comment).filter(|comment| !comment.is_directive()) {
        if !reader.topics(comment, dialect) {
            header_texts.push(comment.text);
        }
    }
    reader.commentary.docs = Docs::from_lines(&header_texts);
    for line in body {
        reader.line(line, dialect);
    }
    let mut commentary = reader.commentary;
    if dialect == Dialect::Ros2 {
        document_single_declarations(&mut commentary);
    }
    commentary
}

fn own_comment<'l, 's>(line: &'l Line<'s>) -> Option<&'l Comment<'s>> {
    if line.item.is_some() || line.is_invalid { None } else { line.comment.as_deref() }
}

#[derive(Default)]
struct Reader<'s> {
    commentary: Commentary<'s>,
    /// Comments on separate lines since the last declaration or empty line.
    block: Vec<&'s str>,
    /// True if the block follows an empty line.
    is_block_apart: bool,
    is_after_blank: bool,
    group: Option<usize>,
    /// True if the previous line is a declaration or continues a declaration's comment.
    is_after_item: bool,
}

impl<'s> Reader<'s> {
    fn line(&mut self, line: &Line<'s>, dialect: Dialect) {
        if line.is_blank() {
            self.block.clear();
            self.group = None;
            self.is_after_item = false;
            self.is_after_blank = true;
            return;
        }
        match own_comment(line) {
            Some(comment) if comment.is_directive() => return,
            Some(comment) if self.topics(comment, dialect) => {}
            Some(comment) if self.is_after_item && comment.column > 0 => self.continue_comment(comment),
            Some(comment) => {
                if self.block.is_empty() {
                    self.is_block_apart = self.is_after_blank;
                }
                self.block.push(comment.text);
                self.is_after_item = false;
            }
            None if line.item.is_some() => self.item(line),
            None => self.block.clear(),
        }
        self.is_after_blank = false;
    }

    /// Appends an indented comment line to the comment of the declaration above.
    fn continue_comment(&mut self, comment: &Comment<'_>) {
        if let Some(item) = self.commentary.items.last_mut() {
            let text = comment.text.trim();
            if !item.description.is_empty() && !text.is_empty() {
                item.description.push(' ');
            }
            // Append in place, because the comment may have any number of lines.
            item.description.push_str(text);
        }
    }

    fn item(&mut self, line: &Line<'s>) {
        let block = Docs::from_lines(&std::mem::take(&mut self.block));
        let mut lead = String::new();
        if !block.summary.is_empty() {
            if self.is_block_apart {
                self.group = Some(self.commentary.groups.len());
                self.commentary.groups.push(block);
            } else {
                lead = block.text();
            }
        }
        let note = line.comment.as_ref().and_then(|comment| comment.note.as_ref());
        let trailing = note.map_or("", |note| note.text.as_ref());
        self.commentary
            .items
            .push(ItemDocs { description: join([trailing, &lead], "\n\n"), group: self.group });
        self.is_after_item = true;
    }

    /// Reads a line `# TOPICS a b` of a PX4 message. Returns true if the comment is such a line.
    fn topics(&mut self, comment: &Comment<'s>, dialect: Dialect) -> bool {
        let Some(list) =
            comment.text.strip_prefix(" TOPICS ").filter(|_| dialect == Dialect::Px4 && comment.column == 0)
        else {
            return false;
        };
        let mut at = comment.text.len() - list.len() + 1;
        for word in list.split([' ', '\t']) {
            if !word.is_empty() {
                self.commentary.topics.push((word, comment.span.part(at..at + word.len())));
            }
            at += word.len() + 1;
        }
        true
    }
}

/// If a group contains a single declaration, moves the group's heading to the description of the declaration. ROS puts
/// descriptions above declarations.
fn document_single_declarations(commentary: &mut Commentary<'_>) {
    let mut sizes = vec![0_usize; commentary.groups.len()];
    for group in commentary.items.iter().filter_map(|item| item.group) {
        sizes[group] += 1;
    }
    let mut remaining = Vec::new();
    let new_index: Vec<Option<usize>> = sizes
        .iter()
        .zip(&commentary.groups)
        .map(|(size, group)| {
            (*size > 1).then(|| {
                remaining.push(group.clone());
                remaining.len() - 1
            })
        })
        .collect();
    for item in &mut commentary.items {
        let Some(group) = item.group else { continue };
        if new_index[group].is_none() {
            let above = commentary.groups[group].text();
            item.description = join([above.as_str(), item.description.as_str()], "\n\n");
        }
        item.group = new_index[group];
    }
    commentary.groups = remaining;
}
