//! The inputs that a first run of the targets for definitions and codecs starts from.

use uavspec_definitions::{FLOCKWAVE, PX4, PX4_EVENTS};

/// The maximum length of a page, in bytes.
const MAX_PAGE: usize = 4 << 10;

/// Definitions as `.msg`, `.srv` and `.action` files.
pub(crate) fn definitions() -> Vec<Vec<u8>> {
    let texts = [
        &b"\x01# Request\nuint8 LAND=1\nuint8 command  # [@enum LAND]\n---\nbool ok\n"[..],
        b"\x02int32 order\n---\nint32[] sequence\n---\nint32[<=3] partial [1, 2]\n",
        b"\x00B[2] twins\nstring<=4 name \"a\\tb\"\n\xfffloat32 speed 1.5  # [m/s] [@range 0, 20] [@invalid NaN]\n",
        b"\x00uint64 timestamp  # [us]\nuint8 a\n\n# TOPICS wind wind_status\n",
    ];
    selected(0, &messages()).into_iter().chain(texts.map(<[u8]>::to_vec)).collect()
}

/// Pages with tables.
pub(crate) fn tables() -> Vec<Vec<u8>> {
    let adoc =
        b"\x01== SYS-VER\n\n.Message fields\n[cols=\"1,1\"]\n|===\n|Field |Type\n\n|`type` |string\n|===\n";
    selected(0, &pages()).into_iter().chain([adoc.to_vec()]).collect()
}

/// Event metadata, and two files that share a component.
pub(crate) fn events() -> Vec<Vec<u8>> {
    let enums =
        br#"{"version": 1, "components": {"7": {"namespace": "kite", "enums": {"side_t": {"type": "int8_t",
        "entries": {"-1": {"name": "left", "description": "Left"}}}}}}}"#;
    let events = br#"{"version": 2, "components": {"7": {"namespace": "kite", "event_groups": {"default": {"events": {"1": {
        "name": "turned", "message": "{1} {2:.1m\/s}<profile name=\"dev\"> \\< {9}<\/profile>",
        "arguments": [{"name": "side", "type": "kite::side_t"}, {"name": "speed", "type": "float"}]}}}}}}}"#;
    vec![PX4_EVENTS.to_vec(), [&enums[..], b"\xff", events].concat()]
}

/// Definitions and pages, for the formatter and the fixes.
pub(crate) fn files() -> Vec<Vec<u8>> {
    let loose = b"\x00uint8   a# [ m/s ]  Speed \nint32 [ 3 ] b  \n\tfloat32 c # [@range 3,1]\n".to_vec();
    let ros = selected(3, &messages());
    selected(0, &messages()).into_iter().chain(ros).chain(selected(6, &pages())).chain([loose]).collect()
}

/// Payloads of dynamic messages. The first byte selects the encoding, and the second byte selects the type.
pub(crate) fn dynamic() -> Vec<Vec<u8>> {
    let mut seeds = vec![
        b"\x03\x00glider:uint64_t timestamp;float[3] speed;char[4] name;\xff12345678123412341234name"
            .to_vec(),
        b"\x02\x05{\"a\":true,\"b\":[1,2,3]}".to_vec(),
    ];
    for which in 0..10 {
        for encoding in 0..2 {
            seeds.push([&[encoding, which, 0, 1, 0, 0][..], &[0; 64]].concat());
        }
    }
    seeds
}

/// Payloads of generated types. The first byte selects the type.
pub(crate) fn payloads() -> Vec<Vec<u8>> {
    (0..6).map(|which| [&[which, 0, 1, 0, 0][..], &[0; 160]].concat()).collect()
}

/// JSON of generated types. The first byte selects the type.
pub(crate) fn json() -> Vec<Vec<u8>> {
    let point = b"\x01{\"tag\":1,\"label\":\"a\",\"x\":18446744073709551615}".to_vec();
    let reply = b"\x05{\"timestamp\":1,\"request_id\":2,\"name\":[1,2],\"success\":true}".to_vec();
    vec![point, reply, b"\x00{\"flag\":null}".to_vec()]
}

fn messages() -> Vec<&'static [u8]> {
    PX4.files().map(|file| file.contents()).collect()
}

fn pages() -> Vec<&'static [u8]> {
    FLOCKWAVE.files().map(|file| file.contents()).filter(|page| page.len() <= MAX_PAGE).collect()
}

/// Texts after a byte that selects the kind of file.
fn selected(kind: u8, texts: &[&[u8]]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| [&[kind], *text].concat()).collect()
}
