//! Comments become documentation: the header, the groups, and what is said of each declaration.

use crate::msg::Dialect;
use crate::msg::ast::{Comment, Line, Part};
use crate::source::Span;

/// A text with its first paragraph apart.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Docs {
    /// The first paragraph, on one line.
    pub summary: String,
    /// The other paragraphs, lines kept, a blank line between paragraphs.
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

    /// Summary and description as one text.
    pub fn text(&self) -> String {
        join([self.summary.as_str(), self.description.as_str()], "\n\n")
    }
}

/// Lines drawn from one character: `-----`, `#####`.
pub(crate) fn is_ruler(text: &str) -> bool {
    text.len() > 1 && text.bytes().all(|byte| matches!(byte, b'#' | b'-' | b'=' | b'*' | b'_' | b'/'))
}

fn join<'a>(texts: impl IntoIterator<Item = &'a str>, separator: &str) -> String {
    texts.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join(separator)
}

/// What the comments of a part say.
#[derive(Debug, Default)]
pub(crate) struct Commentary<'s> {
    /// Of the whole.
    pub(crate) docs: Docs,
    /// Headings of groups, in order.
    pub(crate) groups: Vec<Docs>,
    /// Of each declaration, in order.
    pub(crate) items: Vec<ItemDocs>,
    /// Topics, in the order in which they are listed.
    pub(crate) topics: Vec<(&'s str, Span)>,
}

/// What the comments say of a declaration.
#[derive(Debug, Default)]
pub(crate) struct ItemDocs {
    pub(crate) description: String,
    pub(crate) group: Option<usize>,
}

/// Reads all comments of a part.
pub(crate) fn read<'s>(part: &Part<'s>, dialect: Dialect) -> Commentary<'s> {
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
    if line.item.is_some() || line.is_broken { None } else { line.comment.as_deref() }
}

#[derive(Default)]
struct Reader<'s> {
    commentary: Commentary<'s>,
    /// Own-line comments since the last declaration or blank line.
    block: Vec<&'s str>,
    /// Whether a blank line stands before the block.
    is_block_apart: bool,
    is_after_blank: bool,
    group: Option<usize>,
    /// Whether the line before is a declaration, or continues its comment.
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

    /// An indented comment below a declaration goes on with the comment of that declaration.
    fn continue_comment(&mut self, comment: &Comment<'_>) {
        if let Some(item) = self.commentary.items.last_mut() {
            let text = comment.text.trim();
            if !item.description.is_empty() && !text.is_empty() {
                item.description.push(' ');
            }
            // In place: the comment may go on for any number of lines.
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

    /// Takes a line `# TOPICS a b` of a px4 message.
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

/// ROS writes what a declaration means above it: a heading of one declaration is no heading.
fn document_single_declarations(commentary: &mut Commentary<'_>) {
    let mut sizes = vec![0_usize; commentary.groups.len()];
    for group in commentary.items.iter().filter_map(|item| item.group) {
        sizes[group] += 1;
    }
    let mut kept = Vec::new();
    let new_index: Vec<Option<usize>> = sizes
        .iter()
        .zip(&commentary.groups)
        .map(|(size, group)| {
            (*size > 1).then(|| {
                kept.push(group.clone());
                kept.len() - 1
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
    commentary.groups = kept;
}
