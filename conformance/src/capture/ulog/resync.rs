//! Whether bytes are a message, and where the next one starts if they aren't.

use std::collections::BTreeMap;
use std::ops::Range;

use super::kind::{HEADER, Header, LARGEST, SYNC};
use super::problem::Resync;

/// So many sound messages that follow each other are no accident.
const SOUND_RUN: usize = 4;

/// The same where the log or a section ends, so that there may be no more.
const RUN_AT_END: usize = 2;

/// The same where the start isn't chosen, but where a message ended.
const RUN_BEHIND_MESSAGE: usize = 1;

/// So many messages are no accident even if most are only possible: one start in five looks like such.
const LONG_RUN: usize = 16;

/// The largest message that is the start of a run though it is only possible. In noise before a log, one
/// start in 256 looks like data of up to 64 KiB, and some of these end by accident where a message starts,
/// which makes them starts of a run that swallows the messages between. Data of PX4 is smaller than this.
const LARGEST_POSSIBLE_START: usize = 1_024;

/// How much of a text is looked at: names are shorter, and time must not depend on sizes that may be wrong.
const TEXT: usize = 64;

/// How far ahead is looked: a message and a run behind it, all of them as large as can be.
pub(super) const LOOKAHEAD: usize = (SOUND_RUN + 1) * LARGEST;

/// What the bytes of a section start with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Beginning {
    /// Nothing: it ends here.
    End,
    /// A message.
    Message(Header),
    /// A message, or a part of a header, that goes beyond the end.
    Truncated,
    /// Bytes to skip; how many.
    Skip(usize, Resync),
    /// No message, and none starts in so many bytes.
    Lost(usize),
}

/// The ids that were subscribed, each with the size of its messages. A topic has always the same, so that
/// another size is a reason for doubt: it may end by accident where a message starts.
#[derive(Debug)]
pub(super) struct Ids {
    sizes: Box<[u16]>,
    /// Sizes that came once instead. One that comes twice in a row is taken.
    doubtful: BTreeMap<u16, u16>,
    is_empty: bool,
}

/// The size of messages whose id isn't subscribed.
const UNSUBSCRIBED: u16 = 0;

/// The size where no message has come yet. Data has at least the two bytes of its id.
const UNSEEN: u16 = 1;

impl Default for Ids {
    fn default() -> Self {
        let sizes = vec![UNSUBSCRIBED; usize::from(u16::MAX) + 1].into_boxed_slice();
        Self { sizes, doubtful: BTreeMap::new(), is_empty: true }
    }
}

impl Ids {
    /// Notes that an id was subscribed.
    pub(super) fn subscribe(&mut self, id: u16) {
        self.sizes[usize::from(id)] = UNSEEN;
        self.is_empty = false;
    }

    /// Notes the size of a message.
    pub(super) fn see(&mut self, id: u16, size: u16) {
        let usual = &mut self.sizes[usize::from(id)];
        if *usual == UNSUBSCRIBED || *usual == size {
            self.doubtful.remove(&id);
        } else if *usual == UNSEEN || self.doubtful.insert(id, size) == Some(size) {
            *usual = size;
        }
    }

    /// Whether messages with the id that `payload` starts with have this size.
    #[inline]
    pub(super) fn expect(&self, size: u16, payload: &[u8]) -> bool {
        self.size(payload) == size
    }

    #[inline]
    fn size(&self, payload: &[u8]) -> u16 {
        payload.first_chunk().map_or(UNSUBSCRIBED, |id| self.sizes[usize::from(u16::from_le_bytes(*id))])
    }

    /// Whether nothing speaks against an id and a size: no message of that id has come yet, and it was
    /// subscribed unless none was.
    fn allow(&self, payload: &[u8]) -> bool {
        self.is_empty || self.size(payload) == UNSEEN
    }
}

/// What is ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look<'b> {
    /// Bytes of this section.
    pub(super) bytes: &'b [u8],
    /// Whether these are all that it has.
    pub(super) is_closed: bool,
    /// Whether the log has no messages before these, so that flag bits may be here.
    pub(super) is_first: bool,
    pub(super) ids: &'b Ids,
}

/// How a walk from message to message ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Walk {
    /// There are as many messages as were wanted.
    Enough,
    /// The section ends with a message.
    End { sound: usize },
    /// The section ends within a message.
    Truncated { sound: usize },
    /// At something else than a message.
    Corrupt,
}

/// How much the look of a message says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plausibility {
    /// Its kind is known and its contents are in order: less than one in a hundred thousand starts is so
    /// by accident.
    Sound,
    /// Data of an id that isn't known, or of a size that it hasn't had, or a kind that may be one of the
    /// future.
    Possible,
    Wrong,
}

impl Look<'_> {
    /// A header, and the id that follows it if it is one of data.
    pub(super) const NEXT: usize = HEADER + 2;

    /// Judges by the message and what [`NEXT`](Self::NEXT) bytes behind it say. That is enough nearly always.
    pub(super) fn classify(&self) -> Option<Beginning> {
        if self.bytes.is_empty() && self.is_closed {
            return Some(Beginning::End);
        }
        let header = Header::read(self.bytes)?;
        let (message, behind) = self.bytes.split_at_checked(header.total())?;
        let goes_on = match (Header::read(behind), behind.get(HEADER..Self::NEXT)) {
            (None, _) => self.is_closed,
            (Some(Header { kind: b'D', size }), Some(id)) => self.ids.expect(size, id),
            (Some(next), _) => next.is_usual(),
        };
        let is_sound = || match header.kind {
            b'B' => self.is_first && header.is_believable(),
            _ => self.looks(header, &message[HEADER..]) == Plausibility::Sound,
        };
        (goes_on && is_sound()).then_some(Beginning::Message(header))
    }

    /// Judges by what follows.
    pub(super) fn classify_ahead(&self) -> Beginning {
        let Some(header) = Header::read(self.bytes) else { return Beginning::Truncated };
        let end = header.total();
        let searched = end.min(self.bytes.len());
        if let Some((count, resync)) = self.search(1..searched) {
            return Beginning::Skip(count, resync);
        }
        let is_complete = end <= self.bytes.len();
        match header.is_believable() {
            true if is_complete => Beginning::Message(header),
            true => Beginning::Truncated,
            false if is_complete && self.follows(end) => Beginning::Message(header),
            false => Beginning::Lost(searched),
        }
    }

    /// The first start of a run.
    pub(super) fn search(&self, mut starts: Range<usize>) -> Option<(usize, Resync)> {
        starts.find_map(|at| Some((at, self.run(at)?)))
    }

    /// Whether a run starts here.
    #[inline]
    fn run(&self, at: usize) -> Option<Resync> {
        let rest = self.bytes.get(at..)?;
        let header = Header::read(rest).filter(|header| header.is_believable())?;
        if header.kind == b'S' {
            return rest
                .get(HEADER..header.total())
                .filter(|found| *found == SYNC)
                .map(|_| Resync::Synchronisation);
        }
        let is_start = match self.looks(header, rest.get(HEADER..header.total())?) {
            Plausibility::Sound => true,
            // The first data of an id isn't sound, since its size isn't known.
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

    /// Whether messages follow where one ends.
    fn follows(&self, at: usize) -> bool {
        match self.walk(at, RUN_BEHIND_MESSAGE) {
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
                let is_truncated = self.is_closed && header.is_believable();
                return if is_truncated { Walk::Truncated { sound } } else { Walk::Corrupt };
            };
            match self.looks(header, payload) {
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

    fn looks(&self, header: Header, payload: &[u8]) -> Plausibility {
        if !header.is_known() {
            return if header.kind.is_ascii_alphabetic() {
                Plausibility::Possible
            } else {
                Plausibility::Wrong
            };
        }
        if !header.is_believable() {
            return Plausibility::Wrong;
        }
        let is_sound = match (header.kind, payload) {
            (b'D', id) if self.ids.expect(header.size, id) => true,
            (b'D', _) => return Plausibility::Possible,
            (b'F', text) => is_format(text),
            (b'I' | b'P', entry) | (b'M' | b'Q', [_, entry @ ..]) => is_entry(entry),
            (b'A', [_, _, _, name @ ..]) => name.iter().take(TEXT).copied().all(is_word),
            (b'L', [level, ..]) => is_line(*level, &payload[9..]),
            (b'C', [level, ..]) => is_line(*level, &payload[11..]),
            (b'S', magic) => magic == SYNC,
            (b'R' | b'O', _) => payload.len() == 2,
            // Flag bits are only at the start of a log, which needs no search.
            _ => false,
        };
        if is_sound { Plausibility::Sound } else { Plausibility::Wrong }
    }
}

/// Of a name of a topic or a field.
fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"_/-.".contains(&byte)
}

fn is_format(text: &[u8]) -> bool {
    let text = &text[..text.len().min(TEXT)];
    let name = text.iter().take_while(|byte| is_word(**byte)).count();
    name > 0 && text.get(name).is_none_or(|byte| *byte == b':') && text.iter().copied().all(is_printable)
}

/// The length of a key, the key with its type, and a value.
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
    // Tabs, ends of lines and the escapes of colours are in real logs.
    let is_text = |byte: &u8| !byte.is_ascii_control() || b"\t\n\r\x1b".contains(byte);
    level.is_ascii_digit() && level < b'8' && text.iter().take(TEXT).all(is_text)
}
