//! Decides whether bytes are a message, and searches for the next message if they aren't.

use std::collections::BTreeMap;
use std::ops::Range;

use super::kind::{HEADER, Header, LARGEST, SYNC};
use super::problem::Resync;

/// The number of consecutive valid messages that form a run. A run is unlikely to occur by chance.
const SOUND_RUN: usize = 4;

/// Like [`SOUND_RUN`], for the end of the log or of a section.
const RUN_AT_END: usize = 2;

/// Like [`SOUND_RUN`], for a run directly after the end of a message.
const RUN_AFTER_MESSAGE: usize = 1;

/// The number of consecutive messages that form a run even if most are only [possible](Plausibility::Possible). By
/// chance alone, one position in five looks like the start of a possible message.
const LONG_RUN: usize = 16;

/// The maximum size, in bytes, of a run's first message if it is only [possible](Plausibility::Possible). In random
/// bytes, one position in 256 looks like the start of a data message of up to 64 KiB. Some of these apparent messages
/// end where a real message starts. Without this limit, such apparent messages would form a run and hide the messages
/// in between. PX4 data messages are smaller than this limit.
const LARGEST_POSSIBLE_START: usize = 1_024;

/// The maximum number of characters to check in a string. Real names are shorter. Without this limit, the running time
/// would depend on sizes that may be wrong.
const TEXT: usize = 64;

/// The number of bytes to examine, sufficient for a message and the run after it if all messages have the maximum size.
pub(super) const LOOKAHEAD: usize = (SOUND_RUN + 1) * LARGEST;

/// The classification of the bytes at the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beginning {
    /// The end of the section.
    End,
    /// A message.
    Message(Header),
    /// A message or header that extends beyond the end.
    Truncated,
    /// This many invalid bytes, followed by a message.
    Skip(usize, Resync),
    /// Invalid bytes. The next message starts at least this many bytes later.
    Lost(usize),
}

/// The subscribed ids, each with the size of its messages. All messages of a topic have the same size, so a different
/// size is suspicious: a message with a wrong size may end at the start of another message by chance.
#[derive(Debug, Default)]
pub(super) struct Ids {
    sizes: Vec<u16>,
    /// Sizes that differ from the known size and occurred only once. A size that occurs twice in a row replaces the
    /// known size.
    doubtful: BTreeMap<u16, u16>,
    /// True if an id was subscribed.
    is_subscribed: bool,
}

/// The placeholder size for ids without a subscription.
const UNSUBSCRIBED: u16 = 0;

/// The placeholder size for ids without messages. Real data contains at least the two bytes of its id.
const UNSEEN: u16 = 1;

impl Ids {
    /// Adds a subscribed id.
    pub(super) fn subscribe(&mut self, id: u16) {
        *self.size_mut(id) = UNSEEN;
        self.doubtful.remove(&id);
        self.is_subscribed = true;
    }

    /// Updates the known size for an id after a message with that id.
    pub(super) fn see(&mut self, id: u16, size: u16) {
        let usual = self.size_of(id);
        if usual == UNSUBSCRIBED || usual == size {
            self.doubtful.remove(&id);
        } else if usual == UNSEEN || self.doubtful.insert(id, size) == Some(size) {
            *self.size_mut(id) = size;
        }
    }

    /// True if the known sizes are certain. Otherwise, [`Self::see`] must be called after each message.
    #[inline]
    pub(super) fn are_certain(&self) -> bool {
        self.doubtful.is_empty()
    }

    /// True if messages with this id have this size.
    #[inline]
    pub(super) fn expect(&self, size: u16, id: u16) -> bool {
        size > UNSEEN && self.size_of(id) == size
    }

    /// The known size of messages with the id at the start of `payload`.
    fn size(&self, payload: &[u8]) -> u16 {
        payload.first_chunk().map_or(UNSUBSCRIBED, |id| self.size_of(u16::from_le_bytes(*id)))
    }

    #[inline]
    fn size_of(&self, id: u16) -> u16 {
        self.sizes.get(usize::from(id)).copied().unwrap_or(UNSUBSCRIBED)
    }

    fn size_mut(&mut self, id: u16) -> &mut u16 {
        let id = usize::from(id);
        if id >= self.sizes.len() {
            self.sizes.resize(id + 1, UNSUBSCRIBED);
        }
        &mut self.sizes[id]
    }

    /// True if a message with the id at the start of `payload` is possible: the id is subscribed and the size of its
    /// messages is unknown, or no ids are subscribed.
    fn allow(&self, payload: &[u8]) -> bool {
        !self.is_subscribed || self.size(payload) == UNSEEN
    }
}

/// The bytes at the cursor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look<'b> {
    /// The bytes of this section.
    pub(super) bytes: &'b [u8],
    /// True if no more bytes follow in this section.
    pub(super) is_closed: bool,
    /// True if no messages precede these bytes, so flag bits are allowed.
    pub(super) is_first: bool,
    pub(super) ids: &'b Ids,
}

/// The reason why a walk from message to message ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Walk {
    /// There were enough valid messages.
    Enough,
    /// The section ended after a message.
    End { sound: usize },
    /// The section ended within a message.
    Truncated { sound: usize },
    /// Bytes that aren't a message.
    Corrupt,
}

/// The plausibility of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plausibility {
    /// The kind is known and the content is valid. In random bytes, fewer than one start position in 100,000 is sound.
    Sound,
    /// Data with an unknown id or a new size, or a message of a kind that a future version may define.
    Possible,
    Wrong,
}

impl Look<'_> {
    /// The size of a header and, for data, the id.
    pub(super) const NEXT: usize = HEADER + 2;

    /// Classifies the message by its content and the [`NEXT`](Self::NEXT) bytes after it, which nearly always
    /// suffice.
    pub(super) fn classify(&self) -> Option<Beginning> {
        if self.bytes.is_empty() && self.is_closed {
            return Some(Beginning::End);
        }
        let header = Header::read(self.bytes)?;
        let (message, behind) = self.bytes.split_at_checked(header.total())?;
        let is_followed = match (Header::read(behind), behind.get(HEADER..Self::NEXT)) {
            (None, _) => self.is_closed,
            (Some(Header { kind: b'D', size }), Some(id)) => self.ids.size(id) == size,
            (Some(next), _) => next.is_usual(),
        };
        let is_sound = || match header.kind {
            b'B' => self.is_first && header.is_plausible(),
            _ => self.plausibility(header, &message[HEADER..]) == Plausibility::Sound,
        };
        (is_followed && is_sound()).then_some(Beginning::Message(header))
    }

    /// Classifies the message by the bytes after it.
    pub(super) fn classify_ahead(&self) -> Beginning {
        let Some(header) = Header::read(self.bytes) else { return Beginning::Truncated };
        let end = header.total();
        let searched = end.min(self.bytes.len());
        if let Some((count, resync)) = self.search(1..searched) {
            return Beginning::Skip(count, resync);
        }
        let is_complete = end <= self.bytes.len();
        match header.is_plausible() {
            true if is_complete => Beginning::Message(header),
            true => Beginning::Truncated,
            false if is_complete && self.follows(end) => Beginning::Message(header),
            false => Beginning::Lost(searched),
        }
    }

    /// The first position at which a run starts.
    pub(super) fn search(&self, mut starts: Range<usize>) -> Option<(usize, Resync)> {
        starts.find_map(|at| Some((at, self.run(at)?)))
    }

    /// Returns the kind of run that starts here, if any.
    #[inline]
    fn run(&self, at: usize) -> Option<Resync> {
        let rest = self.bytes.get(at..)?;
        let header = Header::read(rest).filter(|header| header.is_plausible())?;
        if header.kind == b'S' {
            return rest
                .get(HEADER..header.total())
                .filter(|found| *found == SYNC)
                .map(|_| Resync::Synchronisation);
        }
        let is_start = match self.plausibility(header, rest.get(HEADER..header.total())?) {
            Plausibility::Sound => true,
            // The first data message of an id is only `Possible`, since the usual size isn't known yet.
            Plausibility::Possible => {
                self.ids.allow(&rest[HEADER..]) && header.total() <= LARGEST_POSSIBLE_START
            }
            Plausibility::Wrong => false,
        };
        let is_run = is_start
            && match self.walk(at, SOUND_RUN) {
                Walk::Enough => true,
                Walk::End { sound } | Walk::Truncated { sound } => sound >= RUN_AT_END,
                Walk::Corrupt => false,
            };
        is_run.then_some(Resync::Messages)
    }

    /// True if a run of messages starts at this position, which is the end of another message.
    fn follows(&self, at: usize) -> bool {
        match self.walk(at, RUN_AFTER_MESSAGE) {
            Walk::Enough | Walk::End { .. } => true,
            Walk::Truncated { sound } => sound > 0,
            Walk::Corrupt => false,
        }
    }

    fn walk(&self, mut at: usize, wanted: usize) -> Walk {
        let mut sound = 0;
        for _ in 0..LONG_RUN {
            let rest = self.bytes.get(at..).unwrap_or_default();
            let Some(header) = Header::read(rest) else {
                return match (self.is_closed, rest) {
                    (true, []) => Walk::End { sound },
                    (true, _) => Walk::Truncated { sound },
                    (false, _) => Walk::Corrupt,
                };
            };
            let Some(payload) = rest.get(HEADER..header.total()) else {
                let is_truncated = self.is_closed && header.is_plausible();
                return if is_truncated { Walk::Truncated { sound } } else { Walk::Corrupt };
            };
            match self.plausibility(header, payload) {
                Plausibility::Sound => sound += 1,
                Plausibility::Possible => {}
                Plausibility::Wrong => return Walk::Corrupt,
            }
            if sound >= wanted {
                return Walk::Enough;
            }
            at += header.total();
        }
        Walk::Enough
    }

    fn plausibility(&self, header: Header, payload: &[u8]) -> Plausibility {
        if !header.is_known() {
            return if header.kind.is_ascii_alphabetic() {
                Plausibility::Possible
            } else {
                Plausibility::Wrong
            };
        }
        if !header.is_plausible() {
            return Plausibility::Wrong;
        }
        let is_sound = match (header.kind, payload) {
            (b'D', id) if self.ids.size(id) == header.size => true,
            (b'D', _) => return Plausibility::Possible,
            (b'F', text) => is_format(text),
            (b'I' | b'P', entry) | (b'M' | b'Q', [_, entry @ ..]) => is_entry(entry),
            (b'A', [_, _, _, name @ ..]) => name.iter().take(TEXT).copied().all(is_word),
            (b'L', [level, ..]) => is_line(*level, &payload[9..]),
            (b'C', [level, ..]) => is_line(*level, &payload[11..]),
            (b'S', magic) => magic == SYNC,
            (b'R' | b'O', _) => payload.len() == 2,
            // Flag bits only appear at the start of a log, where no search is necessary.
            _ => false,
        };
        if is_sound { Plausibility::Sound } else { Plausibility::Wrong }
    }
}

/// True for characters that may appear in the names of topics and fields.
fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"_/-.".contains(&byte)
}

fn is_format(text: &[u8]) -> bool {
    let text = &text[..text.len().min(TEXT)];
    let name = text.iter().take_while(|byte| is_word(**byte)).count();
    name > 0 && text.get(name).is_none_or(|byte| *byte == b':') && text.iter().copied().all(is_printable)
}

/// True if the bytes consist of a key length, a key with its type, and a value.
fn is_entry(entry: &[u8]) -> bool {
    let Some((length, rest)) = entry.split_first() else { return false };
    let Some(key) = rest.get(..usize::from(*length)) else { return false };
    let key = &key[..key.len().min(TEXT)];
    key.first().is_some_and(u8::is_ascii_alphabetic)
        && key.iter().copied().all(is_printable)
        && key.contains(&b' ')
}

fn is_printable(byte: u8) -> bool {
    matches!(byte, b' '..=b'~')
}

fn is_line(level: u8, text: &[u8]) -> bool {
    // Real logs contain tabs, newlines and colour escapes.
    let is_text = |byte: &u8| !byte.is_ascii_control() || b"\t\n\r\x1b".contains(byte);
    level.is_ascii_digit() && level < b'8' && text.iter().take(TEXT).all(is_text)
}
