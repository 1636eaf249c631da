//! The bugs of `uavspec serve`.

use serde_json::json;
use uavspec_model::Rule;
use uavspec_model::text::terminal;
use uavspec_probe::self_test;
use uavspec_rules::flockwave::{self, FlockwaveRule};
use uavspec_rules::px4::{self, Bug, Side};

use super::ServeArgs;
use crate::app::Format;

/// A rule that a reference violates on purpose.
#[derive(Clone, Copy, Debug)]
pub(super) enum ServedBug {
    /// A rule for Flockwave servers.
    Server(&'static FlockwaveRule),
    /// A rule for PX4 vehicles.
    Vehicle(&'static Rule, &'static Bug),
}

impl ServedBug {
    /// The bug that violates a rule.
    pub(super) fn find(id: &str) -> Result<Self, String> {
        let vehicle = || vehicle_bugs().find(|bug| bug.rule().id == id);
        let bug = flockwave::rule(id).map(Self::Server).or_else(vehicle);
        bug.ok_or_else(|| "no bug violates this rule; --list-bugs lists all bugs".to_owned())
    }

    /// The bug of a Flockwave server.
    pub(super) fn of_server(self) -> Option<&'static FlockwaveRule> {
        match self {
            Self::Server(rule) => Some(rule),
            Self::Vehicle(..) => None,
        }
    }

    /// The bug of a participant of a vehicle's bus.
    pub(super) fn of_vehicle(self) -> Option<&'static Bug> {
        match self {
            Self::Server(_) => None,
            Self::Vehicle(_, bug) => Some(bug),
        }
    }

    fn rule(self) -> &'static Rule {
        match self {
            Self::Server(FlockwaveRule { rule, .. }) | Self::Vehicle(rule, _) => rule,
        }
    }

    fn description(self) -> &'static str {
        match self {
            Self::Server(FlockwaveRule { bug, .. }) => bug.description,
            Self::Vehicle(_, bug) => bug.description,
        }
    }

    /// The other rules that the bug violates.
    fn also(self) -> Vec<&'static str> {
        match self {
            Self::Server(FlockwaveRule { bug, .. }) => bug.also.iter().map(|rule| rule.id).collect(),
            Self::Vehicle(_, bug) => bug.also.iter().map(|also| also.rule.id).collect(),
        }
    }

    /// The options that select the reference with this bug.
    fn options(self) -> Option<&'static str> {
        match self.of_vehicle()?.side {
            Side::Autopilot => Some("--px4 URL"),
            Side::Component => Some("--px4 URL --component"),
        }
    }
}

/// All bugs.
fn bugs() -> impl Iterator<Item = ServedBug> {
    flockwave::RULES.into_iter().map(ServedBug::Server).chain(vehicle_bugs())
}

fn vehicle_bugs() -> impl Iterator<Item = ServedBug> {
    px4::RULES.into_iter().filter_map(|entry| Some(ServedBug::Vehicle(&entry.rule, entry.bug.as_ref()?)))
}

/// An error if the reference doesn't have the bug.
pub(super) fn misplaced(args: &ServeArgs) -> Option<String> {
    let bug = args.bug?;
    let given = args.px4.as_ref().map(|_| if args.component { "--px4 URL --component" } else { "--px4 URL" });
    let id = bug.rule().id;
    if let (Some(vehicle), Some(address)) = (bug.of_vehicle(), &args.px4)
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
pub(super) fn announce(bug: Option<ServedBug>) {
    if let Some(bug) = bug {
        terminal::eprintln!("bug {}: {}", bug.rule().id, bug.description());
    }
}

/// Prints all bugs.
pub(super) fn list(format: Format) {
    for bug in bugs() {
        let (id, also) = (bug.rule().id, bug.also());
        match format {
            Format::Text => {
                let also = if also.is_empty() {
                    String::new()
                } else {
                    format!(" Also violates {}.", also.join(", "))
                };
                let options = bug.options().map(|options| format!(" ({options})")).unwrap_or_default();
                terminal::println!("{id:<18} {}{also}{options}", bug.description());
            }
            Format::Json => {
                let mut object = json!({ "rule": id, "what": bug.description(), "also": also });
                if let Some(options) = bug.options() {
                    object["options"] = options.into();
                }
                terminal::println!("{object}");
            }
        }
    }
}
