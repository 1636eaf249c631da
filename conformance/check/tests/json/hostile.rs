//! Tests of arbitrary bytes: errors are reported with their line, and reading continues.

use std::io::{self, Read};

use proptest::prelude::*;
use uavspec_capture::json::{Event, MAX_LENGTH, Problem, Reader};
use uavspec_check::check_json;
use uavspec_test_support::extent;

use super::{DEFINITIONS, PERIOD, check_bare, check_bytes, corruption, glider, source, typed, violated};

/// Each case is an unreadable line between two readable ones, with the expected message.
#[test]
fn reports_unreadable_lines_and_continues() {
    let good = typed(&glider(PERIOD));
    let long = format!("{{\"type\":\"{}\"", "x".repeat(20 << 20));
    let cases: [(&[u8], &str); 12] = [
        (b"{\"type\": tru", "line 2: invalid JSON: unexpected end"),
        (b"{\"type\":'x'}", "line 2: invalid JSON: expected a value at byte 8"),
        (b"{\"type\":\"\xff\"}", "line 2: invalid UTF-8 at byte 9"),
        (b"{} {}", "line 2: invalid JSON: unexpected data after the value at byte 3"),
        (b"17", "line 2: expected an object"),
        (b"[]", "line 2: expected an object"),
        (b"{\"message\":{}}", "line 2: unknown message type"),
        (b"{\"op\":\"publish\"}", "line 2: rosbridge `publish` without"),
        (b"{\"op\":1}", "line 2: `op`: expected a string"),
        (b"{\"type\":\"a\",\"type\":\"b\",\"message\":{}}", "line 2: duplicate key"),
        (b"\xef\xbb\xbf{}", "line 2: invalid JSON: expected a value at byte 0"),
        (long.as_bytes(), "line 2: skipped a value of 20971530 bytes"),
    ];
    for (bytes, message) in cases {
        let input = [good.as_bytes(), b"\n", bytes, b"\n", good.as_bytes(), b"\n"].concat();
        let result = check_bytes(&input);
        let found = corruption(&result);
        assert!(found.len() == 1 && found[0].starts_with(message), "{message}: {found:?}");
        assert_eq!((result.checked, violated(&result)), (2, vec![]), "{message}");
        assert_eq!((source(&result).lines, result.bytes), (3, input.len() as u64), "{message}");
    }
    for open in ["[", "{\"a\":"] {
        let deep = format!("{good}\n{}\n{good}\n", open.repeat(100_000));
        let result = check_bytes(deep.as_bytes());
        assert_eq!(result.checked, 2);
        assert!(
            corruption(&result)[0].starts_with("line 2: invalid JSON: values are nested too deeply"),
            "{result:?}"
        );
    }
    let result = check_bytes(format!("\u{feff}{good}\n").as_bytes());
    // All values can be read, so the capture is complete.
    assert_eq!((corruption(&result).len(), result.checked), (0, 1));
    assert!(result.notes[0].starts_with("invalid JSON: byte order mark at the start"), "{result:?}");
    let cut = format!("{good}\n{}", &good[..good.len() / 2]);
    let result = check_bytes(cut.as_bytes());
    assert!(corruption(&result)[0].starts_with("line 2: the last value is truncated after"), "{result:?}");
}

#[test]
fn reports_malformed_arrays() {
    let one = glider(PERIOD);
    for (text, checked, message) in [
        (format!("[{one},{one}"), 2, vec!["line 1: the array is not closed"]),
        (format!("[{one}\n{one}]"), 2, vec!["line 2: expected a comma, found `{`"]),
        (format!("[{one},\n]"), 1, vec!["line 2: expected a value, found `]`"]),
        (format!("[{one},,\n{one}]"), 2, vec!["line 1: expected a value, found `,`"]),
        (format!("[{one}]\n}}"), 1, vec!["line 2: expected a value, found `}`"]),
    ] {
        let result = check_bare(&text);
        assert_eq!(
            (corruption(&result), result.checked),
            (message.iter().map(ToString::to_string).collect(), checked),
            "{text}"
        );
    }
    let result = check_bare(&format!("[{one}, 5, {{}}]"));
    assert_eq!(result.checked, 3);
    assert_eq!(violated(&result).len(), 2, "{result:?}");
    let long = format!("[{one}, \"{}\", {one}]", "x".repeat(20 << 20));
    let result = check_bare(&long);
    assert_eq!(
        corruption(&result),
        ["line 1: skipped a value of 20971522 bytes: the limit is 16777216 bytes"]
    );
    assert_eq!(result.checked, 2);
}

/// A reader that returns a limited number of bytes at a time.
struct Slow<'b>(&'b [u8], usize);

impl Read for Slow<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.0.len().min(self.1).min(buffer.len());
        let (now, later) = self.0.split_at(count);
        buffer[..count].copy_from_slice(now);
        self.0 = later;
        Ok(count)
    }
}

/// Reads input that arrives in pieces of this size. Returns the reader's events, and the number of lines.
fn events(bytes: &[u8], piece: usize) -> (Vec<String>, u64) {
    let mut reader = Reader::new(Slow(bytes, piece));
    let mut events = Vec::new();
    while let Some(item) = reader.next().expect("bytes can be read") {
        events.push(format!("{item:?}"));
    }
    (events, reader.lines())
}

proptest! {
    #[test]
    fn splits_any_bytes_the_same_in_any_pieces(
        parts in prop::collection::vec(prop::sample::select(&[
            "{", "}", "[", "]", ",", ":", "\"", "\\", "\n", " ", "\r\n", "1", "null", "{\"a\":[1]}", "\u{feff}", "é",
            "{\"type\":\"x/Glider\",\"message\":{}}",
        ][..]), 0..24),
        foreign in any::<[u8; 2]>(),
        at in any::<prop::sample::Index>(),
    ) {
        let mut bytes = parts.concat().into_bytes();
        if foreign[0] < 64 && !bytes.is_empty() {
            let at = at.index(bytes.len());
            bytes[at] = foreign[1];
        }
        let whole = events(&bytes, usize::MAX);
        prop_assert_eq!(&events(&bytes, 1), &whole);
        prop_assert_eq!(&events(&bytes, 3), &whole);
        let lines = bytes.split(|byte| *byte == b'\n').count() - 1;
        let is_open = bytes.last().is_some_and(|byte| *byte != b'\n');
        prop_assert_eq!(whole.1, lines as u64 + u64::from(is_open));
        check_json(&bytes[..], None, &DEFINITIONS);
    }
}

/// An endless line is skipped without storing it.
#[test]
fn skips_an_endless_line_in_constant_memory() {
    /// A reader of endless input that records the size of the largest read request. This size shows the free space in
    /// the buffer.
    struct Endless {
        left: u64,
        max: usize,
    }
    impl Read for &mut Endless {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = buffer.len().min(usize::try_from(self.left).unwrap_or(usize::MAX));
            buffer[..count].fill(b'x');
            self.left -= count as u64;
            self.max = self.max.max(buffer.len());
            Ok(count)
        }
    }
    let length = extent(200 << 20, 40 << 20);
    let mut endless = Endless { left: length, max: 0 };
    let mut reader = Reader::new(&mut endless);
    let item = reader.next().expect("bytes can be read").expect("a problem");
    assert_eq!(item.event, Event::Problem(Problem::TooLong { length }));
    assert_eq!(reader.next().expect("bytes can be read"), None);
    // The buffer grows in steps, to at most twice the length of a value.
    assert!(endless.max <= 2 * MAX_LENGTH, "{}", endless.max);
}

/// Long names aren't stored or shown, and control characters are escaped.
#[test]
fn limits_and_escapes_names() {
    let named = |ty: &str| format!("{}\n", serde_json::json!({"type": ty, "message": {}}));
    let result = check_bytes(format!("{}{}", named(&"x".repeat(300)), named("x/\u{1b}[31m")).as_bytes());
    assert_eq!(corruption(&result), ["line 1: the name of the topic or type is longer than 256 bytes"]);
    assert_eq!(source(&result).undefined.iter().collect::<Vec<_>>(), ["x/\\u{1b}[31m"]);
    let mut message = glider(PERIOD);
    message["\u{1b}[31m"] = 1.into();
    let result = check_bytes(typed(&message).as_bytes());
    let message = "px4/Glider.\\u{1b}[31m: Glider has no such field, but the message contains 1".to_owned();
    assert_eq!(violated(&result), [("PX-JSON-01", message)]);
}
