//! The names that most rules need.

pub(super) use uavspec_schema::diagnostic::{Diagnostic, Level};
pub(super) use uavspec_schema::example::Example;
pub(super) use uavspec_schema::finding::Edit;
pub(super) use uavspec_schema::glider;
pub(super) use uavspec_schema::source::SourceMap;

pub(super) use super::rule::{Check, Levels, Measured, Rule, Scope, Sink, no_fix};
pub(super) use super::subject::Subject;

/// Builds an example page from the rows of its only table.
macro_rules! winch {
    (codes: $($row:literal),* $(,)?) => {
        Example {
            path: "winch.md",
            text: concat!(
                "# Winch\n\n## Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n|-----:|------|-------------|\n",
                $($row, "\n"),*
            ),
        }
    };
    (fields: $($row:literal),* $(,)?) => {
        Example {
            path: "winch.md",
            text: concat!(
                "# Winch\n\n## Rope\n\n| Field | Required | Type | Description |\n\
                 |-------|----------|------|-------------|\n",
                $($row, "\n"),*
            ),
        }
    };
}
pub(super) use winch;

/// Builds example event metadata: a component with these members after its namespace.
macro_rules! winch_events {
    (version $version:literal: $($line:literal),* $(,)?) => {
        Example {
            path: "events.json",
            text: concat!(
                "{\"version\": ", $version, ", \"components\": {\"9\": {\"namespace\": \"winch\",\n",
                $($line, "\n",)* "}}}\n"
            ),
        }
    };
    ($($line:literal),* $(,)?) => { winch_events![version 2: $($line),*] };
}
pub(super) use winch_events;

/// Builds an example catalogue from the contexts, texts and translations of its entries.
macro_rules! ukrainian {
    ($($context:literal, $text:literal, $translation:literal);* $(;)?) => {
        Example {
            path: "uk.po",
            text: concat!(
                "msgid \"\"\nmsgstr \"\"\n\"Content-Type: text/plain; charset=UTF-8\\n\"\n",
                $("\nmsgctxt \"", $context, "\"\nmsgid \"", $text, "\"\nmsgstr \"", $translation, "\"\n"),*
            ),
        }
    };
}
pub(super) use ukrainian;
