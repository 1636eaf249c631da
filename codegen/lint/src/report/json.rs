//! Findings as a JSON list.

use serde_json::{Map, Value, json};
use uavspec_schema::json_text;
use uavspec_schema::source::Position;

use super::model::{Entry, Place, Region, Report};

pub(super) fn write(report: &Report) -> String {
    let entries: Vec<Value> = report.entries.iter().map(entry).collect();
    json_text::pretty(&entries)
}

fn entry(entry: &Entry) -> Value {
    let mut object = Map::new();
    let mut put = |key: &str, value: Value| {
        object.insert(key.to_owned(), value);
    };
    put("rule", json!(entry.rule));
    if let Some(category) = entry.category {
        put("category", json!(category));
    }
    put("level", json!(entry.level.name()));
    put("message", json!(entry.message));
    put("help", json!(entry.help));
    let Value::Object(place_members) = place(&entry.place) else { return Value::Null };
    place_members.into_iter().for_each(|(key, value)| put(&key, value));
    if let Some((old, new)) = &entry.sides {
        put("old", old.as_ref().map_or(Value::Null, place));
        put("new", new.as_ref().map_or(Value::Null, place));
    }
    let related: Vec<Value> =
        entry.related.iter().map(|(at, label)| json!({ "place": place(at), "label": label })).collect();
    if !related.is_empty() {
        put("related", Value::Array(related));
    }
    put("fixable", json!(entry.is_fixable));
    if !entry.url.is_empty() {
        put("url", json!(entry.url));
    }
    Value::Object(object)
}

fn place(place: &Place) -> Value {
    let position = |at: Position| json!({ "line": at.line, "column": at.column });
    let file = &place.path;
    match place.region {
        Region::Whole => json!({ "file": file }),
        Region::Text { start, end } => {
            json!({ "file": file, "start": position(start), "end": position(end) })
        }
        Region::Line(line) => json!({ "file": file, "line": line }),
        Region::Byte(offset) => json!({ "file": file, "byte": offset }),
    }
}
