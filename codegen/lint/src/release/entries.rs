//! Splits a text that contains several definitions.

use std::collections::BTreeMap;

use uavspec_schema::Form;
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::read::{PX4_ROS_PACKAGE, PackageInput};
use uavspec_schema::source::SourceMap;

/// The minimum length of a separator line. All writers use 80 characters.
const MIN_SEPARATOR: usize = 40;

/// All kinds of definitions.
const KINDS: [Kind; 3] = [Kind::Message, Kind::Service, Kind::Action];

/// A definition in a text with several definitions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry<'t> {
    /// The kind of the definition.
    pub kind: Kind,
    /// The ROS package; empty if the name contains none.
    pub package: &'t str,
    /// The name.
    pub name: &'t str,
    /// The definition, as in its file.
    pub text: &'t str,
}

/// The definitions after separators. Text before the first separator is not part of the result.
pub fn entries(text: &str) -> impl Iterator<Item = Entry<'_>> {
    sections(text, &KINDS).into_iter().filter_map(|section| {
        let (kind, full_name) = section.heading?;
        let (package, name) = full_name.rsplit_once('/').unwrap_or(("", full_name));
        let package =
            package.strip_suffix(kind.name()).and_then(|rest| rest.strip_suffix('/')).unwrap_or(package);
        Some(Entry { kind, package, name, text: section.text })
    })
}

/// The definitions of a release as packages. `folder` is the start of the definitions' paths.
pub fn packages(text: &str, dialect: Dialect, folder: &str, sources: &mut SourceMap) -> Vec<PackageInput> {
    let mut packages: BTreeMap<&str, PackageInput> = BTreeMap::new();
    for entry in entries(text) {
        let Entry { kind, package, name, text } = entry;
        let path = format!("{folder}{package}/{name}.{}", kind.name());
        let Ok(source) = sources.add(path, text.into()) else { continue };
        let input = packages.entry(package).or_insert_with(|| {
            let own_name = match (dialect, package) {
                (Dialect::Px4, "" | PX4_ROS_PACKAGE) => dialect.name(),
                _ => package,
            };
            PackageInput::new(own_name, Form::Msg(dialect), Vec::new())
        });
        input.sources.push(source);
    }
    packages.into_values().collect()
}

/// A part of a text with several definitions.
#[derive(Clone, Copy, Debug)]
pub struct Section<'t> {
    /// The kind and the name on the line after the separator. `None` for the text before the first separator.
    pub heading: Option<(Kind, &'t str)>,
    /// The text up to the next separator.
    pub text: &'t str,
}

/// Splits a text at its separators: a line of `=` characters, and a line such as `MSG: package/Name`. Only definitions of
/// these kinds start a section.
pub fn sections<'t>(text: &'t str, kinds: &[Kind]) -> Vec<Section<'t>> {
    let mut found = Vec::new();
    let (mut heading, mut start, mut at) = (None, 0, 0);
    let mut lines = text.split_inclusive('\n').peekable();
    while let Some(line) = lines.next() {
        let end = at + line.len();
        let bare = line.trim();
        let is_separator = bare.len() >= MIN_SEPARATOR && bare.bytes().all(|byte| byte == b'=');
        if is_separator && let Some(next) = lines.peek().and_then(|line| heading_of(line, kinds)) {
            found.push(Section { heading, text: &text[start..at] });
            let length = lines.next().map_or(0, str::len);
            (heading, start, at) = (Some(next), end + length, end + length);
        } else {
            at = end;
        }
    }
    found.push(Section { heading, text: &text[start..] });
    found
}

/// The kind and the name in a heading line, such as `MSG: package/Name`.
fn heading_of<'t>(line: &'t str, kinds: &[Kind]) -> Option<(Kind, &'t str)> {
    let (word, name) = line.trim().split_once(": ")?;
    let kind = kinds.iter().find(|kind| heading_word(**kind) == word)?;
    Some((*kind, name.trim()))
}

/// The word before the name of a definition.
pub(super) fn heading_word(kind: Kind) -> &'static str {
    match kind {
        Kind::Message => "MSG",
        Kind::Service => "SRV",
        Kind::Action => "ACTION",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_at_separators_with_a_name() {
        let line = "=".repeat(80);
        let text = format!(
            "about\n{line}\nMSG: sky_msgs/msg/Mark\nint16 height\n# ====\n{line}\nno heading\n{line}\r\n\
             SRV: Fly\r\n---\n{line}\nACTION: sky_msgs/Land\n---\n---"
        );
        let found: Vec<Entry<'_>> = entries(&text).collect();
        let own = format!("int16 height\n# ====\n{line}\nno heading\n");
        assert_eq!(
            found,
            [
                Entry { kind: Kind::Message, package: "sky_msgs", name: "Mark", text: &own },
                Entry { kind: Kind::Service, package: "", name: "Fly", text: "---\n" },
                Entry { kind: Kind::Action, package: "sky_msgs", name: "Land", text: "---\n---" },
            ]
        );
        assert_eq!(sections("", &KINDS).len(), 1);
        assert_eq!(sections(&format!("{line}\n"), &KINDS).len(), 1);
    }
}
