//! Finds the items that a name denotes.

use std::collections::BTreeMap;

use uavspec_lint::release::{entries, full_name};
use uavspec_rules::definitions::{ReleaseId, ros_package, unversioned};
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::{Element, Message};

use super::answer::Candidates;
use super::catalogue::{Catalogue, Definition};

/// The prefixes of the ROS 2 names of PX4 topics.
const NAMESPACES: [&str; 3] = ["/fmu/out/", "/fmu/in/", "/"];

/// An item that a name denotes.
pub(super) enum Target {
    /// A message or a service.
    Message(Box<Definition>),
    Field(Place),
    /// A constant, and the names of other definitions that have a constant with this name.
    Constant(Place, Vec<String>),
    /// Items of several messages.
    Several(Candidates),
}

/// A field or a constant.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The name to show, such as `vehicle_status.nav_state`.
    pub(super) path: String,
    /// The full name of the definition that declares the item.
    pub(super) definition: String,
    pub(super) release: ReleaseId,
    /// The name of the message, or of the part of the service.
    pub(super) message: String,
    pub(super) name: String,
}

/// The items that a word denotes, starting with the most specific one.
pub(super) fn find(catalogue: &Catalogue<'_>, word: &str) -> Vec<Target> {
    let word = NAMESPACES.iter().find_map(|start| word.strip_prefix(start)).unwrap_or(word);
    let mut found: Vec<Target> = definitions(catalogue, word)
        .into_iter()
        .map(|(name, release)| Target::Message(Box::new(catalogue.read(&name, release, None))))
        .collect();
    if let Some((first, rest)) = word.split_once('.') {
        for (name, release) in definitions(catalogue, first) {
            found.extend(newest_item(catalogue, &name, release, first, rest));
        }
    } else if found.is_empty() {
        found.extend(declared(catalogue, word));
    }
    found
}

/// The definitions that a topic or a name denotes. Uses the newest release that contains at least one of them.
fn definitions(catalogue: &Catalogue<'_>, word: &str) -> Vec<(String, ReleaseId)> {
    let unversioned = unversioned(word);
    let is_topic = |topic: &&str| *topic == word || unversioned == Some(topic);
    let rows = catalogue.rows().filter(|row| is_named(row.name, word) || row.topics.iter().any(is_topic));
    let newest = rows.filter_map(|row| Some((row.name.to_owned(), catalogue.newest(row.name)?)));
    newest_of_each_family(catalogue, &newest.collect())
}

/// True if a word denotes a full name: it is the full name, or parts of it, such as `px4/VehicleStatus`.
fn is_named(full_name: &str, word: &str) -> bool {
    let Some((package, name)) = word.rsplit_once('/') else {
        return full_name.rsplit('/').next() == Some(word);
    };
    let package = ros_package(package);
    full_name == word
        || full_name.rsplit_once('/').is_some_and(|(start, known)| {
            known == name && (start == package || start.split('/').next() == Some(package))
        })
}

/// For each family, the definitions in the newest release that contains any of them. Messages come before services.
fn newest_of_each_family(
    catalogue: &Catalogue<'_>,
    found: &BTreeMap<String, ReleaseId>,
) -> Vec<(String, ReleaseId)> {
    let index = catalogue.library().index();
    let rank = |release: ReleaseId| (!index.is_moving(release), release);
    let is_newest = |release: ReleaseId| {
        let family = found.values().filter(|other| index.family(**other) == index.family(release));
        family.map(|other| rank(*other)).max() == Some(rank(release))
    };
    found
        .iter()
        .filter(|(_, release)| is_newest(**release))
        .map(|(name, release)| (name.clone(), *release))
        .collect()
}

/// The item in the newest release of the definition. If that release lacks the item, the newest release that contains
/// the item is used.
fn newest_item(
    catalogue: &Catalogue<'_>,
    name: &str,
    newest: ReleaseId,
    first: &str,
    path: &str,
) -> Option<Target> {
    let family = catalogue.family(newest);
    let others = catalogue.releases().rev().filter(|release| catalogue.family(*release) == family);
    let releases = std::iter::once(newest).chain(others.filter(|release| *release != newest));
    let step = path.split(['.', '[']).next().unwrap_or(path);
    let declares = |release: &ReleaseId| {
        catalogue.text_of(name, *release).is_some_and(|text| names(text).any(|name| name == step))
    };
    { releases }.filter(declares).find_map(|release| item(&catalogue.read(name, release, None), first, path))
}

/// The field or constant of a definition that a path denotes. Array indices are ignored.
fn item(definition: &Definition, first: &str, path: &str) -> Option<Target> {
    let steps: Vec<&str> = path.split('.').map(|step| step.split('[').next().unwrap_or(step)).collect();
    let (last, steps) = steps.split_last()?;
    let place = |message: &Message, definition_name: String| Place {
        path: format!("{first}.{path}"),
        definition: definition_name,
        release: definition.release,
        message: message.name.clone(),
        name: (*last).to_owned(),
    };
    let schema = &definition.schema;
    for part in definition.parts() {
        let nested = steps.iter().try_fold(part, |message, step| {
            match message.fields.iter().find(|field| field.name == *step)?.ty.element {
                Element::Message(id) => Some(schema.message(id)),
                Element::Scalar(_) | Element::Text(_) | Element::String { .. } => None,
            }
        });
        let Some(message) = nested else { continue };
        let name = if steps.is_empty() { definition.name.clone() } else { ros_name(schema, message) };
        if message.fields.iter().any(|field| field.name == *last) {
            return Some(Target::Field(place(message, name)));
        }
        if message.constants.iter().any(|constant| constant.name == *last) {
            return Some(Target::Constant(place(message, name), Vec::new()));
        }
    }
    None
}

/// The fields or constants with this name in any definition. Uses the newest release that contains at least one of
/// them.
fn declared(catalogue: &Catalogue<'_>, word: &str) -> Vec<Target> {
    let index = catalogue.library().index();
    let mut found: BTreeMap<String, ReleaseId> = BTreeMap::new();
    // Releases that may still change come last.
    let mut releases: Vec<ReleaseId> = catalogue.releases().collect();
    releases.sort_by_key(|release| (!index.is_moving(*release), *release));
    for release in releases.into_iter().rev() {
        for entry in entries(catalogue.text(release)) {
            if names(entry.text).any(|name| name == word) {
                found.entry(full_name(&entry)).or_insert(release);
            }
        }
    }
    let all: Vec<String> = found.keys().cloned().collect();
    let newest = newest_of_each_family(catalogue, &found);
    let is_message = |(name, _): &&(String, ReleaseId)| name.contains("/msg/");
    let messages: Vec<&(String, ReleaseId)> = newest.iter().filter(is_message).collect();
    let best: Vec<&(String, ReleaseId)> =
        if messages.is_empty() { newest.iter().collect() } else { messages };
    match best.as_slice() {
        [] => Vec::new(),
        [(name, release)] => {
            let target = item(&catalogue.read(name, *release, None), &short(catalogue, name), word);
            let others = || all.iter().filter(|other| *other != name).cloned().collect();
            let with_others = |target| match target {
                Target::Constant(place, _) => Target::Constant(place, others()),
                target => target,
            };
            target.map(with_others).into_iter().collect()
        }
        several => {
            let candidates = several.iter().map(|(name, _)| format!("{}.{word}", short(catalogue, name)));
            vec![Target::Several(Candidates { name: word.to_owned(), candidates: candidates.collect() })]
        }
    }
}

/// The names of the fields and constants in a definition.
pub(super) fn names(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter_map(|line| declared_name(line))
}

/// The name that a line of a definition declares.
pub(super) fn declared_name(line: &str) -> Option<&str> {
    let (ty, rest) = line.split_once(' ')?;
    if ty.starts_with('#') { None } else { rest.split(['=', ' ']).next() }
}

/// A short name: the topic of a message, or the name without its package.
fn short(catalogue: &Catalogue<'_>, full_name: &str) -> String {
    let name = full_name.rsplit('/').next().unwrap_or(full_name);
    let row = catalogue.library().index().of_name(full_name).last();
    row.and_then(|row| row.topics.first()).map_or(name, |topic| topic).to_owned()
}
