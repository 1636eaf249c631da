//! The built-in packages of ROS 2.

use std::collections::BTreeSet;

use crate::msg::Dialect;
use crate::read::PackageInput;
use crate::release::{self, Entry, entries};
use crate::source::SourceMap;
use uavspec_definitions::releases::RELEASES;

/// The distribution whose packages are used: the newest one with long-term support.
const DISTRIBUTION: &str = "jazzy";

/// The built-in packages that a reader needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BuiltIn {
    /// Those that the definitions refer to. Only the referenced messages appear in the output.
    Referenced,
    /// All messages that don't differ between distributions, because captures also contain other messages.
    All,
}

/// The common interfaces of ROS 2.
pub(super) fn ros_packages(which: BuiltIn, sources: &mut SourceMap) -> Vec<PackageInput> {
    let dialect = Dialect::Ros2;
    let texts = RELEASES.iter().filter(|release| release.family == dialect.name());
    let (newest, others): (Vec<_>, Vec<_>) =
        texts.map(|release| (release.name, release.text())).partition(|(name, _)| *name == DISTRIBUTION);
    let Some((_, text)) = newest.first() else { return Vec::new() };
    let folder = format!("{dialect}@{DISTRIBUTION}/");
    let mut packages = release::packages(text, dialect, &folder, sources);
    let of = |text| entries(text).map(|entry: Entry<'_>| (entry.package, entry.name, entry.text));
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
