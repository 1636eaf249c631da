//! Captures in object stores: Amazon S3 and compatible ones, Google Cloud Storage, Azure Blob Storage, and web servers.
//!
//! ```text
//!  URL ──list──▶ Objects      Object ──ranges, read ahead──▶ Reader ──bytes──▶ check
//! ```
//!
//! An object is read in ranges, each with the condition that the object is still the same. A request that fails is
//! repeated. Nothing is stored in files. Errors contain neither credentials nor the queries of URLs, which may be
//! signatures.

mod connect;
mod object;
mod reader;
mod request;

use std::path::Path;

pub(crate) use self::connect::{Listed, list};
pub(crate) use self::object::Object;
pub(crate) use self::reader::Failure;

/// The schemes of URLs.
const SCHEMES: [&str; 8] = ["s3", "s3a", "gs", "az", "abfs", "abfss", "https", "http"];

/// The problem of a URL without captures.
pub(crate) const NOTHING: &str = "no captures have a URL that starts with this one";

/// True if an input is the URL of an object store.
pub(crate) fn is_url(input: &Path) -> bool {
    let scheme = input.to_str().and_then(|text| text.split_once(SCHEME_END)).map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| SCHEMES.iter().any(|known| known.eq_ignore_ascii_case(scheme)))
}

/// A URL without its query, its fragment and its password. Other names stay as they are.
pub(crate) fn shown_url(name: &str) -> String {
    let Some((scheme, rest)) = name.split_once(SCHEME_END) else { return name.to_owned() };
    let rest = rest.split(['?', '#']).next().unwrap_or(rest);
    let (server, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    // In URLs of Azure, the name before the server is a container.
    let is_container = scheme.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("abfs"));
    let server = if is_container { server } else { server.rsplit('@').next().unwrap_or(server) };
    format!("{scheme}{SCHEME_END}{server}{path}")
}

/// A text without the queries and passwords of the URLs in it.
pub(crate) fn without_secrets(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(scheme) = rest.find(SCHEME_END) {
        let (before, url) = rest.split_at(scheme + SCHEME_END.len());
        let (url, after) = url.split_at(url.find(END).unwrap_or(url.len()));
        let url = url.split('?').next().unwrap_or(url);
        let server = url.split('/').next().unwrap_or(url);
        kept.push_str(before);
        kept.push_str(&url[server.rfind('@').map_or(0, |user| user + 1)..]);
        rest = after;
    }
    kept.push_str(rest);
    kept
}

/// The characters between the scheme of a URL and its server.
const SCHEME_END: &str = "://";

/// The characters after which a URL in a text ends.
const END: [char; 7] = [' ', '\n', '"', '\'', ')', '>', '`'];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_have_a_scheme() {
        for url in ["s3://logs", "gs://logs/2026", "https://example.org/list.txt"] {
            assert!(is_url(Path::new(url)), "{url}");
        }
        for path in ["s3", "s3:/logs", "logs/s3://x", "file:///x", "dds://0"] {
            assert!(!is_url(Path::new(path)), "{path}");
        }
    }

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
    fn errors_contain_no_secrets() {
        let text = "error for url (https://a.example/b?sig=secret&x=1): \"http://me:secret@c/d@2?e\" and https://f/?g";
        let expected = "error for url (https://a.example/b): \"http://c/d@2\" and https://f/";
        assert_eq!(without_secrets(text), expected);
        for text in ["no URL?", "a@b.example", "://", "s3://?x", ""] {
            assert_eq!(without_secrets(text), text.trim_end_matches("?x"));
        }
    }
}
