//! The names that most rules need.

pub(super) use uavspec_schema::diagnostic::Level;
pub(super) use uavspec_schema::example::Example;
pub(super) use uavspec_schema::finding::Sides;
pub(super) use uavspec_schema::{Field, glider};

pub(super) use super::message::{Pair, both};
pub(super) use super::rule::{Category, Check, Rule, Sink};

/// Builds a page with warnings from the rows of its table.
macro_rules! boats {
    ($($row:literal),* $(,)?) => {
        Example {
            path: "boats.md",
            text: concat!(
                "# Boats\n\n## Warnings (codes 64-127)\n\n",
                "| Code | Abbr | Description |\n|-----:|------|-------------|\n",
                $($row, "\n"),*
            ),
        }
    };
}
pub(super) use boats;

/// Builds the event metadata of a component from its members after the namespace.
macro_rules! boat_events {
    ($($line:literal),* $(,)?) => {
        Example {
            path: "events.json",
            text: concat!(
                "{\"version\": 2, \"components\": {\"9\": {\"namespace\": \"boat\",\n",
                $($line, "\n",)* "}}}\n"
            ),
        }
    };
}
pub(super) use boat_events;
