//! The headers of type tables.

use super::super::{Cell, Table};

/// The columns of an object.
const OBJECT: [&str; 4] = ["Field", "Required", "Type", "Description"];

/// The columns of a tuple.
const TUPLE: [&str; 5] = ["Index", "Element", "Required", "Type", "Description"];

/// The columns of a set, which has no other: in prose such columns stand beside many.
const SET: [&str; 2] = ["Value", "Description"];

/// Where the columns of a type table are. Those of objects and tuples stand in any order, also beside others.
#[derive(Clone, Copy, Debug)]
pub(super) enum Columns {
    Object { name: usize, required: usize, ty: usize, description: usize },
    Tuple { index: usize, name: usize, required: usize, ty: usize, description: usize },
    Set,
}

/// What the header of a table makes of it.
pub(super) enum Header {
    /// A type table.
    Known(Columns),
    /// Nearly one with these columns.
    Near(&'static [&'static str]),
}

/// What the header of a table makes of it; nothing where the table is prose.
pub(super) fn header_of(table: &Table) -> Option<Header> {
    let at = |name: &str| position(&table.header, |column| column.eq_ignore_ascii_case(name));
    let required = at("Required").zip(at("Type")).zip(at("Description"));
    if let Some(((required, ty), description)) = required {
        if let (Some(index), Some(name)) = (at("Index"), at("Element")) {
            return Some(Header::Known(Columns::Tuple { index, name, required, ty, description }));
        }
        if let Some(name) = at("Field") {
            return Some(Header::Known(Columns::Object { name, required, ty, description }));
        }
    }
    let is_set = table.header.len() == SET.len()
        && table.header.iter().zip(SET).all(|(cell, name)| cell.text.as_str().eq_ignore_ascii_case(name));
    if is_set {
        return Some(Header::Known(Columns::Set));
    }
    near(table).map(Header::Near)
}

/// The columns that were surely meant: of objects and tuples all but one are there, or nearly so.
fn near(table: &Table) -> Option<&'static [&'static str]> {
    let is_near = |column: &str, name: &str| {
        // Longer texts are no slip of a name, and comparing takes time with the product of the lengths.
        column.len() <= 2 * name.len()
            && strsim::damerau_levenshtein(&column.to_ascii_lowercase(), &name.to_ascii_lowercase())
                <= 1 + name.len() / 5
    };
    let has = |name: &&&str| position(&table.header, |column| is_near(column, name)).is_some();
    let all_but_one = |names: &[&str]| names.iter().filter(has).count() + 1 >= names.len();
    if all_but_one(&TUPLE) {
        return Some(&TUPLE);
    }
    // Without its own name for what it lists a table is one of many in prose.
    (all_but_one(&OBJECT) && has(&&OBJECT[0])).then_some(&OBJECT)
}

fn position(header: &[Cell], is_meant: impl Fn(&str) -> bool) -> Option<usize> {
    header.iter().position(|cell| is_meant(cell.text.as_str()))
}
