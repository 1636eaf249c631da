//! Converts inline `AsciiDoc` markup to plain text.

use crate::table::text::TextBuilder;

/// A line and its position.
pub(super) type Line<'s> = (usize, &'s str);

/// Attributes for special characters in cells, and their values.
const ATTRIBUTES: [(&str, &str); 6] =
    [("{vbar}", "|"), ("{nbsp}", " "), ("{sp}", " "), ("{empty}", ""), ("{plus}", "+"), ("{asterisk}", "*")];

/// The starts of links. The link text follows in brackets.
const LINKS: [&str; 5] = ["link:", "xref:", "https://", "http://", "mailto:"];

/// Marks of bold, italic and monospaced text.
const MARKS: [char; 3] = ['*', '_', '`'];

/// Adds the text of `stretches` to `builder`. Each stretch has a position on the page.
pub(super) fn push(stretches: &[Line<'_>], builder: &mut TextBuilder) {
    let mut tokens = Vec::new();
    for (at, text) in stretches {
        Scanner { text, page_at: *at, at: 0, tokens: &mut tokens }.scan();
        tokens.push(Token { at: *at + text.len(), text: "\n", mark: None });
    }
    drop_pairs(&mut tokens);
    for token in tokens {
        builder.push(token.text, token.at);
    }
}

struct Token<'s> {
    at: usize,
    text: &'s str,
    mark: Option<Mark>,
}

#[derive(Clone, Copy)]
struct Mark {
    /// The index in [`MARKS`], and a flag that is true for a doubled mark. Only two marks of the same kind form a pair.
    kind: (usize, bool),
    can_open: bool,
    can_close: bool,
}

/// Removes paired marks. An unpaired mark is ordinary text.
fn drop_pairs(tokens: &mut [Token<'_>]) {
    let mut open = [[None; 2]; MARKS.len()];
    for index in 0..tokens.len() {
        let Some(mark) = tokens[index].mark else { continue };
        let opener: &mut Option<usize> = &mut open[mark.kind.0][usize::from(mark.kind.1)];
        match opener.filter(|_| mark.can_close) {
            Some(start) => {
                tokens[start].text = "";
                tokens[index].text = "";
                *opener = None;
            }
            None if mark.can_open => *opener = opener.or(Some(index)),
            None => {}
        }
    }
}

struct Scanner<'s, 't> {
    text: &'s str,
    /// The position of the text on the page.
    page_at: usize,
    /// The position in the text.
    at: usize,
    tokens: &'t mut Vec<Token<'s>>,
}

impl<'s> Scanner<'s, '_> {
    fn scan(mut self) {
        // After the last closing bracket, don't search for another one.
        let last = |bracket| self.text.rfind(bracket).unwrap_or(0);
        let (last_bracket, last_angle) = (last("]"), last(">>"));
        while let Some(c) = self.rest().chars().next() {
            match c {
                '\\' if self.rest()[1..].starts_with(['|', '*', '_', '`', '{', '<']) => {
                    self.at += 1;
                    self.text(1);
                }
                '*' | '_' | '`' => self.mark(c),
                '<' if self.rest().starts_with("<<") && self.at < last_angle => self.reference(),
                '{' => self.attribute(),
                _ if c.is_alphanumeric() => self.word(last_bracket),
                _ => self.text(c.len_utf8()),
            }
        }
    }

    fn rest(&self) -> &'s str {
        &self.text[self.at..]
    }

    /// Adds the next `len` bytes as text.
    fn text(&mut self, len: usize) {
        self.tokens.push(Token { at: self.page_at + self.at, text: &self.rest()[..len], mark: None });
        self.at += len;
    }

    fn mark(&mut self, mark: char) {
        let is_double = self.rest()[1..].starts_with(mark);
        let len = if is_double { 2 } else { 1 };
        let before = self.text[..self.at].chars().next_back();
        let after = self.rest()[len..].chars().next();
        let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
        let is_space = |c: Option<char>| c.is_none_or(char::is_whitespace);
        let kind = (MARKS.iter().position(|known| *known == mark).unwrap_or(0), is_double);
        let can_open = is_double || (!is_word(before) && !is_space(after));
        let can_close = is_double || (!is_space(before) && !is_word(after));
        self.text(len);
        if let Some(token) = self.tokens.last_mut() {
            token.mark = Some(Mark { kind, can_open, can_close });
        }
    }

    /// Reads `<<anchor,text>>`, or `<<anchor>>`, whose text is the anchor.
    fn reference(&mut self) {
        let Some(end) = self.rest().find(">>") else { return self.text(2) };
        let inner = &self.rest()[2..end];
        let start = inner.find(',').map_or(2, |comma| 2 + comma + 1);
        self.at += start;
        self.text(end - start);
        self.at += 2;
    }

    fn attribute(&mut self) {
        let found = ATTRIBUTES.into_iter().find(|(name, _)| self.rest().starts_with(name));
        let Some((name, text)) = found else { return self.text(1) };
        self.tokens.push(Token { at: self.page_at + self.at, text, mark: None });
        self.at += name.len();
    }

    /// Reads a word or a link such as `link:page.html[text]`, and keeps only the link text.
    fn word(&mut self, last_bracket: usize) {
        let rest = self.rest();
        let is_link = LINKS.iter().any(|start| rest.starts_with(start));
        if !is_link {
            return self.text(rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len()));
        }
        let target = rest.find(|c: char| c == '[' || c.is_whitespace()).unwrap_or(rest.len());
        let has_text = rest[target..].starts_with('[') && self.at + target < last_bracket;
        if !has_text {
            return self.text(target);
        }
        self.at += target + 1;
        self.text(self.rest().find(']').unwrap_or(0));
        self.at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Span;

    fn plain(text: &str) -> String {
        let mut builder = TextBuilder::new(Span { start: 0, end: u32::try_from(text.len()).expect("short") });
        let mut at = 0;
        let stretches: Vec<Line<'_>> = text
            .split('\n')
            .map(|line| {
                at += line.len() + 1;
                (at - line.len() - 1, line)
            })
            .collect();
        push(&stretches, &mut builder);
        builder.finish(0..text.len()).as_str().to_owned()
    }

    #[test]
    fn removes_markup_and_keeps_text() {
        for (written, read) in [
            ("*a* _b c_ `d`, **e**f __g__", "a b c d, ef g"),
            ("*a\nb* c", "a b c"),
            ("RC_LOST_X 2*3*4 a * b *c", "RC_LOST_X 2*3*4 a * b *c"),
            ("`RC_LOST`", "RC_LOST"),
            ("link:a/b.html[see this] xref:c[d]", "see this d"),
            ("https://example.org[site] https://example.org", "site https://example.org"),
            ("<<fuel,the fuel>> <<wind>> a << b", "the fuel wind a << b"),
            ("a{vbar}b {unknown} c\\|d \\*e* \\n", "a|b {unknown} c|d *e* \\n"),
            ("link:a[", "link:a["),
            ("é*ü*é *ü*", "é*ü*é ü"),
        ] {
            assert_eq!(plain(written), read, "{written}");
        }
    }
}
