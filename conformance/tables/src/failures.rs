//! The captures that can't be read.

use uavspec_report::Unreadable;

use super::column::{Column, Table};

pub(super) static TABLE: Table<Unreadable> = Table {
    name: "failures",
    description: "A file or object that couldn't be opened, or an object that couldn't be read completely, in the latest \
                  run. It isn't in the other tables.",
    columns: &[
        Column::text("capture", "The path or URL.", |row| Some(&row.path)),
        Column::text("problem", "The reason.", |row| Some(&row.message)),
    ],
};
