//! The headers of type tables.

use super::super::{Cell, Table};

/// The columns of an object.
const OBJECT: [&str; 4] = ["Field", "Required", "Type", "Description"];

/// The columns of a tuple.
const TUPLE: [&str; 5] = ["Index", "Element", "Required", "Type", "Description"];

/// The columns of a set. No other columns are allowed, because many tables in prose contain these two columns and
/// others.
const SET: [&str; 2] = ["Value", "Description"];

/// The positions of the columns of a type table. The columns of objects and tuples may be in any order, with other
/// columns between them.
#[derive(Clone, Copy, Debug)]
pub(super) enum Columns {
    Object { name: usize, required: usize, ty: usize, description: usize },
    Tuple { index: usize, name: usize, required: usize, ty: usize, description: usize },
    Set,
}

/// The kind of a table header.
pub(super) enum Header {
    /// A type table.
    Known(Columns),
    /// Almost a type table with these columns.
    Near(&'static [&'static str]),
}

/// The kind of a table's header, or `None` for a table in prose.
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

/// The columns that were probably intended, if at most one column of an object or tuple table is missing. Misspelled
/// columns count as present.
fn near(table: &Table) -> Option<&'static [&'static str]> {
    let is_near = |column: &str, name: &str| {
        // Longer texts are not misspelled names, and comparing them takes time proportional to both lengths.
        column.len() <= 2 * name.len()
            && strsim::damerau_levenshtein(&column.to_ascii_lowercase(), &name.to_ascii_lowercase())
                <= 1 + name.len() / 5
    };
    let has = |name: &&&str| position(&table.header, |column| is_near(column, name)).is_some();
    let all_but_one = |names: &[&str]| names.iter().filter(has).count() + 1 >= names.len();
    if all_but_one(&TUPLE) {
        return Some(&TUPLE);
    }
    // Many tables in prose have the other columns, so the `Field` column is required.
    (all_but_one(&OBJECT) && has(&&OBJECT[0])).then_some(&OBJECT)
}

fn position(header: &[Cell], is_match: impl Fn(&str) -> bool) -> Option<usize> {
    header.iter().position(|cell| is_match(cell.text.as_str()))
}
