//! Removes secrets from text that reports and errors show. Queries of URLs may be signatures.

/// The option whose value contains a password, and what is shown instead of the value.
const LOGIN: (&str, &str) = ("--login", "NAME:PASSWORD");

/// The schemes of URLs of object stores and web servers.
const SCHEMES: [&str; 8] = ["s3", "s3a", "gs", "az", "abfs", "abfss", "https", "http"];

/// True if a text is the URL of an object in an object store or on a web server.
pub(crate) fn is_object_url(text: &str) -> bool {
    let scheme = text.split_once("://").map(|(scheme, _)| scheme);
    scheme.is_some_and(|scheme| SCHEMES.iter().any(|known| known.eq_ignore_ascii_case(scheme)))
}

/// A URL without its query, its fragment and its password. Other names stay as they are.
pub(crate) fn shown_url(name: &str) -> String {
    let Some((scheme, rest)) = name.split_once("://") else { return name.to_owned() };
    let rest = rest.split(['?', '#']).next().unwrap_or(rest);
    let (server, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
    // In URLs of Azure, the name before the server is a container.
    let is_container = scheme.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("abfs"));
    let server = if is_container { server } else { server.rsplit('@').next().unwrap_or(server) };
    format!("{scheme}://{server}{path}")
}

/// The words of a command line without passwords and the queries of objects. Other queries are options, such as `?domain=5`.
pub(crate) fn shown_words(words: impl Iterator<Item = String>) -> Vec<String> {
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
}
