//! Delays messages until the time in UTC is known.

use std::io::{self, BufReader, BufWriter, Read, Write};

use mcap::records::MessageHeader;
use tempfile::SpooledTempFile;
use uavspec_capture::mcap::metadata_body;

use super::super::bag::Target;
use super::super::{information, rewound};
use crate::clock::Clock;
use crate::limits::MAX_IN_MEMORY;

/// The start of a ROS message with a stamp: the CDR header, and the stamp in seconds and nanoseconds.
const STAMP: std::ops::Range<usize> = 4..12;

/// The output. Its messages wait until the log contains the time of a satellite navigation receiver.
pub(super) struct Timed<'o> {
    pub(super) output: Target<'o>,
    clock: Clock,
    /// The waiting messages. `None` once they have been written.
    waiting: Option<BufWriter<SpooledTempFile>>,
}

/// The place of a message in the output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) channel: u16,
    /// True if the message starts with a stamp.
    pub(super) is_stamped: bool,
    /// The time, in µs of the vehicle's clock.
    pub(super) time: u64,
}

impl<'o> Timed<'o> {
    pub(super) fn new(output: Target<'o>) -> Self {
        let waiting = Some(BufWriter::new(SpooledTempFile::new(MAX_IN_MEMORY)));
        Self { output, clock: Clock::default(), waiting }
    }

    /// Sets the start of the log, in µs of the vehicle's clock.
    pub(super) fn start(&mut self, time: u64) {
        self.clock.start(time);
    }

    /// Sets the time in UTC that corresponds to a time of the vehicle's clock, unless it is implausible.
    pub(super) fn set_utc(&mut self, time: u64, utc: u64) -> io::Result<()> {
        self.clock.set_utc(time, utc);
        if self.waiting.is_some()
            && let Some(offset) = self.clock.utc_micros(0)
        {
            self.write_times(offset)?;
            self.write_waiting()?;
        }
        Ok(())
    }

    fn write_times(&mut self, utc_offset: u64) -> io::Result<()> {
        let (name, values) = information::times(self.clock.start_time(), utc_offset);
        self.output.metadata(&metadata_body(name, &values))
    }

    /// Writes a message with its stamp.
    pub(super) fn message(&mut self, place: Place, payload: &mut [u8]) -> io::Result<()> {
        match &mut self.waiting {
            Some(waiting) => {
                waiting.write_all(&place.channel.to_le_bytes())?;
                waiting.write_all(&[u8::from(place.is_stamped)])?;
                waiting.write_all(&place.time.to_le_bytes())?;
                waiting.write_all(&(payload.len() as u64).to_le_bytes())?;
                waiting.write_all(payload)
            }
            None => self.write(place, payload),
        }
    }

    /// Writes the waiting messages.
    fn write_waiting(&mut self) -> io::Result<()> {
        let Some(waiting) = self.waiting.take() else { return Ok(()) };
        let mut waiting = BufReader::new(rewound(waiting)?);
        let mut payload = Vec::new();
        while let Some(channel) = next::<2>(&mut waiting)? {
            let (Some([is_stamped]), Some(time), Some(size)) =
                (next(&mut waiting)?, next(&mut waiting)?, next(&mut waiting)?)
            else {
                break;
            };
            let place = Place {
                channel: u16::from_le_bytes(channel),
                is_stamped: is_stamped != 0,
                time: u64::from_le_bytes(time),
            };
            payload.clear();
            waiting.by_ref().take(u64::from_le_bytes(size)).read_to_end(&mut payload)?;
            self.write(place, &mut payload)?;
        }
        Ok(())
    }

    fn write(&mut self, place: Place, payload: &mut [u8]) -> io::Result<()> {
        let time = self.clock.utc_micros(place.time).unwrap_or(place.time);
        if let Some(stamp) = payload.get_mut(STAMP).filter(|_| place.is_stamped) {
            let seconds = i32::try_from(time / 1_000_000).unwrap_or(i32::MAX);
            let nanoseconds = time % 1_000_000 * 1_000;
            stamp[..4].copy_from_slice(&seconds.to_le_bytes());
            stamp[4..].copy_from_slice(&nanoseconds.to_le_bytes()[..4]);
        }
        let time = time.saturating_mul(1_000);
        let header =
            MessageHeader { channel_id: place.channel, sequence: 0, log_time: time, publish_time: time };
        self.output.message(&header, payload)
    }

    /// Writes the remaining messages. Returns true if their times are in UTC.
    pub(super) fn finish(&mut self) -> io::Result<bool> {
        let is_utc = self.waiting.is_none();
        if !is_utc {
            self.write_times(0)?;
        }
        self.write_waiting()?;
        Ok(is_utc)
    }
}

/// Reads the next bytes; `None` at the end.
fn next<const SIZE: usize>(input: &mut impl Read) -> io::Result<Option<[u8; SIZE]>> {
    let mut bytes = [0; SIZE];
    match input.read_exact(&mut bytes) {
        Ok(()) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
        Err(error) => Err(error),
    }
}
