//! Removes secrets from text that reports, recordings and errors show: passwords, and the queries of URLs, which may be
//! signatures or tokens.

use std::borrow::Cow;

/// The option whose value contains a password, and what is shown instead of the value.
const LOGIN: (&str, &str) = ("--login", "NAME:PASSWORD");

/// Shown in place of a secret.
pub const HIDDEN: &str = "(hidden)";

/// The schemes of URLs of object stores and web servers.
const SCHEMES: [&str; 8] = ["s3", "s3a", "gs", "az", "abfs", "abfss", "https", "http"];

/// The characters between the scheme of a URL and its server.
const SCHEME_END: &str = "://";

/// The characters after which a URL in a text ends.
const END: [char; 7] = [' ', '\n', '"', '\'', ')', '>', '`'];

/// True if a text is the URL of an object in an object store or on a web server.
pub fn is_object_url(text: &str) -> bool {
    let scheme = text.split_once(SCHEME_END).map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| SCHEMES.iter().any(|known| known.eq_ignore_ascii_case(scheme)))
}

/// A URL without its query, its fragment and its password. Other names are unchanged.
pub fn shown_url(name: &str) -> String {
    let Some((scheme, rest)) = name.split_once(SCHEME_END) else { return name.to_owned() };
    let rest = without_query(rest);
    let (server, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    // In URLs of Azure, the name before the server is a container.
    let is_container = scheme.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("abfs"));
    let server = if is_container { server } else { server.rsplit('@').next().unwrap_or(server) };
    format!("{scheme}://{server}{path}")
}

/// The path of a URL without its query and its fragment.
pub fn without_query(path: &str) -> &str {
    path.split(['?', '#']).next().unwrap_or(path)
}

/// A text without the queries and passwords of the URLs in it.
pub fn without_secrets(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(scheme) = rest.find(SCHEME_END) {
        let (before, url) = rest.split_at(scheme + SCHEME_END.len());
        let (url, after) = url.split_at(url.find(END).unwrap_or(url.len()));
        let url = without_query(url);
        let server = url.split('/').next().unwrap_or(url);
        kept.push_str(before);
        kept.push_str(&url[server.rfind('@').map_or(0, |user| user + 1)..]);
        rest = after;
    }
    kept.push_str(rest);
    kept
}

/// The text of a message without the data of a login. The message may be invalid or truncated.
pub fn without_login(text: &str) -> Cow<'_, str> {
    match text.split_once("\"data\"") {
        Some((start, _)) if text.contains("AUTH-REQ") => Cow::Owned(format!("{start}…")),
        _ => Cow::Borrowed(text),
    }
}

/// The words of a command line, without passwords and without the queries of object URLs. Other queries are kept,
/// because they are options such as `?domain=5`.
pub fn shown_words(words: impl Iterator<Item = String>) -> Vec<String> {
    let (option, value) = LOGIN;
    let mut is_login = false;
    let shown = words.map(|word| {
        let is_value = std::mem::replace(&mut is_login, word == option);
        let has_value = word.strip_prefix(option).is_some_and(|rest| rest.starts_with('='));
        match (is_value, has_value) {
            (true, _) => value.to_owned(),
            (_, true) => format!("{option}={value}"),
            _ if is_object_url(&word) => shown_url(&word),
            _ => word,
        }
    });
    shown.collect()
}

/// An invalid value of an argument, without secrets. `argument` is the option with the name of its value, such as
/// `--login <NAME:PASSWORD>`.
pub fn shown_value(argument: &str, value: &str) -> String {
    if argument.starts_with(LOGIN.0) {
        HIDDEN.to_owned()
    } else if value.contains(SCHEME_END) {
        without_secrets(value)
    } else {
        // The scheme of a URL may be missing.
        value.rsplit_once('@').map_or(value, |(_, server)| server).to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shown_urls_contain_no_secrets() {
        for (url, expected) in [
            ("s3://logs/flight (2).ulg?signature=secret", "s3://logs/flight (2).ulg"),
            ("HTTPS://me:sec)ret@host/a.ulg#secret", "HTTPS://host/a.ulg"),
            ("https://secret@host?secret", "https://host"),
            ("abfss://logs@account/a.ulg", "abfss://logs@account/a.ulg"),
            ("what?.ulg", "what?.ulg"),
            ("://", "://"),
        ] {
            assert_eq!(shown_url(url), expected);
        }
    }

    #[test]
    fn command_lines_contain_no_secrets() {
        for (words, expected) in [
            (&["probe", "--login", "me:secret", "--ca", "a"][..], "probe --login NAME:PASSWORD --ca a"),
            (&["--login=me:secret", "--logins", "a:b"], "--login=NAME:PASSWORD --logins a:b"),
            (&["check", "https://me:secret@host/a.ulg?sig=secret"], "check https://host/a.ulg"),
            (&["zenoh://host:7447?domain=5"], "zenoh://host:7447?domain=5"),
            (&["curl http://host/?a | codec"], "curl http://host/?a | codec"),
        ] {
            assert_eq!(shown_words(words.iter().map(|word| (*word).to_owned())).join(" "), expected);
        }
    }

    #[test]
    fn urls_have_a_scheme() {
        for url in ["s3://logs", "gs://logs/2026", "https://example.org/list.txt"] {
            assert!(is_object_url(url), "{url}");
        }
        for path in ["s3", "s3:/logs", "logs/s3://x", "file:///x", "dds://0"] {
            assert!(!is_object_url(path), "{path}");
        }
    }

    #[test]
    fn errors_contain_no_secrets() {
        let text = "error for url (https://a.example/b?sig=secret&x=1): \"http://me:secret@c/d@2?e\" and https://f/?g";
        let expected = "error for url (https://a.example/b): \"http://c/d@2\" and https://f/";
        assert_eq!(without_secrets(text), expected);
        for text in ["no URL?", "a@b.example", "://", "s3://?x", ""] {
            assert_eq!(without_secrets(text), text.trim_end_matches("?x"));
        }
    }

    #[test]
    fn invalid_arguments_contain_no_secrets() {
        for (argument, value, expected) in [
            ("--login <NAME:PASSWORD>", "secret", "(hidden)"),
            ("<URL>", "tcp://me:secret@host:1", "tcp://host:1"),
            ("<URL>", "me:secret@host:1", "host:1"),
            ("<URL>", "socketio://host?token=secret", "socketio://host"),
            ("--limit <SECONDS>", "soon", "soon"),
        ] {
            assert_eq!(shown_value(argument, value), expected);
        }
    }

    #[test]
    fn messages_contain_no_logins() {
        let login = r#"{"body":{"type":"AUTH-REQ","method":"basic","data":"d2luZA=="#;
        assert_eq!(without_login(login), r#"{"body":{"type":"AUTH-REQ","method":"basic",…"#);
        for other in [r#"{"type":"AUTH-RESP","data":"x"}"#, r#"{"type":"AUTH-REQ"}"#] {
            assert_eq!(without_login(other), other);
        }
    }
}
