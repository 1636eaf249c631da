//! The built-in packages of ROS 2.

use std::collections::BTreeSet;

use uavspec_definitions::releases::releases;
use uavspec_lint::release::{self, Entry, entries};
use uavspec_schema::msg::Dialect;
use uavspec_schema::read::PackageInput;
use uavspec_schema::source::SourceMap;

/// The distribution whose packages are used: the newest one with long-term support.
const DISTRIBUTION: &str = "jazzy";

/// The built-in packages that a reader needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum BuiltIn {
    /// The packages that the definitions refer to. Only the referenced messages appear in the output.
    #[default]
    Referenced,
    /// All messages that are the same in all distributions. Captures can contain any of them.
    All,
}

/// The common interfaces of ROS 2.
pub(super) fn ros_packages(which: BuiltIn, sources: &mut SourceMap) -> Vec<PackageInput> {
    let dialect = Dialect::Ros2;
    let texts = releases().filter(|release| release.family() == dialect.name());
    let (newest, others): (Vec<_>, Vec<_>) =
        texts.map(|release| (release.name(), release.text())).partition(|(name, _)| *name == DISTRIBUTION);
    let Some((_, text)) = newest.first() else { return Vec::new() };
    let folder = format!("{dialect}@{DISTRIBUTION}/");
    let mut packages = release::packages(text, dialect, &folder, sources);
    let of = |text| entries(text).map(|entry: Entry<'_>| (entry.package, entry.name, fields(entry.text)));
    let current: BTreeSet<_> = of(text).collect();
    let other = others.iter().flat_map(|(_, text)| of(text)).filter(|entry| !current.contains(entry));
    let differing: BTreeSet<String> =
        other.map(|(package, name, _)| format!("{folder}{package}/{name}.")).collect();
    for package in &mut packages {
        package.origin = Some(format!("the definitions of ROS 2 {DISTRIBUTION} in uavspec"));
        match which {
            BuiltIn::Referenced => package.select = Some(Vec::new()),
            BuiltIn::All => package.sources.retain(|id| {
                let path = sources.path(*id);
                !differing.iter().any(|differing| path.starts_with(differing))
            }),
        }
    }
    packages
}

/// The types and names of the fields of a definition. Captures don't contain its constants and defaults.
fn fields(text: &str) -> Vec<(&str, &str)> {
    let is_field = |line: &&str| !line.replace("<=", "").contains('=');
    text.lines().filter(is_field).map(first_words).collect()
}

fn first_words(line: &str) -> (&str, &str) {
    let mut words = line.split_ascii_whitespace();
    (words.next().unwrap_or_default(), words.next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_packages_can_be_read_without_the_messages_that_differ() {
        for (which, has_range) in [(BuiltIn::Referenced, true), (BuiltIn::All, false)] {
            let mut sources = SourceMap::default();
            let mut packages = ros_packages(which, &mut sources);
            for package in &mut packages {
                package.select = None;
            }
            let (schema, diagnostics) = uavspec_schema::read(&sources, &packages);
            assert_eq!(diagnostics, []);
            let has = |name| schema.messages.iter().any(|message| message.name == name);
            // Range has one more field since Jazzy.
            assert_eq!((has("Range"), has("Marker"), has("Header")), (has_range, true, true));
        }
    }
}
