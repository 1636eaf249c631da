//! Selects single definitions of a release.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::entries::{Entry, entries};
use super::text::write_heading;

/// The named definitions of a release, with the definitions that they refer to, in the text form of releases. The names
/// are full ROS names.
///
/// ```
/// use std::collections::BTreeSet;
/// use uavspec_lint::release::{full_name, entries, select};
///
/// let line = "=".repeat(80);
/// let text = format!("{line}\nMSG: sky/msg/A\nB b\n{line}\nMSG: sky/msg/B\nint8 b\n{line}\nMSG: sky/msg/C\nint8 c\n");
/// let selected = select(&text, &BTreeSet::from(["sky/msg/A"]));
/// let names: Vec<String> = entries(&selected).map(|entry| full_name(&entry)).collect();
/// assert_eq!(names, ["sky/msg/A", "sky/msg/B"]);
/// ```
pub fn select(text: &str, names: &BTreeSet<&str>) -> String {
    let all: HashMap<String, Entry<'_>> = entries(text).map(|entry| (full_name(&entry), entry)).collect();
    let mut open: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
    let mut found: BTreeMap<String, &Entry<'_>> = BTreeMap::new();
    while let Some(name) = open.pop() {
        let Some(entry) = all.get(&name) else { continue };
        if found.insert(name, entry).is_some() {
            continue;
        }
        for name in entry.text.lines().flat_map(references) {
            let (package, name) = name.split_once('/').unwrap_or((entry.package, name));
            open.push(format!("{package}/msg/{name}"));
        }
    }
    let mut selected = String::new();
    for (name, entry) in found {
        write_heading(&mut selected, entry.kind, &name);
        selected.push_str(entry.text);
    }
    selected
}

/// The full ROS name of a definition: `px4_msgs/msg/BatteryStatus`.
pub fn full_name(entry: &Entry<'_>) -> String {
    format!("{}/{}/{}", entry.package, entry.kind.name(), entry.name)
}

/// The names to which a line may refer: its type, and the messages of enums such as `[@enum BatteryStatus.WARNING]`.
fn references(line: &str) -> impl Iterator<Item = &str> {
    let (declaration, facts) = line.split_once(" # ").unwrap_or((line, ""));
    let ty = declaration.split([' ', '[']).next();
    let enums = facts.split([' ', ']', '|']).filter_map(|word| Some(word.split_once('.')?.0));
    ty.into_iter().chain(enums)
}
