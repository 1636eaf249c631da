//! Removes the secrets of a connection from the data that is recorded and reported. Servers may repeat secrets.

use std::borrow::Cow;

use uavspec_model::json::base64;
use uavspec_model::text::HIDDEN;

/// The minimum length of a password or a token that is hidden wherever it appears, in characters. A shorter text may
/// also be another word.
const MIN_LENGTH: usize = 6;

/// The secrets of a connection: the password of the login, and the query of the URL.
#[derive(Clone, Default)]
pub struct Secrets {
    /// The texts to hide, from the longest to the shortest.
    texts: Vec<String>,
}

impl Secrets {
    /// The secrets of a login with name and password, and of a path with a query.
    pub(crate) fn new(login: Option<&(String, String)>, path: &str) -> Self {
        let mut texts = Vec::new();
        if let Some((name, password)) = login.filter(|(_, password)| !password.is_empty()) {
            let pair = format!("{name}:{password}");
            texts.extend(encodings(&pair).chain([pair]));
            texts.extend(encodings(password).chain([password.clone()]).filter(|text| is_distinct(text)));
        }
        if let Some((_, query)) = path.split_once('?') {
            let values = query.split('&').filter_map(|pair| pair.split_once('=')).map(|(_, value)| value);
            texts.extend(values.chain([query]).filter(|text| is_distinct(text)).map(str::to_owned));
        }
        let in_json = texts.iter().map(|text| quoted(text)).filter(|text| !texts.contains(text));
        texts.extend(in_json.collect::<Vec<_>>());
        texts.sort_by_key(|text| std::cmp::Reverse(text.len()));
        Self { texts }
    }

    /// Replaces each secret in a text with a placeholder. In JSON strings, secrets may contain escapes.
    pub fn hide<'t>(&self, text: &'t str) -> Cow<'t, str> {
        let mut hidden = Cow::Borrowed(text);
        for secret in &self.texts {
            if let Cow::Owned(without) = replaced(&hidden, secret) {
                hidden = Cow::Owned(without);
            }
        }
        hidden
    }
}

/// The encodings in which servers receive and return a login.
fn encodings(text: &str) -> impl Iterator<Item = String> + use<> {
    let padded = base64::encode(text.as_bytes());
    let bare = padded.trim_end_matches('=').to_owned();
    [padded, bare].into_iter()
}

/// True if a text is so long that it won't appear elsewhere by chance.
fn is_distinct(text: &str) -> bool {
    text.chars().count() >= MIN_LENGTH
}

/// A text as it appears in a JSON string.
fn quoted(text: &str) -> String {
    let quoted = serde_json::Value::from(text).to_string();
    quoted[1..quoted.len() - 1].to_owned()
}

/// A text in which a placeholder replaces each occurrence of a word.
fn replaced<'t>(text: &'t str, word: &str) -> Cow<'t, str> {
    let mut kept = String::new();
    let mut end = 0;
    for (at, _) in text.match_indices(word) {
        let after = at + word.len();
        let is_apart =
            !text[..at].ends_with(char::is_alphanumeric) && !text[after..].starts_with(char::is_alphanumeric);
        if is_apart {
            kept.push_str(&text[end..at]);
            kept.push_str(HIDDEN);
            end = after;
        }
    }
    if end == 0 { Cow::Borrowed(text) } else { Cow::Owned(kept + &text[end..]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn secrets_are_hidden_in_all_forms() {
        let login = ("pilot".to_owned(), "s\"cret!".to_owned());
        let secrets = Secrets::new(Some(&login), "/api?token=hunter2%20&a=b");
        let encoded = base64::encode(b"pilot:s\"cret!");
        for (text, expected) in [
            (format!("Basic {encoded}"), "Basic (hidden)"),
            (encoded.trim_end_matches('=').to_owned(), "(hidden)"),
            (r#"{"reason":"pilot:s\"cret! is wrong"}"#.to_owned(), r#"{"reason":"(hidden) is wrong"}"#),
            ("s\"cret!, s\"cret!2".to_owned(), "(hidden), s\"cret!2"),
            ("/api?token=hunter2%20&a=b".to_owned(), "/api?(hidden)"),
            ("hunter2%20 b".to_owned(), "(hidden) b"),
        ] {
            assert_eq!(secrets.hide(&text), expected);
        }
    }

    /// A short password is hidden only as part of a login, because the same text may also be another word.
    #[test]
    fn short_secrets_are_hidden_only_with_their_context() {
        let secrets = Secrets::new(Some(&("me".to_owned(), "uav".to_owned())), "/?a=uav");
        let login = base64::encode(b"me:uav");
        assert_eq!(secrets.hide(&format!("uav {login} me:uav")), "uav (hidden) (hidden)");
        for empty in [Secrets::new(None, "/api?"), Secrets::new(Some(&("me".to_owned(), String::new())), "")]
        {
            assert_eq!(empty.hide("me: /api?"), "me: /api?");
        }
    }
}
