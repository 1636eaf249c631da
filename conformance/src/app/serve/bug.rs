//! The bugs of `uavspec serve`.

use serde_json::json;
use uavspec_model::text::terminal;
use uavspec_probe::self_test;
use uavspec_rules::flockwave::{self, FlockwaveRule};
use uavspec_rules::px4::{self, Bug, Side};

use super::ServeArgs;
use crate::app::Format;

/// A rule that a reference violates on purpose.
#[derive(Clone, Debug)]
pub(super) struct ServedBug {
    id: &'static str,
    description: &'static str,
    /// The other rules that the bug also violates.
    also: Vec<&'static str>,
    /// The bug of a Flockwave server that violates the rule.
    pub(super) of_server: Option<&'static FlockwaveRule>,
    /// The bug of a reference PX4 participant that violates the rule.
    pub(super) of_vehicle: Option<&'static Bug>,
}

impl ServedBug {
    /// Finds the bug that violates a rule. The error describes the problem.
    pub(super) fn find(id: &str) -> Result<Self, String> {
        let bug = bugs().find(|bug| bug.id == id);
        bug.ok_or_else(|| "no bug violates this rule; --list-bugs lists all bugs".to_owned())
    }

    /// The options that run the reference with this bug. `None` if it is a Flockwave server.
    fn options(&self) -> Option<&'static str> {
        match self.of_vehicle?.side {
            Side::Autopilot => Some("--px4 URL"),
            Side::Component => Some("--px4 URL --component"),
        }
    }
}

/// All bugs.
fn bugs() -> impl Iterator<Item = ServedBug> {
    let of_server = |rule: &'static FlockwaveRule| ServedBug {
        id: rule.rule.id,
        description: rule.bug.description,
        also: rule.bug.also.iter().map(|rule| rule.id).collect(),
        of_server: Some(rule),
        of_vehicle: None,
    };
    let of_vehicle = |(id, bug): (&'static str, &'static Bug)| ServedBug {
        id,
        description: bug.description,
        also: bug.also.iter().map(|also| also.rule.id).collect(),
        of_server: None,
        of_vehicle: Some(bug),
    };
    let of_vehicles = px4::RULES.into_iter().filter_map(|entry| Some((entry.rule.id, entry.bug.as_ref()?)));
    flockwave::RULES.into_iter().map(of_server).chain(of_vehicles.map(of_vehicle))
}

/// The error if the selected reference doesn't have the bug.
pub(super) fn misplaced(args: &ServeArgs) -> Option<String> {
    let bug = args.bug.as_ref()?;
    let given = args.px4.as_ref().map(|_| if args.component { "--px4 URL --component" } else { "--px4 URL" });
    let id = bug.id;
    if let (Some(vehicle), Some(address)) = (bug.of_vehicle, &args.px4)
        && let Some(missing) = self_test::vehicle::missing(vehicle.needs, address)
    {
        return Some(format!("--bug {id} requires {missing}"));
    }
    (bug.options() != given).then(|| match bug.options() {
        Some(options) => format!("--bug {id} is a bug of another reference: use {options}"),
        None => format!("--bug {id} is a bug of the Flockwave server: omit --px4"),
    })
}

/// Prints the bug.
pub(super) fn announce(bug: Option<&ServedBug>) {
    if let Some(ServedBug { id, description, .. }) = bug {
        terminal::eprintln!("bug {id}: {description}");
    }
}

/// Prints all bugs.
pub(super) fn list(format: Format) {
    for bug in bugs() {
        let ServedBug { id, description, also, .. } = &bug;
        match format {
            Format::Text => {
                let also = if also.is_empty() {
                    String::new()
                } else {
                    format!(" Also violates {}.", also.join(", "))
                };
                let options = bug.options().map(|options| format!(" ({options})")).unwrap_or_default();
                terminal::println!("{id:<18} {description}{also}{options}");
            }
            Format::Json => {
                let mut object = json!({ "rule": id, "what": description, "also": also });
                if let Some(options) = bug.options() {
                    object["options"] = options.into();
                }
                terminal::println!("{object}");
            }
        }
    }
}
