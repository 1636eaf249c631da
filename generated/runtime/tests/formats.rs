//! Binary serde formats that write messages as sequences of values, or as maps with the indices of the fields as keys.

use uavspec_runtime::serde::de::value::{Error, MapDeserializer, SeqDeserializer};
use uavspec_runtime::serde::de::{Deserializer, Visitor};
use uavspec_runtime::serde::forward_to_deserialize_any;
use uavspec_runtime::{Definition, Message};

#[derive(Clone, Default, PartialEq)]
struct Pair {
    tag: u8,
    x: u16,
}

impl Message for Pair {
    const DEFINITION: Definition = Definition::new("samples", "Pair");
}

uavspec_runtime::record! {
    Pair[2];
    0 tag = uint8("tag", 0);
    1 x = uint16("x", 0);
}

/// A payload of a binary format.
enum Payload {
    Sequence(Vec<u16>),
    Map(Vec<(u64, u16)>),
}

impl<'de> Deserializer<'de> for Payload {
    type Error = Error;

    fn is_human_readable(&self) -> bool {
        false
    }

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Self::Sequence(values) => visitor.visit_seq(SeqDeserializer::new(values.into_iter())),
            Self::Map(values) => visitor.visit_map(MapDeserializer::new(values.into_iter())),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct
        seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

fn read(payload: Payload) -> Result<Pair, String> {
    uavspec_runtime::json::deserialize(payload).map_err(|error: Error| error.to_string())
}

#[test]
fn reads_sequences_of_values() {
    assert_eq!(read(Payload::Sequence(vec![7, 300])), Ok(Pair { tag: 7, x: 300 }));
    assert_eq!(
        read(Payload::Sequence(vec![7])),
        Err("expected another field, found the end of the sequence".to_owned())
    );
}

#[test]
fn the_first_error_in_a_sequence_is_the_result() {
    let error = read(Payload::Sequence(vec![300])).expect_err("300 is no u8");
    assert!(error.contains("300"), "{error}");
}

#[test]
fn reads_maps_with_the_indices_of_fields() {
    for fields in [[(0, 7), (1, 300)], [(1, 300), (0, 7)]] {
        assert_eq!(read(Payload::Map(fields.to_vec())), Ok(Pair { tag: 7, x: 300 }));
    }
    let error = read(Payload::Map(vec![(0, 7), (2, 300)]));
    assert_eq!(error, Err("field index 2 is out of range".to_owned()));
}
