//! Types of specification pages: nested alternatives, other serde formats, errors, and names that the generated code uses
//! itself.

use std::collections::BTreeMap;
use std::fmt::Debug;

use uavspec_runtime::serde::de::value::{Error, MapDeserializer};
use uavspec_runtime::serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, Visitor};
use uavspec_runtime::serde::{Deserialize, Serialize, forward_to_deserialize_any};
use uavspec_runtime::{json_either, json_integers, json_named, json_object, json_strings, json_tuple};

/// Checks a round trip.
fn round<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T, text: &str) {
    assert_eq!(serde_json::to_string(value).expect("JSON"), text);
    assert_eq!(serde_json::from_str::<T>(text).expect("a value"), *value);
}

#[derive(Debug, PartialEq)]
struct Glider {
    next: Option<Next>,
    span: bool,
}

json_object! {
    Glider open;
    next "next" optional;
    span "span" required;
}

#[derive(Debug, PartialEq)]
struct Winch {
    next: Option<Next>,
    cable: bool,
}

json_object! {
    Winch open;
    next "next" optional;
    cable "cable" required;
}

#[derive(Debug, PartialEq)]
enum Next {
    Glider(Box<Glider>),
    Winch(Box<Winch>),
}

json_either! {
    Next;
    Glider;
    Winch;
}

/// A value with 60 levels around the innermost value. The first alternative rejects each level after it has read
/// all inner levels.
fn nested(innermost: &str) -> String {
    (0..60).fold(innermost.to_owned(), |inner, _| format!(r#"{{"next":{inner},"cable":true}}"#))
}

#[test]
fn reads_deeply_nested_alternatives_in_polynomial_time() {
    let text = nested(r#"{"span":false}"#);
    let mut found: Next = serde_json::from_str(&text).expect("a value");
    assert_eq!(serde_json::to_string(&found).expect("JSON"), text);
    let mut depth = 0;
    while let Next::Winch(winch) = found {
        found = winch.next.expect("a nested value");
        depth += 1;
    }
    assert_eq!((depth, found), (60, Next::Glider(Box::new(Glider { next: None, span: false }))));
    let error = serde_json::from_str::<Next>(&nested("{}")).expect_err("an error").to_string();
    assert!(error.contains("the value matches no alternative of Next"), "{error}");
}

#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct PortNumber(i64);

json_named! {
    PortNumber value;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Fix {
    Value0,
    Value3,
}

json_integers! {
    Fix closed;
    Value0 0;
    Value3 3;
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Towed,
}

json_strings! {
    Phase closed;
    Towed "towed";
}

#[test]
fn integers_can_be_keys() {
    round(&BTreeMap::from([(PortNumber(7001), true)]), r#"{"7001":true}"#);
    round(&BTreeMap::from([(Fix::Value0, true), (Fix::Value3, false)]), r#"{"0":true,"3":false}"#);
}

/// A value of a format that isn't self-describing.
enum Bare {
    Integer(i64),
    Text(&'static str),
}

impl<'de> Deserializer<'de> for Bare {
    type Error = Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Error> {
        Err(Error::custom("the format is not self-describing"))
    }

    fn deserialize_i64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Self::Integer(value) => visitor.visit_i64(value),
            Self::Text(_) => Err(Error::custom("not an integer")),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        match self {
            Self::Integer(_) => Err(Error::custom("not a string")),
            Self::Text(text) => visitor.visit_str(text),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 u8 u16 u32 u64 f32 f64 char str bytes byte_buf option unit unit_struct newtype_struct seq tuple
        tuple_struct map struct enum identifier ignored_any
    }
}

#[test]
fn formats_need_not_be_self_describing_for_named_values_and_sets() {
    assert_eq!(PortNumber::deserialize(Bare::Integer(7001)), Ok(PortNumber(7001)));
    assert_eq!(Fix::deserialize(Bare::Integer(3)), Ok(Fix::Value3));
    assert_eq!(Phase::deserialize(Bare::Text("towed")), Ok(Phase::Towed));
    let error = Fix::deserialize(Bare::Integer(1)).expect_err("an error").to_string();
    assert_eq!(error, "invalid value: integer `1`, expected a value of Fix");
}

#[derive(Debug, PartialEq)]
struct Servo {
    channel: u32,
    gain: Option<f32>,
}

json_object! {
    Servo open;
    channel "channel" required;
    gain "gain" optional;
}

/// The error for a text.
fn error<T: DeserializeOwned + Debug>(text: &str) -> String {
    serde_json::from_str::<T>(text).expect_err("an error").to_string()
}

#[test]
fn handwritten_types_may_contain_other_numbers() {
    round(&Servo { channel: 7, gain: Some(0.5) }, r#"{"channel":7,"gain":0.5}"#);
    let negative = error::<Servo>(r#"{"channel":-1}"#);
    assert!(negative.starts_with("channel: invalid value: integer `-1`, expected u32"), "{negative}");
    let large = error::<Servo>(r#"{"channel":7,"gain":1e300}"#);
    assert!(large.starts_with("gain: found inf, expected a finite number"), "{large}");
}

#[test]
fn reads_128_bit_integers() {
    fn read<T: IntoDeserializer<'static, Error>>(channel: T) -> Result<Servo, Error> {
        Servo::deserialize(MapDeserializer::new([("channel", channel)].into_iter()))
    }

    assert_eq!(read(7_u128), Ok(Servo { channel: 7, gain: None }));
    assert_eq!(read(7_i128), Ok(Servo { channel: 7, gain: None }));
}

#[derive(Debug, PartialEq)]
struct Ports {
    ports: BTreeMap<String, Vec<PortNumber>>,
}

json_object! {
    Ports open;
    ports "ports" required;
}

#[test]
fn errors_name_the_keys_and_indices_of_elements() {
    let found = error::<Ports>(r#"{"ports":{"udp":[7001,"x"]}}"#);
    assert!(found.starts_with("ports: udp: [1]: invalid type: string \"x\", expected i64"), "{found}");
}

#[derive(Debug, PartialEq)]
struct Spot {
    r#type: i64,
    r#in: Option<f64>,
    r#final: Option<bool>,
}

json_tuple! {
    Spot;
    r#type required;
    r#in optional;
    r#final optional;
}

#[test]
fn errors_contain_no_raw_identifiers() {
    let wrong = error::<Spot>(r#"["x"]"#);
    assert!(wrong.starts_with("type: invalid type: string \"x\", expected i64"), "{wrong}");
    let missing = error::<Spot>("[]");
    assert!(missing.contains("expected an array that has the element `type`"), "{missing}");
    for (r#in, expected) in [
        (Some(f64::NAN), "in is NaN, which JSON can't represent"),
        (None, "`in` is None, but an element after it is not"),
    ] {
        let spot = Spot { r#type: 1, r#in, r#final: Some(true) };
        let error = serde_json::to_string(&spot).expect_err("an error").to_string();
        assert_eq!(error, expected);
    }
}

/// Declares types of all kinds with these names, and a function that checks a value of each type.
macro_rules! declare {
    ($($type:ident)*) => {
        mod objects {
            $(
                #[derive(Debug, PartialEq)]
                struct $type {
                    value: bool,
                }

                uavspec_runtime::json_object! { $type closed; value "value" required; }
            )*

            pub(super) fn check() {
                $(super::round(&$type { value: true }, r#"{"value":true}"#);)*
            }
        }

        mod tuples {
            $(
                #[derive(Debug, PartialEq)]
                struct $type {
                    value: bool,
                }

                uavspec_runtime::json_tuple! { $type; value required; }
            )*

            pub(super) fn check() {
                $(super::round(&$type { value: true }, "[true]");)*
            }
        }

        mod named {
            $(
                #[derive(Debug, PartialEq)]
                struct $type(bool);

                uavspec_runtime::json_named! { $type value; }
            )*

            pub(super) fn check() {
                $(super::round(&$type(true), "true");)*
            }
        }

        mod sets {
            $(
                #[derive(Clone, Copy, Debug, PartialEq)]
                enum $type {
                    Towed,
                }

                uavspec_runtime::json_strings! { $type closed; Towed "towed"; }
            )*

            pub(super) fn check() {
                $(super::round(&$type::Towed, "\"towed\"");)*
            }
        }

        mod alternatives {
            $(
                #[derive(Debug, PartialEq)]
                enum $type {
                    Boolean(bool),
                    Integer(i64),
                }

                uavspec_runtime::json_either! { $type; Boolean; Integer; }
            )*

            pub(super) fn check() {
                $(
                    super::round(&$type::Boolean(true), "true");
                    super::round(&$type::Integer(1), "1");
                )*
            }
        }
    };
}

declare!(
    A Choices D E Elements Err Error Json JsonType L M Map None Object Ok Option Result S Some String T V
    Value Vec Visitor
);

#[test]
fn types_may_have_the_names_of_generic_parameters_and_of_the_prelude() {
    objects::check();
    tuples::check();
    named::check();
    sets::check();
    alternatives::check();
}

/// A message with the name of a primitive type.
mod messages {
    pub(super) mod str {
        #[derive(Debug, PartialEq)]
        pub(crate) struct Request {}

        uavspec_runtime::json_object! { Request closed; }
    }

    #[derive(Debug, PartialEq)]
    pub(super) enum Request {
        Str(str::Request),
        Other(uavspec_runtime::json_type::Json),
    }

    uavspec_runtime::json_messages! { Request; Str str "STR"; }
}

#[test]
fn a_message_may_have_the_name_of_a_primitive_type() {
    let request = messages::Request::from(messages::str::Request {});
    assert_eq!(request.message_type(), "STR");
    round(&request, r#"{"type":"STR"}"#);
}
