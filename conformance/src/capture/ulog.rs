//! Reads `ULog`, the log of PX4: <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>.
//!
//! Two layers. A [`Reader`] cuts bytes into messages, lends each from its buffer and tells all damage that
//! can be seen without knowing what is logged. A [`Log`] keeps the formats and subscriptions that the
//! messages bring, and gives data its type.
//!
//! ```
//! use uavspec_conformance::capture::ulog::{Event, Log, Reader};
//!
//! let mut bytes = b"ULog\x01\x12\x35\x01\0\0\0\0\0\0\0\0".to_vec();
//! for (kind, payload) in [(b'F', &b"wind:uint64_t timestamp;float speed;"[..]), (b'A', b"\0\x05\0wind")]
//!     .into_iter()
//!     .chain([(b'D', &b"\x05\0\x07\0\0\0\0\0\0\0\0\0\0\x3f"[..])])
//! {
//!     bytes.extend(u16::try_from(payload.len()).unwrap().to_le_bytes());
//!     bytes.push(kind);
//!     bytes.extend(payload);
//! }
//!
//! let mut reader = Reader::new(&bytes[..]);
//! let mut log = Log::default();
//! let mut found = Vec::new();
//! while let Some(item) = reader.next()? {
//!     if let Event::Problem(problem) = &item.event {
//!         found.push(format!("{}: {problem}", item.offset));
//!     }
//!     let mut tell = |offset, problem| found.push(format!("{offset}: {problem}"));
//!     if let Some(record) = log.take(&item, &mut tell) {
//!         let message = record.message_type.view_uorb(record.payload).unwrap();
//!         assert_eq!(message.to_json_text().unwrap(), r#"{"timestamp":7,"speed":0.5}"#);
//!     }
//! }
//! assert_eq!(found, ["16: the log has no flag bits (version 1)"]);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! # Why not a crate that exists
//!
//! `px4-ulog` 0.6.1, `yule_log` 0.4.0 and `ulog-rs` 0.0.4 were looked at. All end at the first broken
//! header; none searches sync messages or tells which bytes were lost, and none gives the offset of a
//! message, without which a finding can't say where it is. The first has only files or memory maps at the
//! top and callbacks below, the second allocates for every message, and the third keeps the whole log.
//!
//! # How damage is survived
//!
//! A message is believed at once if it looks sound (see below), and the header that follows it says something
//! usual, too. Where this fails, the reader looks ahead, at most [`Reader::LOOKAHEAD`] bytes:
//!
//! - If a sound run of messages begins within the bytes that the message claims, its size is wrong: it is
//!   skipped up to that run. So a wrong size doesn't swallow what follows.
//! - Else, if its own kind is known and its size large enough, it is believed, and the doubt goes to what
//!   follows.
//! - Else, if a sound message or the end follows, only this one is odd (a kind of the future, or too short)
//!   and it alone is told.
//! - Else what follows is searched for the next sound run.
//!
//! A run is sound if it begins with a sync message (its header and magic are 11 fixed bytes), or if four
//! messages look sound that follow each other: their kinds are known, and their first bytes in order (keys
//! and names in ASCII, levels that exist, data of ids that were subscribed, as long as before). Between them
//! there may be others: other data, kinds that are letters; sixteen messages in a row are enough, whatever
//! they are. At the end of the log or of a section, two are enough. No byte is searched twice as a start, and
//! no look takes more than some thousand steps: time is linear in the size of the log, whatever is in it.
//!
//! Each range of bytes that was skipped is told with its ends ([`Problem::Skipped`]). What can't be seen here
//! is a changed byte within a payload.
//!
//! # Measured
//!
//! Two cores, medians of the bench `ulog` on three real logs, repeated up to 64 MB: messages at 3.9 to
//! 6.9 GB/s where copying through the buffer reaches 15, with the type of each and its size checked at 1.7 to
//! 2.4. Noise is searched at 350 MB/s, and bytes that are made to take long at 20. Of 4,727 places in real
//! logs where a bit was flipped or 25 to 30 bytes were overwritten, each cost 1.2 messages on average, and
//! less than three in the worst of 450 runs.

mod kind;
mod log;
mod log_problem;
mod message;
mod problem;
mod reader;
mod resync;
mod window;

pub use self::log::{Log, Record, Subscription};
pub use self::log_problem::LogProblem;
pub use self::message::Event;
pub use self::problem::{Malformation, Problem, Resync};
pub use self::reader::{Item, Reader};
