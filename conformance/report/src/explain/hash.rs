//! Hashes of messages and types.

use uavspec_schema::fingerprint::ros_name;

use super::answer::{Hash, Hashed};
use super::catalogue::Catalogue;

/// The start of a ROS type hash.
const TYPE_HASH: &str = "RIHS01_";

/// True if a word has the form of a uORB message hash: eight digits, optionally after `0x`.
pub(super) fn is_message_hash(word: &str) -> bool {
    let digits = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X")).unwrap_or(word);
    digits.len() == 8 && digits.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// Finds the definitions that have a hash. `None` if the word isn't a hash, or no definition has this hash.
pub(super) fn find(catalogue: &Catalogue<'_>, word: &str) -> Option<Hash> {
    let (form, hash) = if is_message_hash(word) {
        ("uorb", word[word.len() - 8..].to_ascii_lowercase())
    } else if word.get(..TYPE_HASH.len()).is_some_and(|start| start.eq_ignore_ascii_case(TYPE_HASH)) {
        ("type_hash", format!("{TYPE_HASH}{}", word[TYPE_HASH.len()..].to_ascii_lowercase()))
    } else {
        return None;
    };
    let is_equal = |uorb: u32, type_hash: &str| match form {
        "uorb" => format!("{uorb:08x}") == hash,
        _ => type_hash == hash,
    };
    // Only PX4 messages have a uORB hash and topics.
    let has_form = |has_topics: bool| form != "uorb" || has_topics;
    let rows =
        catalogue.rows().filter(|row| has_form(!row.topics.is_empty()) && is_equal(row.hash, row.type_hash));
    let mut definitions: Vec<Hashed> = rows
        .map(|row| Hashed {
            name: row.name.to_owned(),
            topics: row.owned_topics(),
            releases: row.releases.iter().map(|release| catalogue.label(release)).collect(),
            documented: false,
        })
        .collect();
    let schema = &catalogue.library().base().schema;
    for message in schema.messages.iter().filter(|message| is_equal(message.hash, &message.type_hash)) {
        let name = ros_name(schema, message);
        match definitions.iter_mut().find(|found| found.name == name) {
            Some(found) => found.documented = true,
            None if !has_form(!message.topics.is_empty()) => {}
            None => definitions.push(Hashed {
                name,
                topics: message.topics.clone(),
                releases: Vec::new(),
                documented: true,
            }),
        }
    }
    let digits = if form == "uorb" { format!("0x{hash}") } else { hash };
    (!definitions.is_empty()).then_some(Hash { digits, form, definitions })
}
