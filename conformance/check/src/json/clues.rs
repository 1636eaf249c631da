//! The facts in JSON messages that indicate their release.

use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::iter;

use uavspec_capture::json::{Event, Reader};
use uavspec_lint::release::keys_hash;
use uavspec_model::json::Tree;
use uavspec_rules::definitions::{
    Clues, FormatClue, JsonClue, TypeClue, is_exchanged, ros_package, unversioned, version_of_topic,
};

use super::envelope::{Form, NameKind, form};
use super::{MAX_CHANNELS, is_flockwave};
use crate::Source;
use crate::limits::{MAX_CLUE_BYTES, MAX_CLUE_TEXT};
use crate::topic::{full_name, shows_type, topic_of};

/// The maximum number of consecutive values that contain no new facts.
const MAX_KNOWN: u32 = 200;

/// Reads the first non-empty message of each topic and type.
pub(super) fn clues(source: &mut Source<'_>) -> Clues {
    let mut reader = Reader::new(source.bytes.take(MAX_CLUE_BYTES));
    let (mut found, mut is_first, mut known_in_a_row) = (Found::default(), true, 0);
    while known_in_a_row < MAX_KNOWN
        && found.len() < MAX_CHANNELS
        && let Ok(Some(item)) = reader.next()
    {
        let Event::Value { bytes, .. } = item.event else { continue };
        let Ok(text) = std::str::from_utf8(bytes) else { continue };
        let Ok((tree, places)) = Tree::read_with_places(text) else { continue };
        let Tree::Object(members) = &tree else { continue };
        if std::mem::take(&mut is_first) && is_flockwave(&tree) {
            break;
        }
        let known = found.len();
        match form(&tree) {
            Form::Message(which, name, message) => {
                let at = members.iter().position(|(key, _)| key == which.key());
                let place = at.and_then(|at| places.get(at)).and_then(|place| text.get(place.clone()));
                let (topic, ty) = match which {
                    NameKind::Type => (None, Some(type_name(name))),
                    NameKind::Topic => (Some(name), found.types.get(name).cloned()),
                };
                found.add(topic, ty, message, place.unwrap_or_default());
            }
            Form::Advertised(topic, ty) => _ = found.types.insert(topic.to_owned(), type_name(ty)),
            Form::Skipped | Form::Unknown(_) => {}
        }
        known_in_a_row = if found.len() > known { 0 } else { known_in_a_row + 1 };
    }
    found.into_clues()
}

/// The facts in messages.
#[derive(Default)]
pub(crate) struct Found {
    clues: Clues,
    /// The formats of topics outside of PX4's folders, by name. In spite of its name, such a topic may have another
    /// type.
    guesses: BTreeMap<String, FormatClue>,
    /// The types of topics, by the topic's name.
    types: HashMap<String, String>,
    /// The total length of the stored messages, in bytes.
    num_bytes: usize,
}

impl Found {
    /// Adds a message of a JSON channel in a bag. Returns true if the message isn't empty.
    pub(crate) fn add_message(&mut self, topic: &str, ty: &str, payload: &[u8]) -> bool {
        let Ok(text) = std::str::from_utf8(payload) else { return false };
        let Ok(message) = Tree::read(text) else { return false };
        let ty = ty.contains('/').then(|| type_name(ty));
        self.add(Some(topic), ty, &message, text);
        shows_type(&message)
    }

    /// All facts.
    pub(crate) fn into_clues(mut self) -> Clues {
        for (topic, guess) in self.guesses {
            self.clues.formats.entry(topic).or_insert(guess);
        }
        self.clues
    }

    /// Adds the first non-empty message of a topic or type. If `ty`, the stated type, is known, an empty message is
    /// added until a non-empty message replaces it, because some types have no fields.
    fn add(&mut self, topic: Option<&str>, ty: Option<String>, message: &Tree<'_>, text: &str) {
        let Tree::Object(members) = message else { return };
        let Self { clues, guesses, num_bytes, .. } = self;
        let (version, is_typed) = (topic.and_then(version_of_topic), ty.is_some());
        let name = ty.unwrap_or_else(|| {
            let topic = topic_of(topic.unwrap_or_default());
            unversioned(topic).unwrap_or(topic).to_owned()
        });
        // Bridges may omit the version.
        if let Some(version) = version.filter(|version| *version > 0) {
            clues.topic_versions.entry(name.clone()).or_default().insert(version);
        }
        if members.is_empty() && !is_typed {
            return;
        }
        let mut json = || {
            let is_stored = text.len() <= MAX_CLUE_TEXT - *num_bytes;
            let text = if is_stored { text } else { "" };
            *num_bytes += text.len();
            let keys = keys_hash(members.iter().map(|(key, _)| &**key));
            JsonClue { keys, text: text.to_owned(), version }
        };
        if is_typed {
            let without_keys = keys_hash(iter::empty());
            let has_keys = |clue: &TypeClue| clue.json.as_ref().is_some_and(|json| json.keys != without_keys);
            let known = clues.types.get(&name);
            let is_final = known.is_some_and(|known| members.is_empty() || has_keys(known));
            if !is_final {
                clues.types.insert(name, TypeClue { json: Some(json()), ..TypeClue::default() });
            }
        } else {
            let is_of_px4 = topic.is_some_and(is_exchanged);
            let formats = if is_of_px4 { &mut clues.formats } else { guesses };
            formats.entry(name).or_insert_with(|| FormatClue::Json(json()));
        }
    }

    /// The number of known names.
    fn len(&self) -> usize {
        self.clues.types.len() + self.clues.formats.len() + self.guesses.len() + self.types.len()
    }
}

/// The full ROS name of a type. Replaces package names that only JSON uses, as in `px4/VehicleStatus`.
fn type_name(ty: &str) -> String {
    let full = full_name(ty);
    match full.split_once('/') {
        Some((package, name)) => format!("{}/{name}", ros_package(package)),
        None => full,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_of_px4_have_priority_and_show_versions() {
        let text = [
            r#"{"op":"publish","topic":"/robot/kite_v3","msg":{}}"#,
            r#"{"op":"publish","topic":"/fmu/out/battery_status_v1","msg":{}}"#,
            r#"{"op":"publish","topic":"/robot/battery_status","msg":{"level":3}}"#,
            r#"{"op":"publish","msg": {"timestamp":1} ,"topic":"/fmu/out/battery_status_v1"}"#,
            r#"{"op":"publish","topic":"/fmu/out/battery_status","msg":{"timestamp":2}}"#,
            r#"{"op":"publish","topic":"/robot/kite_v3","msg":{"pull":3}}"#,
        ]
        .join("\n");
        let found = clues(&mut Source { bytes: &mut text.as_bytes(), file: None, copy: None });
        let message = |topic: &str| match &found.formats[topic] {
            FormatClue::Json(JsonClue { text, version, .. }) => (text.as_str(), *version),
            FormatClue::Layout(_) => panic!("expected JSON"),
        };
        assert_eq!(message("battery_status"), (r#"{"timestamp":1}"#, Some(1)));
        assert_eq!(message("kite"), (r#"{"pull":3}"#, None));
        assert_eq!(found.topic_versions, [("battery_status".to_owned(), [1].into())].into());
    }

    #[test]
    fn messages_of_stated_types_may_lack_keys() {
        let text = [
            r#"{"type":"std_msgs/msg/Empty","message":{}}"#,
            r#"{"type":"px4/Kite","message":{}}"#,
            r#"{"type":"px4/Kite","message":{"pull":3}}"#,
            r#"{"type":"px4/Kite","message":{"pull":4}}"#,
            r#"{"type":"px4/Kite","message":{}}"#,
        ]
        .join("\n");
        let found = clues(&mut Source { bytes: &mut text.as_bytes(), file: None, copy: None });
        let message = |ty: &str| found.types[ty].json.as_ref().map(|json| json.text.as_str());
        assert_eq!(message("std_msgs/msg/Empty"), Some("{}"));
        assert_eq!(message("px4_msgs/msg/Kite"), Some(r#"{"pull":3}"#));
    }
}
