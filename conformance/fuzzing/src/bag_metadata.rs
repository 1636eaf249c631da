//! Texts of `metadata.yaml` that follow its grammar, in all YAML styles. Random bytes would rarely be valid YAML.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use uavspec_capture::rosbag::metadata::Metadata;

use super::Choices;

/// The names of files in the forms in which rosbag2 and people write them, each with the name that must be read.
const FILES: [(&str, &str); 5] = [
    ("a_0.db3", "a_0.db3"),
    ("old/a_1.db3", "a_1.db3"),
    ("old\\a_2.db3", "a_2.db3"),
    ("a 3: x.mcap", "a 3: x.mcap"),
    ("../ä.mcap.zstd", "ä.mcap.zstd"),
];

/// Values of keys that a check ignores.
const OTHERS: [&str; 6] = ["7", "~", "{nanoseconds: 3, more: [a, {b: c}]}", "[]", "\"x: y\"", "!t &a v"];

impl Choices<'_> {
    /// A text in one of the quoting styles. `plain` is false if the text must be quoted.
    fn scalar(&mut self, text: &str, plain: bool) -> String {
        match (self.below(3), plain) {
            (0, true) => text.to_owned(),
            (1, _) => format!("'{}'", text.replace('\'', "''")),
            _ => format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"")),
        }
    }
}

/// A text that the bytes select, and the metadata that it contains.
fn written(data: &[u8]) -> (String, Metadata) {
    let mut choices = Choices::new(data);
    let unit = " ".repeat(choices.below(4) + 1);
    let mut metadata =
        Metadata { storage: choices.of(&["sqlite3", "mcap"]).to_owned(), ..Metadata::default() };
    let mut entries = vec![format!("storage_identifier: {}", choices.scalar(&metadata.storage, true))];
    if choices.below(4) > 0 {
        let count = [7, 0, 1_000_000_000_000][choices.below(3)];
        metadata.message_count = Some(count);
        entries.push(format!("message_count: {count}"));
    }
    if choices.below(4) > 0 {
        choices.of(&["jazzy", "humble", ""]).clone_into(&mut metadata.distribution);
        entries.push(format!("ros_distro: {}", choices.scalar(&metadata.distribution, false)));
    }
    entries.push(files(&mut choices, &unit, &mut metadata.files));
    entries.push(topics(&mut choices, &unit, &mut metadata.encodings));
    for key in ["version", "starting_time", "compression_mode"] {
        entries.push(format!("{key}: {}", choices.of(&OTHERS)));
    }
    let mut text = choices.of(&["", "---\n", "# a bag\n"]).to_owned() + "rosbag2_bagfile_information:\n";
    while !entries.is_empty() {
        let entry = entries.swap_remove(choices.below(entries.len()));
        for line in entry.lines() {
            // Writing to a `String` can't fail.
            let _ = writeln!(text, "{unit}{line}{}", choices.of(&["", "", " # note"]));
        }
    }
    (if choices.below(3) == 2 { text.replace('\n', "\r\n") } else { text }, metadata)
}

/// The list of files.
fn files(choices: &mut Choices<'_>, unit: &str, known: &mut Vec<String>) -> String {
    let names: Vec<(&str, &str)> = (0..choices.below(6)).map(|_| choices.of(&FILES)).collect();
    for (_, name) in &names {
        if !known.iter().any(|known| known == name) {
            known.push((*name).to_owned());
        }
    }
    let items: Vec<String> = names.iter().map(|(text, _)| choices.scalar(text, false)).collect();
    if items.is_empty() || choices.below(2) == 1 {
        return format!("relative_file_paths: [{}]", items.join(", "));
    }
    items.iter().fold("relative_file_paths:".to_owned(), |text, item| text + "\n" + unit + "- " + item)
}

/// The list of topics.
fn topics(choices: &mut Choices<'_>, unit: &str, encodings: &mut BTreeMap<String, String>) -> String {
    let mut text = "topics_with_message_count:".to_owned();
    let count = choices.below(4);
    for number in 0..count {
        let (name, encoding) = (format!("/kite{number}/winch"), choices.of(&["cdr", "json", "odd one"]));
        encodings.insert(name.clone(), encoding.to_owned());
        let [name, value] = [&name, encoding].map(|text| choices.scalar(text, false));
        let topic = if choices.below(2) == 0 {
            format!(
                "\n- topic_metadata:\n{unit}{unit}{unit}name: {name}\n{unit}{unit}{unit}serialization_format: {value}\n  message_count: 1"
            )
        } else {
            format!(
                "\n- {{topic_metadata: {{name: {name}, serialization_format: {value}}}, message_count: 1}}"
            )
        };
        text.push_str(&topic);
    }
    if count == 0 { text + " []" } else { text }
}

/// Writes metadata in the styles that the bytes select, and reads it. The last two bytes may corrupt the text. The
/// result must contain nothing that isn't in the text.
pub(super) fn grammar(data: &[u8]) {
    let (text, expected) = written(data);
    let read = Metadata::parse(text.as_bytes()).unwrap_or_else(|| panic!("unreadable: {text}"));
    assert_eq!(
        (&read.storage, &read.distribution, read.message_count),
        (&expected.storage, &expected.distribution, expected.message_count),
        "{text}"
    );
    assert!(read.problems.is_empty(), "{:?}: {text}", read.problems);
    assert_eq!((&read.files, &read.encodings), (&expected.files, &expected.encodings), "{text}");
    if let [.., at, byte] = data {
        let mut changed = text.into_bytes();
        let at = usize::from(*at) * changed.len() / 256;
        changed[at] = *byte;
        super::captures::bag_metadata(&changed);
        changed.truncate(at);
        super::captures::bag_metadata(&changed);
    }
}
