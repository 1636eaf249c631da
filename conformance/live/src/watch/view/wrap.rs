//! Clips and wraps long text.

use std::ops::Range;

use ratatui::text::{Line, Span};

/// The variation selector that turns the character before it into an emoji.
const EMOJI_SELECTOR: char = '\u{fe0f}';

/// Clips a line to a width. A clipped line ends in an ellipsis.
pub(super) fn clipped(line: Line<'_>, width: usize) -> Line<'_> {
    if line.width() <= width {
        return line;
    }
    let (style, alignment) = (line.style, line.alignment);
    let mut spans = Vec::new();
    let mut left = width;
    for span in line.spans {
        let needed = span.width();
        // One column is reserved for the ellipsis.
        if needed < left {
            left -= needed;
            spans.push(span);
            continue;
        }
        spans.push(Span::styled(with_ellipsis(&span.content, left), span.style));
        break;
    }
    let mut line = Line::from(spans).style(style);
    line.alignment = alignment;
    line
}

/// The longest start of a text that fits into a width together with an ellipsis.
fn with_ellipsis(text: &str, width: usize) -> String {
    let Some(room) = width.checked_sub(1) else { return String::new() };
    format!("{}…", &text[..fitting_length(text, room)])
}

/// Wraps a text into lines of at most `width` columns, between words if possible.
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
            let first = glyphs(word).next().map_or(word.len(), |first| first.end);
            let (start, rest) = word.split_at(fitting_length(word, width).max(first));
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

/// A label, followed by a text that is wrapped into lines. The label is in a column of width `column`.
pub(super) fn labelled<'t>(
    label: impl Into<Span<'t>>,
    text: impl Into<Span<'t>>,
    column: usize,
    width: usize,
) -> Vec<Line<'static>> {
    let (label, text) = (label.into(), text.into());
    let parts = wrapped(&text.content, width.saturating_sub(column));
    let lines = parts.into_iter().enumerate().map(|(number, part)| {
        let first = if number == 0 { &*label.content } else { "" };
        Line::from(vec![
            Span::styled(format!("{first:column$}"), label.style),
            Span::styled(part, text.style),
        ])
    });
    lines.collect()
}

/// The length of the longest start of a text that fits into a width, in bytes.
fn fitting_length(text: &str, width: usize) -> usize {
    let mut taken = 0;
    let fitting = glyphs(text).take_while(|glyph| {
        taken += Span::raw(&text[glyph.clone()]).width();
        taken <= width
    });
    fitting.last().map_or(0, |last| last.end)
}

/// The characters of a text, each together with the variation selectors that follow it. A selector may turn a narrow
/// character into a wide emoji. The sum of the widths is therefore an upper bound of the width of the text.
fn glyphs(text: &str) -> impl Iterator<Item = Range<usize>> {
    let starts = text.char_indices().skip(1).filter(|(_, character)| *character != EMOJI_SELECTOR);
    let ends = starts.map(|(at, _)| at).chain((!text.is_empty()).then_some(text.len()));
    ends.scan(0, |start, end| Some(std::mem::replace(start, end)..end))
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
            ("*\u{fe0f}*\u{fe0f}", 3, "*\u{fe0f}…"),
            ("*\u{fe0f}*\u{fe0f}", 2, "…"),
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
        assert_eq!(wrapped("*\u{fe0f}*\u{fe0f}", 2), ["*\u{fe0f}", "*\u{fe0f}"]);
        assert_eq!(wrapped("", 4), [""]);
    }

    proptest! {
        #[test]
        fn lines_never_exceed_the_width(text in ".{0,40}", width in 2..20_usize) {
            prop_assert!(clipped(Line::raw(text.clone()), width).width() <= width);
            for line in wrapped(&text, width) {
                prop_assert!(Span::raw(line).width() <= width);
            }
        }
    }
}
