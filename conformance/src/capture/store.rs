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
use crate::text::is_object_url;

/// The problem of a URL without captures. Stores list whole folders only.
pub(crate) const NOTHING: &str =
    "no captures at this URL: expected a capture, a folder, or a list on a web server";

/// True if an input is the URL of an object store.
pub(crate) fn is_url(input: &Path) -> bool {
    input.to_str().is_some_and(is_object_url)
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
    fn errors_contain_no_secrets() {
        let text = "error for url (https://a.example/b?sig=secret&x=1): \"http://me:secret@c/d@2?e\" and https://f/?g";
        let expected = "error for url (https://a.example/b): \"http://c/d@2\" and https://f/";
        assert_eq!(without_secrets(text), expected);
        for text in ["no URL?", "a@b.example", "://", "s3://?x", ""] {
            assert_eq!(without_secrets(text), text.trim_end_matches("?x"));
        }
    }
}
