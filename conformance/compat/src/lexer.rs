//! The words, texts and symbols of a source file. Comments are left out.

use std::path::Path;

/// The maximum length of the delimiter of a raw string in C++.
const MAX_DELIMITER: usize = 16;

/// A language of source files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    /// C and C++.
    Cpp,
    Python,
    Rust,
    /// Files without statements: YAML and JSON.
    Yaml,
    /// Launch files in XML.
    Xml,
}

impl Language {
    /// The language of a file, by its extension.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "c" | "cc" | "cpp" | "cu" | "cxx" | "h" | "hh" | "hpp" | "hxx" | "inl" | "ipp" | "tpp" => {
                Some(Self::Cpp)
            }
            "py" => Some(Self::Python),
            "rs" => Some(Self::Rust),
            "json" | "yaml" | "yml" => Some(Self::Yaml),
            "launch" | "xml" => Some(Self::Xml),
            _ => None,
        }
    }
}

/// A part of a source file, with its offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token<'t> {
    pub(crate) part: Part<'t>,
    pub(crate) at: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part<'t> {
    /// An identifier, a keyword or a number.
    Word(&'t str),
    /// The content of a string literal as it is written, or a value in a file without statements.
    Text(&'t str),
    Symbol(char),
}

/// The tokens of a file. A literal without an end continues to the end of its line, or of the file if it may have
/// several lines.
pub(crate) fn tokens(text: &str, language: Language) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(first) = text[at..].chars().next() {
        let rest = &text[at..];
        if let Some(length) = comment(text, at, language) {
            at += length;
        } else if let Some((start, end, length)) = literal(rest, language) {
            tokens.push(Token { part: Part::Text(&rest[start..end]), at: at + start });
            at += length;
        } else if is_of_word(first) {
            let length = rest.find(|next| !is_of_word(next)).unwrap_or(rest.len());
            tokens.push(Token { part: Part::Word(&rest[..length]), at });
            at += length;
        } else {
            if !first.is_whitespace() {
                tokens.push(Token { part: Part::Symbol(first), at });
            }
            at += first.len_utf8();
        }
    }
    tokens
}

fn is_of_word(character: char) -> bool {
    character.is_alphanumeric() || character == '_'
}

/// The length of the comment at an offset.
fn comment(text: &str, at: usize, language: Language) -> Option<usize> {
    let rest = &text[at..];
    let until = |end: &str| rest.find(end).map_or(rest.len(), |found| found + end.len());
    let line = || rest.find('\n').unwrap_or(rest.len());
    match language {
        Language::Cpp | Language::Rust if rest.starts_with("//") => Some(line()),
        Language::Cpp | Language::Rust if rest.starts_with("/*") => Some(until("*/")),
        Language::Python if rest.starts_with('#') => Some(line()),
        Language::Yaml if rest.starts_with('#') => {
            (at == 0 || text[..at].ends_with(char::is_whitespace)).then(line)
        }
        Language::Xml if rest.starts_with("<!--") => Some(until("-->")),
        _ => None,
    }
}

/// The start, the end and the length of the literal at the start of a text. The length includes the quotation marks.
fn literal(text: &str, language: Language) -> Option<(usize, usize, usize)> {
    let raw = |start: usize, close: &str| {
        let end = text[start..].find(close).map_or(text.len(), |found| start + found);
        (start, end, (end + close.len()).min(text.len()))
    };
    match language {
        Language::Yaml | Language::Xml => {
            let is_end = |next: char| next.is_whitespace() || "\"'<>,[]{}=".contains(next);
            let length = text.find(is_end).unwrap_or(text.len());
            (length > 0).then_some((0, length, length))
        }
        Language::Cpp if text.starts_with("R\"") => {
            let open = text.bytes().take(3 + MAX_DELIMITER).position(|byte| byte == b'(')?;
            Some(raw(open + 1, &format!("){}\"", &text[2..open])))
        }
        Language::Rust if text.starts_with("r\"") => Some(raw(2, "\"")),
        Language::Rust if text.starts_with("r#") => {
            let hashes = text[1..].bytes().take_while(|byte| *byte == b'#').count();
            text[1 + hashes..].starts_with('"').then(|| raw(2 + hashes, &format!("\"{}", "#".repeat(hashes))))
        }
        Language::Python if text.starts_with("\"\"\"") => Some(raw(3, "\"\"\"")),
        Language::Python if text.starts_with("'''") => Some(raw(3, "'''")),
        Language::Python if text.starts_with('\'') => Some(quoted(text, '\'')),
        Language::Cpp | Language::Rust if text.starts_with('\'') => {
            // A character, but neither a lifetime nor a separator of digits.
            let inner = text[1..].strip_prefix('\\').unwrap_or(&text[1..]);
            let close = 1 + inner.chars().next()?.len_utf8();
            let length = text.len() - inner.len() + close;
            text.get(..length).filter(|text| text.ends_with('\'')).map(|_| (1, length - 1, length))
        }
        _ => text.starts_with('"').then(|| quoted(text, '"')),
    }
}

/// Like [`literal`], for a literal on one line in which `\` escapes the next character.
fn quoted(text: &str, mark: char) -> (usize, usize, usize) {
    let mut is_escaped = false;
    for (at, character) in text.char_indices().skip(1) {
        match character {
            '\n' if !is_escaped => return (1, at, at),
            _ if character == mark && !is_escaped => return (1, at, at + 1),
            _ => is_escaped = character == '\\' && !is_escaped,
        }
    }
    (1, text.len(), text.len())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn texts(text: &str, language: Language) -> Vec<&str> {
        let texts = tokens(text, language).into_iter().filter_map(|token| match token.part {
            Part::Text(text) => Some(text),
            _ => None,
        });
        texts.collect()
    }

    #[test]
    fn comments_contain_no_texts() {
        let cpp = "a(\"x\"); // \"y\"\n/* \"z\" */ b('\"', \"\\\"w\", R\"-(v\")-\", 1'000, \"u\");";
        assert_eq!(texts(cpp, Language::Cpp), ["x", "\"", "\\\"w", "v\"", "u"]);
        let rust = "fn f<'a>(x: &'a str) { g(\"x\", r#\"y\"z\"#, r\"w\\\", '\\'', 'v') } // \"u\"";
        assert_eq!(texts(rust, Language::Rust), ["x", "y\"z", "w\\", "\\'", "v"]);
        let python = "a = f'x' # 'y'\n\"\"\"z\n\"w\" \"\"\"\nb('v\n\"u\")";
        assert_eq!(texts(python, Language::Python), ["x", "z\n\"w\" ", "v", "u"]);
        assert_eq!(texts("a: [/x, \"/y\"] # /z\n- b#c", Language::Yaml), ["a:", "/x", "/y", "-", "b#c"]);
        assert_eq!(texts("<a to=\"/x\"/><!-- /y -->", Language::Xml), ["a", "to", "/x", "/"]);
    }

    proptest! {
        #[test]
        fn tokens_are_parts_of_any_text(text in "[\\PC\n\"'#/*\\\\(R<!-]{0,40}") {
            for language in [Language::Cpp, Language::Python, Language::Rust, Language::Yaml, Language::Xml] {
                let tokens = tokens(&text, language);
                for token in &tokens {
                    let length = match token.part {
                        Part::Word(text) | Part::Text(text) => text.len(),
                        Part::Symbol(symbol) => symbol.len_utf8(),
                    };
                    prop_assert!(text.is_char_boundary(token.at) && token.at + length <= text.len());
                }
                prop_assert!(tokens.windows(2).all(|pair| pair[0].at <= pair[1].at));
            }
        }
    }
}
