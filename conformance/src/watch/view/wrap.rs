//! Texts that are longer than there is room for.

use ratatui::text::{Line, Span};

/// A line, cut where it is too long, with a sign that it was.
pub(super) fn clipped(line: Line<'_>, width: usize) -> Line<'_> {
    if line.width() <= width {
        return line;
    }
    let (style, alignment) = (line.style, line.alignment);
    let mut spans = Vec::new();
    let mut left = width;
    for span in line.spans {
        let wide = span.width();
        // One column is for the sign.
        if wide < left {
            left -= wide;
            spans.push(span);
            continue;
        }
        spans.push(Span::styled(with_sign(&span.content, left), span.style));
        break;
    }
    let mut line = Line::from(spans).style(style);
    line.alignment = alignment;
    line
}

/// As much of the start of a text as there is room for, with a sign that something follows.
fn with_sign(text: &str, width: usize) -> String {
    let Some(room) = width.checked_sub(1) else { return String::new() };
    let mut taken = 0;
    let end = text.char_indices().find_map(|(at, character)| {
        taken += Span::raw(&text[at..at + character.len_utf8()]).width();
        (taken > room).then_some(at)
    });
    format!("{}…", &text[..end.unwrap_or(text.len())])
}

/// A text in lines of at most so many columns, broken between words where that can be.
pub(super) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let width = width.max(1);
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split(' ') {
        let mut word = word;
        if !line.is_empty() && Span::raw(&line).width() + 1 + Span::raw(word).width() > width {
            lines.push(std::mem::take(&mut line));
        }
        while Span::raw(word).width() > width {
            let (start, rest) = word.split_at(fitting(word, width));
            lines.push(start.to_owned());
            word = rest;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    lines.push(line);
    lines
}

/// How many bytes of a word fit into so many columns: those of one character at least.
fn fitting(word: &str, width: usize) -> usize {
    let mut taken = 0;
    let mut end = 0;
    for character in word.chars() {
        let next = end + character.len_utf8();
        taken += Span::raw(&word[end..next]).width();
        if taken > width && end > 0 {
            break;
        }
        end = next;
    }
    end
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use ratatui::style::Stylize as _;

    use super::*;

    #[test]
    fn marks_truncated_text() {
        for (text, width, shown) in [
            ("glider", 6, "glider"),
            ("glider", 5, "glid…"),
            ("風力計", 5, "風力…"),
            ("風力計", 4, "風…"),
            ("glider", 0, ""),
        ] {
            assert_eq!(clipped(Line::raw(text), width).to_string(), shown);
        }
        let line = || Line::from(vec!["wind ".into(), "7 m/s".red(), " gusts".into()]);
        assert_eq!(clipped(line(), 8), Line::from(vec!["wind ".into(), "7 …".red()]));
        assert_eq!(clipped(line(), 5), Line::from(vec!["wind…".into()]));
        assert_eq!(clipped(line(), 16), line());
    }

    #[test]
    fn wraps_texts_between_words() {
        assert_eq!(wrapped("the wind blows", 8), ["the wind", "blows"]);
        assert_eq!(wrapped("a windsock", 4), ["a", "wind", "sock"]);
        assert_eq!(wrapped("", 4), [""]);
    }

    proptest! {
        #[test]
        fn nothing_is_wider_than_there_is_room(text in ".{0,40}", width in 2..20_usize) {
            prop_assert!(clipped(Line::raw(text.clone()), width).width() <= width);
            for line in wrapped(&text, width) {
                prop_assert!(Span::raw(line).width() <= width);
            }
        }
    }
}
