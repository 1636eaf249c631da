//! Reads `ULog`, the log format of PX4: <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>.
//!
//! The module has two layers. A [`Reader`] splits bytes into messages that borrow from its buffer, and reports corrupt
//! framing. A [`Log`] tracks formats and subscriptions, and determines the type of data.
//!
//! ```
//! use uavspec_capture::ulog::{Event, Log, Reader};
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
//!     let mut report = |offset, problem| found.push(format!("{offset}: {problem}"));
//!     if let Some(record) = log.take(&item, &mut report) {
//!         let message = record.message_type.view_uorb(record.payload).unwrap();
//!         assert_eq!(message.to_json_text().unwrap(), r#"{"timestamp":7,"speed":0.5}"#);
//!     }
//! }
//! assert_eq!(found, ["16: the log has no flag bits (version 1)"]);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! # Existing crates
//!
//! `px4-ulog` 0.6.1, `yule_log` 0.4.0 and `ulog-rs` 0.0.4 were evaluated. All of these crates stop at the first corrupt
//! header. None of them searches for sync messages or reports skipped bytes. Findings need message offsets, but none of
//! the crates provides them. `px4-ulog` reads only files or memory maps, or uses callbacks. `yule_log` allocates for
//! each message, and `ulog-rs` stores the whole log.
//!
//! # Recovery from corruption
//!
//! The reader accepts a message if its content looks valid (see below) and the next header has a usual size. Otherwise,
//! the reader looks ahead by at most [`Reader::LOOKAHEAD`] bytes:
//!
//! - If a valid run of messages starts within the message, the message has a wrong size. The reader skips to that run,
//!   so a wrong size doesn't hide the messages that follow.
//! - Otherwise, the message is accepted if its kind is known and its size is large enough. The reader then checks the
//!   bytes after the message.
//! - Otherwise, if a valid message or the end of the log follows, only the rejected message is reported. The message is
//!   too short or of an unknown kind.
//! - Otherwise, the reader searches for the next valid run.
//!
//! A run is valid if it starts with four valid messages or with a sync message, whose header and magic are 11 fixed
//! bytes. A message is valid if its kind is known and its first bytes are plausible: keys and names must be ASCII, log
//! levels must exist, and data must have a subscribed id and the usual size. Between valid messages, a run may contain
//! data with an unknown id or unusual size, and messages whose kind is an unknown letter. Sixteen consecutive messages,
//! valid or not, also form a run. At the end of the log or of a section, two valid messages suffice. Each byte is tried
//! as a start at most once, and each check takes at most a few thousand steps. The total time is therefore linear in
//! the size of the log.
//!
//! Each skipped range of bytes is reported ([`Problem::Skipped`]). Changed bytes within a payload can't be detected
//! here.
//!
//! # Performance
//!
//! The `ulog` benchmark was run on two cores with three real logs, each repeated up to a size of 64 MB. The median
//! throughput is 3.9 to 6.9 GB/s for splitting into messages, and 1.7 to 2.4 GB/s if types and data sizes are
//! determined as well. Copying through the buffer reaches 15 GB/s. The search reads noise at 350 MB/s, and malicious
//! input at 20 MB/s. At 4,727 places in real logs, a bit was flipped or 25 to 30 bytes were overwritten. Each change
//! caused the loss of 1.2 messages on average. In the worst of 450 runs, the average was below three.

mod kind;
mod log;
mod log_problem;
mod message;
mod problem;
mod reader;
mod resync;

pub use self::log::{Compiled, Log, Record, SharedFormats, Subscription};
pub use self::log_problem::LogProblem;
pub use self::message::Event;
pub use self::problem::{Malformation, Problem, Resync};
pub use self::reader::{Item, Reader};
