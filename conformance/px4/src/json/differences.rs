//! Counts the differences between a JSON message and a type, to find the type of a message among similar ones.

use uavspec_dynamic::{Field, MessageType};
use uavspec_model::json::{Tree, base64};
use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Shape};

use super::value::is_byte;

/// The number of fields in a message that differ from a type: by their keys, by the length of an array, or by the type of
/// a single value. Of the messages in an array, only the first one counts.
pub fn count_differences(message: &Tree<'_>, ty: MessageType<'_>) -> usize {
    let Tree::Object(members) = message else { return 1 };
    let unknown = members.iter().filter(|(key, _)| ty.field(key).is_none()).count();
    let of_field = |field: &Field| message.get(&field.name).map_or(1, |value| in_value(value, ty, field));
    unknown + ty.fields().iter().map(of_field).sum::<usize>()
}

/// The number of differences between a value and the type of its field.
fn in_value(value: &Tree<'_>, ty: MessageType<'_>, field: &Field) -> usize {
    let shape = match field.element {
        // ROS 2 writes text as an array.
        Element::Text(room) if matches!(value, Tree::List(_)) => Shape::Array(room),
        _ => field.shape,
    };
    let length = match value {
        Tree::List(values) => Some(values.len()),
        Tree::Text(text) if is_byte(field.element) => base64::decode(text).map(|bytes| bytes.len()),
        _ => None,
    };
    let has_other_length = length.is_some_and(|length| match shape {
        Shape::Array(expected) => length != expected as usize,
        Shape::Bounded(bound) => length > bound as usize,
        Shape::Single | Shape::Sequence => false,
    });
    let within = match (value, field.element) {
        (Tree::Object(_), Element::Message(id)) => count_differences(value, ty.nested(id)),
        (Tree::List(values), Element::Message(id)) => {
            values.first().map_or(0, |first| count_differences(first, ty.nested(id)))
        }
        (_, Element::Scalar(scalar)) => usize::from(!may_be(value, scalar)),
        _ => 0,
    };
    usize::from(has_other_length) + within
}

/// True unless the value is a single value that can't have this type.
fn may_be(value: &Tree<'_>, scalar: Scalar) -> bool {
    match (value, scalar.integer_bounds()) {
        (Tree::Bool(_), _) => scalar == Scalar::Bool,
        (Tree::Int(value), Some((low, high))) => (low..=high).contains(value),
        (Tree::Int(_), None) => scalar.is_float(),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use uavspec_dynamic::Types;
    use uavspec_schema::msg::Dialect;
    use uavspec_schema::{Form, MessageId, PackageInput, SourceMap, read};

    use super::*;

    #[test]
    fn counts_keys_lengths_and_types_that_differ() {
        let mut sources = SourceMap::default();
        let kite =
            "uint64 timestamp\nuint8 mode\nfloat32[2] flaps\nuint8[3] raw\nchar[4] name\nLine[2] lines\n";
        let files = [("Kite.msg", kite), ("Line.msg", "uint64 timestamp\nfloat32 pull\n")];
        let files = files.map(|(path, text)| sources.add(path, text.into()).expect("a file"));
        let package = PackageInput::new("demo", Form::Msg(Dialect::Px4), files.to_vec());
        let (schema, _) = read(&sources, &[package]);
        let types = Types::new(&schema);
        let at = schema.messages.iter().position(|message| message.name == "Kite").expect("a message");
        let kite = types.get(MessageId(u32::try_from(at).expect("an index")));
        let lines = r#"[{"timestamp":0,"pull":1.5},{"timestamp":0,"pull":null}]"#;
        let good = format!(
            r#"{{"timestamp":1,"mode":7,"flaps":[0,0.5],"raw":[1,2,3],"name":"owl","lines":{lines}}}"#
        );
        for (from, to, expected) in [
            ("owl", "gull", 0),
            (r#""owl""#, "[111,119,108,0]", 0),
            (r#""owl""#, "[111,119,108]", 1),
            ("[1,2,3]", r#""AQID""#, 0),
            ("[1,2,3]", r#""AQIDBA==""#, 1),
            ("[0,0.5]", "[0,0.5,1]", 1),
            (r#""mode":7"#, r#""mode":256"#, 1),
            (r#""mode":7"#, r#""mode":true"#, 1),
            (r#""mode":7"#, r#""kind":7"#, 2),
            (r#""timestamp":0,"pull":1.5"#, r#""pull":1.5,"angle":0"#, 2),
            (lines, "[]", 1),
        ] {
            assert!(good.contains(from), "{from}");
            let text = good.replacen(from, to, 1);
            let tree = Tree::read(&text).expect("JSON");
            assert_eq!(count_differences(&tree, kite), expected, "{text}");
        }
        assert_eq!(count_differences(&Tree::Null, kite), 1);
    }
}
