//! The target for event metadata, as captures contain it.

use uavspec_definitions::PX4_EVENTS;
use uavspec_dynamic::event::EventError;
use uavspec_px4::checks::{Report, Reports};
use uavspec_px4::event::{EventMetadata, RawEvent};
use uavspec_runtime::event::{MAX_ARGUMENTS_SIZE, Profile};
use uavspec_test_support::{Writer, xz};

/// The maximum length of a displayed text, in bytes: 4 KiB and an ellipsis.
const MAX_TEXT: usize = (4 << 10) + 3;

/// Reads event metadata, and decodes each event, with the first bytes as its arguments. The resulting texts must be
/// short.
pub(super) fn metadata(data: &[u8]) {
    let (arguments, data) = data.split_at(data.len().min(MAX_ARGUMENTS_SIZE));
    let Ok((metadata, _)) = EventMetadata::of_capture(data) else { return };
    let (events, mut reports) = (metadata.events(), Reports::default());
    for event in events.components().iter().flat_map(|component| &component.events) {
        let decoded = match events.decode(event.id, arguments) {
            Ok(decoded) => decoded,
            Err(error) => {
                let found = arguments.len();
                assert!(event.size() > found, "{error}");
                assert_eq!(error, EventError::TooShort { required: event.size(), found });
                continue;
            }
        };
        for profile in Profile::ALL {
            for text in [decoded.message(profile), decoded.description(profile)] {
                assert!(text.len() <= MAX_TEXT, "{} bytes", text.len());
            }
        }
        let raw = RawEvent { id: event.id, sequence: None, levels: 0, arguments: [0; MAX_ARGUMENTS_SIZE] };
        reports.follow(&raw, Some(&decoded));
    }
    let problems = reports.latest().map_or(0, |Report { problems, .. }| problems.len());
    assert!(problems <= events.len(), "{problems} problems of {} events", events.len());
}

/// Event metadata with two arguments, tags and escapes.
const METADATA: &[u8] = br#"{"version": 2, "components": {"0": {"namespace": "common", "enums": {"side_t": {
    "type": "uint8_t", "is_bitfield": true, "separator": "/", "entries": {"1": {"name": "left", "description": "Left \u0007"}}}},
    "event_groups": {"default": {"events": {"1": {"name": "wind",
    "message": "{1} {2:.1m\/s}<profile name=\"dev\"> \\< {9}<\/profile>", "description": "<a href=\"x\">{1}<\/a>",
    "arguments": [{"name": "side", "type": "side_t"}, {"name": "speed", "type": "float"}]}}}}}}}"#;

/// Arguments, followed by event metadata.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let texts = [PX4_EVENTS.to_vec(), xz(PX4_EVENTS), METADATA.to_vec(), xz(METADATA)];
    texts.map(|text| [&[3; MAX_ARGUMENTS_SIZE][..], &text].concat()).to_vec()
}

/// Logs with an event and with event metadata.
pub(super) fn logs() -> Vec<Vec<u8>> {
    let log = |metadata: &[u8]| {
        let mut log = Writer::with_flags();
        log.format("event:uint64_t timestamp;uint32_t id;uint16_t event_sequence;uint8_t[25] arguments;uint8_t log_levels;");
        for (at, piece) in metadata.chunks(300).enumerate() {
            let key = format!("uint8_t[{}] metadata_events", piece.len());
            log.entry(b'M', &[u8::from(at > 0)], &key, piece);
        }
        log.subscribe(0, 0, "event");
        // The time, the id, the sequence number, the arguments and the levels.
        log.data(0, &[&[7; 8][..], &[1, 0, 0, 0], &[3; 2], &[3; MAX_ARGUMENTS_SIZE], &[0x66]].concat());
        log.bytes
    };
    vec![log(METADATA), log(&xz(METADATA))]
}
