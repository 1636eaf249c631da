//! The histories of definitions in the releases of their packages.

use std::collections::BTreeMap;

use uavspec_lint::release::{Releases, Step, history};
use uavspec_schema::fingerprint::{interface_name, ros_name};
use uavspec_schema::{Form, Kind, Package, Schema};

/// The histories of the definitions in packages with releases, by full ROS name.
pub(super) type Histories = BTreeMap<String, Vec<Step>>;

pub(super) fn histories(schema: &Schema, releases: &Releases) -> Histories {
    let mut histories = Histories::new();
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
    histories
}

/// The full ROS names of the definitions in a package.
fn names(schema: &Schema, package: &Package) -> Vec<String> {
    let messages = package.messages.iter().map(|id| schema.message(*id));
    let messages = messages.filter(|message| message.kind == Kind::Message);
    let interfaces = package.interfaces.iter().map(|interface| interface_name(package, interface));
    messages.map(|message| ros_name(schema, message)).chain(interfaces).collect()
}
