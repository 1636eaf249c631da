//! The facts in JSON messages that show their release.

use std::collections::HashMap;
use std::io::Read;

use uavspec_codegen::release::keys_hash;

use super::envelope::{Form, NameKind, form};
use super::{MAX_CHANNELS, is_flockwave};
use crate::capture::json::{Event, Reader};
use crate::check::Source;
use crate::check::topic::{full_name, topic_of};
use crate::definitions::{Clues, FormatClue, TypeClue, ros_package, unversioned};
use crate::json::Tree;

/// The maximum number of bytes that are read.
const MAX_BYTES: u64 = 1 << 20;

/// The maximum number of values in a row that show nothing new.
const MAX_KNOWN: u32 = 200;

/// Reads the keys of the first message of each topic and type.
pub(super) fn clues(source: &mut Source<'_>) -> Clues {
    let mut reader = Reader::new(source.bytes.take(MAX_BYTES));
    let (mut found, mut is_first, mut known_in_a_row) = (Found::default(), true, 0);
    while known_in_a_row < MAX_KNOWN
        && found.len() < MAX_CHANNELS
        && let Ok(Some(item)) = reader.next()
    {
        let Event::Value { bytes, .. } = item.event else { continue };
        let tree = std::str::from_utf8(bytes).ok().and_then(|text| Tree::read(text).ok());
        let Some(tree) = tree.filter(|tree| matches!(tree, Tree::Object(_))) else { continue };
        if std::mem::take(&mut is_first) && is_flockwave(&tree) {
            break;
        }
        let known = found.len();
        found.add(&form(&tree));
        known_in_a_row = if found.len() > known { 0 } else { known_in_a_row + 1 };
    }
    found.clues
}

/// The facts in messages.
#[derive(Default)]
pub(in crate::check) struct Found {
    pub(in crate::check) clues: Clues,
    /// The types of topics, by the topic's name.
    types: HashMap<String, String>,
}

impl Found {
    /// Adds a message of a JSON channel in a bag.
    pub(in crate::check) fn add_message(&mut self, topic: &str, ty: &str, payload: &[u8]) {
        let tree = std::str::from_utf8(payload).ok().and_then(|text| Tree::read(text).ok());
        let Some(tree) = tree else { return };
        let (kind, name) = if ty.contains('/') { (NameKind::Type, ty) } else { (NameKind::Topic, topic) };
        self.add(&Form::Message(kind, name, &tree));
    }

    fn add(&mut self, form: &Form<'_>) {
        match form {
            Form::Message(which, name, Tree::Object(members)) => {
                let keys = || keys_hash(members.iter().map(|(key, _)| &**key));
                let ty = match which {
                    NameKind::Type => Some(type_name(name)),
                    NameKind::Topic => self.types.get(*name).cloned(),
                };
                if let Some(ty) = ty {
                    let clue = || TypeClue { keys: Some(keys()), ..TypeClue::default() };
                    self.clues.types.entry(ty).or_insert_with(clue);
                } else {
                    let topic = topic_of(name);
                    let topic = unversioned(topic).unwrap_or(topic).to_owned();
                    self.clues.formats.entry(topic).or_insert_with(|| FormatClue::Keys(keys()));
                }
            }
            Form::Advertised(topic, ty) => _ = self.types.insert((*topic).to_owned(), type_name(ty)),
            _ => {}
        }
    }

    /// The number of known names.
    fn len(&self) -> usize {
        self.clues.types.len() + self.clues.formats.len() + self.types.len()
    }
}

/// The full ROS name of a type, which may be named after its package here: `px4/VehicleStatus`.
fn type_name(ty: &str) -> String {
    let full = full_name(ty);
    match full.split_once('/') {
        Some((package, name)) => format!("{}/{name}", ros_package(package)),
        None => full,
    }
}
