//! Shared test helpers: the corpus, and a writer of logs.

#![allow(clippy::missing_panics_doc, reason = "a panic is the failure of a test")]

pub mod python;
pub mod schema;

use std::io::{self, Read};
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU16, Ordering};
use std::time::{Duration, Instant};
use std::{env, fs};

use uavspec_model::clock::Clock;
pub use uavspec_test_definitions::{extent, shared, xz};

/// A Cargo command with an environment like that of a shell. During tests, the environment contains variables that
/// describe this package. They would cause build scripts that read them, such as ring's, to run again, so that all
/// dependents of ring would be recompiled.
pub fn cargo() -> Command {
    let mut command = Command::new(env!("CARGO"));
    for (name, _) in env::vars_os() {
        let describes_package =
            |name: &str| name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_");
        if name.to_str().is_some_and(describes_package) {
            command.env_remove(name);
        }
    }
    command
}

/// Sends a signal to a process.
#[cfg(unix)]
pub fn send_signal(process: u32, signal: nix::sys::signal::Signal) {
    let process = nix::unistd::Pid::from_raw(process.cast_signed());
    nix::sys::signal::kill(process, signal).expect("the process runs");
}

/// The time limit for an event that is certain to happen, even on a slow computer. It ends tests that would hang
/// otherwise.
pub const LIMIT: Duration = Duration::from_secs(600);

/// The deadline for an event that is certain to happen.
pub fn deadline() -> Instant {
    Clock::real().now() + LIMIT
}

/// Waits until `check` returns a value. Panics at the time limit.
pub fn wait_for<T>(event: &str, check: impl FnMut() -> Option<T>) -> T {
    let found = Clock::real().poll(deadline(), Duration::from_millis(5), check);
    found.unwrap_or_else(|| panic!("{event}: this doesn't happen"))
}

/// An address of this computer at which nothing listens. Its port stays free: a system that chooses a port by itself
/// takes one from 32,768 up.
pub fn free_address() -> SocketAddr {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    // Test programs that run at the same time start at different ports.
    let first = 10_000 + (std::process::id() % 200) as u16 * 100;
    let next = || ([127, 0, 0, 1], first + NEXT.fetch_add(1, Ordering::Relaxed)).into();
    let mut addresses = std::iter::repeat_with(next);
    addresses.find(|address| TcpListener::bind(address).is_ok()).expect("a free port")
}

/// Writes a file to a folder. Creates the folders in its path.
pub fn write(folder: &Path, path: &str, text: impl AsRef<[u8]>) {
    let path = folder.join(path);
    fs::create_dir_all(path.parent().expect("a parent")).expect("a folder");
    fs::write(path, text).expect("a file");
}

/// The files in a chapter of the guide. For each file, the chapter contains a line with its path in backticks, followed
/// by a fenced block.
pub fn files_of_guide(chapter: &str) -> Vec<(String, String)> {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../xtask/site/guide").join(chapter);
    let page = fs::read_to_string(page).expect("the chapter");
    let mut files = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        let path = line.strip_prefix('`').and_then(|rest| rest.strip_suffix('`'));
        let Some(path) = path.filter(|path| !path.contains('`')) else { continue };
        let fenced = lines.by_ref().skip_while(|line| !line.starts_with("```")).skip(1);
        let text: Vec<&str> = fenced.take_while(|line| *line != "```").collect();
        files.push((path.to_owned(), text.join("\n") + "\n"));
    }
    files
}

/// Writes `ULog` files.
#[derive(Clone)]
pub struct Writer {
    /// The log.
    pub bytes: Vec<u8>,
}

impl Writer {
    /// A log with a header only.
    pub fn new(version: u8) -> Self {
        let mut bytes = b"ULog\x01\x12\x35".to_vec();
        bytes.push(version);
        bytes.extend(1_000_u64.to_le_bytes());
        Self { bytes }
    }

    /// A log of version 1 with a flag bits message.
    pub fn with_flags() -> Self {
        let mut log = Self::new(1);
        log.flag_bits([0; 8], [0; 3], 0);
        log
    }

    /// The offset of the next message.
    pub fn offset(&self) -> u64 {
        self.bytes.len() as u64
    }

    /// Writes a message of any kind, and returns its offset.
    pub fn message(&mut self, kind: u8, parts: &[&[u8]]) -> u64 {
        let offset = self.offset();
        let payload = parts.concat();
        self.bytes.extend(u16::try_from(payload.len()).expect("a size").to_le_bytes());
        self.bytes.push(kind);
        self.bytes.extend(payload);
        offset
    }

    /// Writes the flag bits message.
    pub fn flag_bits(&mut self, incompatible: [u8; 8], appended: [u64; 3], more: usize) -> u64 {
        let appended: Vec<u8> = appended.iter().flat_map(|offset| offset.to_le_bytes()).collect();
        self.message(b'B', &[&[0; 8], &incompatible, &appended, &vec![0; more]])
    }

    /// Writes a format.
    pub fn format(&mut self, text: &str) -> u64 {
        self.message(b'F', &[text.as_bytes()])
    }

    /// Writes a message of type `I`, `M`, `P` or `Q`. For `M` and `Q`, `first` is the byte before the key.
    pub fn entry(&mut self, kind: u8, first: &[u8], key: &str, value: &[u8]) -> u64 {
        let length = u8::try_from(key.len()).expect("a short key");
        self.message(kind, &[first, &[length], key.as_bytes(), value])
    }

    /// Writes a subscription.
    pub fn subscribe(&mut self, id: u16, multi_id: u8, topic: &str) -> u64 {
        self.message(b'A', &[&[multi_id], &id.to_le_bytes(), topic.as_bytes()])
    }

    /// Writes the end of a subscription.
    pub fn unsubscribe(&mut self, id: u16) -> u64 {
        self.message(b'R', &[&id.to_le_bytes()])
    }

    /// Writes a data message.
    pub fn data(&mut self, id: u16, payload: &[u8]) -> u64 {
        self.message(b'D', &[&id.to_le_bytes(), payload])
    }

    /// Writes a text message.
    pub fn line(&mut self, text: &[u8]) -> u64 {
        self.message(b'L', &[b"6", &5_u64.to_le_bytes(), text])
    }

    /// Writes a synchronization message.
    pub fn sync(&mut self) -> u64 {
        self.message(b'S', &[&[0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12]])
    }

    /// Writes a dropout.
    pub fn dropout(&mut self, milliseconds: u16) -> u64 {
        self.message(b'O', &[&milliseconds.to_le_bytes()])
    }
}

/// A log with all kinds of messages that PX4 writes: first definitions, then data of three topics with text messages in
/// between.
pub fn typical(rounds: u64) -> Vec<u8> {
    write_log(rounds, |_| String::new())
}

/// Like [`typical`], with the padding that PX4 adds to formats. [`write_typical_definitions`] writes the definitions of
/// the topics.
pub fn padded(rounds: u64) -> Vec<u8> {
    write_log(rounds, |length| {
        let padding = if length % 2 == 0 { 7 } else { 3 };
        format!("uint8_t[{padding}] _padding0;")
    })
}

/// Writes a log. `padding` returns the end of a format whose array has this length.
fn write_log(rounds: u64, padding: impl Fn(u8) -> String) -> Vec<u8> {
    let mut log = Writer::with_flags();
    log.entry(b'I', &[], "char[3] sys_name", b"PX4");
    for topic in 0..20 {
        let length = topic + 1;
        log.format(&format!(
            "topic_{topic}:uint64_t timestamp;float[{length}] xyz;uint8_t kind;{}",
            padding(length)
        ));
        log.entry(b'P', &[], &format!("int32_t PARAM_{topic}"), &[topic; 4]);
    }
    log.entry(b'M', &[0], "char[5] notes", b"first");
    for id in 0..20_u8 {
        log.subscribe(id.into(), 0, &format!("topic_{id}"));
    }
    let mut random = Random(7);
    for round in 0..rounds {
        for id in 0..20_u8 {
            let mut payload = (1_000_000 + round * 4_000).to_le_bytes().to_vec();
            payload.extend((0..=id).flat_map(|_| random.below(1 << 32).to_le_bytes().into_iter().take(4)));
            payload.push(1);
            log.data(id.into(), &payload);
        }
        if round % 7 == 2 {
            log.line(b"[commander] Takeoff detected");
        } else if round % 7 == 4 {
            log.sync();
        } else if round % 7 == 6 {
            log.dropout(12);
        }
    }
    log.bytes
}

/// Writes the definitions of the topics in [`padded`] logs to the folder `msg`.
pub fn write_typical_definitions(folder: &Path) {
    let folder = folder.join("msg");
    std::fs::create_dir_all(&folder).expect("a folder");
    for topic in 0..20 {
        let text = format!(
            "# A topic\n\nuint64 timestamp  # [us] Time\nfloat32[{}] xyz  # [-] Values\nuint8 kind  # [-] Kind\n\
             # TOPICS topic_{topic}\n",
            topic + 1
        );
        std::fs::write(folder.join(format!("Topic{topic}.msg")), text).expect("a file");
    }
}

/// The words of a text, separated by single spaces. The text may be wrapped.
pub fn words(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Reproducible pseudorandom numbers (splitmix64).
pub struct Random(pub u64);

impl Random {
    /// A number below a limit.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % limit
    }

    /// An index below a limit.
    pub fn index(&mut self, limit: usize) -> usize {
        usize::try_from(self.below(limit as u64)).expect("an index")
    }

    /// Random bytes.
    pub fn bytes(&mut self, count: usize) -> Vec<u8> {
        let mut bytes: Vec<u8> =
            (0..count.div_ceil(8)).flat_map(|_| self.below(u64::MAX).to_le_bytes()).collect();
        bytes.truncate(count);
        bytes
    }
}

/// A reader that returns the bytes in pieces. The list of sizes is used repeatedly. A size of 0 causes an interruption.
pub struct Pieces<'b> {
    /// The remaining bytes.
    pub rest: &'b [u8],
    /// The sizes of the pieces.
    pub sizes: Vec<usize>,
    /// The number of reads.
    pub turn: usize,
}

impl Read for Pieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let size = self.sizes[self.turn % self.sizes.len()];
        self.turn += 1;
        if size == 0 {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let (now, rest) = self.rest.split_at(size.min(buffer.len()).min(self.rest.len()));
        buffer[..now.len()].copy_from_slice(now);
        self.rest = rest;
        Ok(now.len())
    }
}
