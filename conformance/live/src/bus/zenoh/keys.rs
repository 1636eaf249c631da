//! The keys of topics, and the names in these keys.

use uavspec_model::limits::MAX_NAME;

use crate::bus::Topic;

/// The text in place of the hash in the keys of ROS 2 Humble, which has no hashes.
pub(super) const NO_HASH: &str = "TypeHashNotSupported";

/// The key that subscribers use for a topic. It matches all hashes if the topic has none.
pub(super) fn subscription_key(domain: u16, topic: &Topic) -> Result<String, String> {
    topic_key(domain, topic, topic.type_hash.as_deref().unwrap_or("*"))
}

/// The key that publishers use for a topic. If the topic has no hash, the key states this.
pub(super) fn publication_key(domain: u16, topic: &Topic) -> Result<String, String> {
    topic_key(domain, topic, topic.type_hash.as_deref().unwrap_or(NO_HASH))
}

fn topic_key(domain: u16, topic: &Topic, hash: &str) -> Result<String, String> {
    let name = topic.name.trim_matches('/');
    check_name("topic", name)?;
    let type_name = topic.dds_type();
    check_name("type", &type_name)?;
    if hash != "*" {
        check_name("type hash", hash)?;
    }
    Ok(format!("{domain}/{name}/{type_name}/{hash}"))
}

/// Checks that a name has no wildcards and no empty parts. Wildcards would match other names.
fn check_name(kind: &str, name: &str) -> Result<(), String> {
    let is_plain = |part: &str| {
        !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_alphanumeric() || b"_-.:~".contains(&byte))
    };
    if name.len() <= MAX_NAME && name.split('/').all(is_plain) {
        return Ok(());
    }
    let shown: String = name.chars().take(80).collect();
    Err(format!("expected a {kind} of letters, digits, `_` and `/`, found `{}`", shown.escape_debug()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, type_name: &str, hash: Option<&str>) -> Topic {
        Topic { name: name.into(), type_name: type_name.into(), type_hash: hash.map(Into::into) }
    }

    #[test]
    fn keys_contain_the_type_and_its_hash() {
        let hashed = topic("/fmu/out/a", "p/msg/A", Some("RIHS01_1"));
        let key = "0/fmu/out/a/p::msg::dds_::A_/RIHS01_1";
        assert_eq!(subscription_key(0, &hashed), Ok(key.to_owned()));
        assert_eq!(publication_key(0, &hashed), Ok(key.to_owned()));
    }

    #[test]
    fn only_subscribers_match_all_hashes() {
        let topic = topic("/a", "p/msg/A", None);
        assert_eq!(subscription_key(7, &topic), Ok("7/a/p::msg::dds_::A_/*".to_owned()));
        assert_eq!(publication_key(7, &topic), Ok("7/a/p::msg::dds_::A_/TypeHashNotSupported".to_owned()));
    }

    #[test]
    fn names_with_wildcards_have_no_key() {
        for (name, type_name, hash) in [
            ("/a/**", "p/msg/A", None),
            ("/a//b", "p/msg/A", None),
            ("", "p/msg/A", None),
            ("/a", "", None),
            ("/a", "*", None),
            ("/a", "p/msg/A", Some("**")),
        ] {
            let error = subscription_key(0, &topic(name, type_name, hash)).expect_err("an error");
            assert!(error.starts_with("expected a t"), "{error}");
        }
    }
}
