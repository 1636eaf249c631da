//! The histories of definitions in the releases of their packages.

use std::collections::BTreeMap;

use uavspec_lint::release::{Releases, Step, history};
use uavspec_schema::fingerprint::{interface_name, ros_name};
use uavspec_schema::{Form, Kind, Package, Schema};

/// The histories of all definitions of packages with releases.
#[derive(Debug, Default)]
pub(super) struct Histories(BTreeMap<String, Vec<Step>>);

impl Histories {
    pub(super) fn new(schema: &Schema, releases: &Releases) -> Self {
        let mut histories = BTreeMap::new();
        for package in &schema.packages {
            let (Some(releases), Form::Msg(dialect)) = (releases.get(&package.name), package.form) else {
                continue;
            };
            for name in names(schema, package) {
                let steps = history(releases, dialect, &name);
                if steps.iter().any(|step| step.name.is_some()) {
                    histories.insert(name, steps);
                }
            }
        }
        Self(histories)
    }

    /// The history of a definition, by its full ROS name.
    pub(super) fn get(&self, name: &str) -> Option<&[Step]> {
        self.0.get(name).map(Vec::as_slice)
    }
}

/// The full ROS names of the definitions in a package.
fn names(schema: &Schema, package: &Package) -> Vec<String> {
    let messages = package.messages.iter().map(|id| schema.message(*id));
    let messages = messages.filter(|message| message.kind == Kind::Message);
    let interfaces = package.interfaces.iter().map(|interface| interface_name(package, interface));
    messages.map(|message| ros_name(schema, message)).chain(interfaces).collect()
}
