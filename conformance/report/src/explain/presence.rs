//! The releases that contain a definition or an item, and the changes in each of them.

use uavspec_lint::release::{Change, Step};
use uavspec_rules::definitions::Family;

use super::answer::{Changes, Presence};
use super::catalogue::Catalogue;

/// The rules of `breaking` that report an item with a new name.
const RENAMES: [&str; 2] = ["field-renamed", "constant-renamed"];

/// The presence of a definition, based on its history.
pub(super) fn of_definition(catalogue: &Catalogue<'_>, family: Family, steps: &[Step]) -> Presence {
    let is_present: Vec<bool> = steps.iter().map(|step| step.name.is_some()).collect();
    let changes = steps.iter().map(|step| step.changes.iter().collect()).collect();
    presence(catalogue, family, steps, &is_present, changes)
}

/// The presence of a field or a constant. If it was renamed, its history continues under the older name.
pub(super) fn of_item(catalogue: &Catalogue<'_>, family: Family, steps: &[Step], item: &str) -> Presence {
    let mut name = item.to_owned();
    let (mut is_present, mut changes) = (Vec::new(), Vec::new());
    for step in steps.iter().rev() {
        let is_in = step.fields.contains(&name) || step.constants.contains_key(&name);
        let is_about = |change: &&Change| {
            [&change.old, &change.new].into_iter().any(|found| found.as_deref() == Some(&name))
        };
        let is_whole = |change: &&Change| change.old.is_none() && change.new.is_none() && is_presence(change);
        let mut own: Vec<&Change> = step.changes.iter().filter(is_about).collect();
        if own.is_empty() && (is_in || is_present.last() == Some(&true)) {
            own = step.changes.iter().filter(is_whole).collect();
        }
        let renamed =
            own.iter().find(|change| RENAMES.contains(&change.rule) && change.new.as_deref() == Some(&name));
        if let Some(old) = renamed.and_then(|change| change.old.clone()) {
            name = old;
        }
        is_present.push(is_in);
        changes.push(own);
    }
    is_present.reverse();
    changes.reverse();
    presence(catalogue, family, steps, &is_present, changes)
}

/// True if a change adds, removes or renames the definition itself.
fn is_presence(change: &Change) -> bool {
    matches!(change.rule, "message-added" | "message-removed" | "message-renamed")
}

fn presence(
    catalogue: &Catalogue<'_>,
    family: Family,
    steps: &[Step],
    is_present: &[bool],
    changes: Vec<Vec<&Change>>,
) -> Presence {
    let label = |step: &Step| format!("{}@{}", family.name(), step.release);
    let is_meant = |step: &Step| catalogue.includes(&label(step));
    let first = is_present.iter().position(|is_present| *is_present).filter(|first| *first > 0);
    let present = steps.iter().zip(is_present).filter(|(step, is_present)| **is_present && is_meant(step));
    let history = steps.iter().zip(changes).filter(|(step, changes)| !changes.is_empty() && is_meant(step));
    Presence {
        since: first.map(|first| label(&steps[first])),
        releases: present.map(|(step, _)| label(step)).collect(),
        history: history
            .map(|(step, changes)| Changes {
                release: label(step),
                changes: changes.into_iter().map(|change| change.message.replace('`', "")).collect(),
            })
            .collect(),
    }
}
