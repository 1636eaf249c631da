//! The traits of messages.

use crate::cdr::{self, ByteOrder};
use crate::error::{DecodeError, EncodeError};
use crate::record::Record;
use crate::uorb;
use crate::validate::{self, Violation};

/// A message of a definition: what is known of it while compiling, its CDR form, and its checks.
pub trait Message: Record + Clone + Default + PartialEq {
    /// Its package.
    const PACKAGE: &'static str;
    /// Its name within the package.
    const NAME: &'static str;
    /// The uORB topics that carry it; the first is not always the default one.
    const TOPICS: &'static [&'static str] = &[];
    /// Version of its fields: `MESSAGE_VERSION`.
    const VERSION: Option<u32> = None;
    /// How many messages a topic holds before the oldest is lost: `ORB_QUEUE_LENGTH`.
    const QUEUE_LENGTH: u32 = 1;
    /// PX4's hash of its fields.
    const HASH: u32;
    /// Its ROS type hash, `RIHS01_` and 64 hexadecimal digits.
    const TYPE_HASH: &'static str;
    /// Size in CDR with the encapsulation header, in bytes, where all values have the same.
    const CDR_SIZE: Option<usize> = None;
    /// Reads a CDR payload in either byte order. A `bool` is true unless its byte is 0.
    ///
    /// Up to three bytes may follow, which fill the payload up to a multiple of four.
    fn from_cdr(payload: &[u8]) -> Result<Self, DecodeError> {
        cdr::decode::<Self, false>(payload)
    }

    /// As [`from_cdr`](Self::from_cdr), but refuses a `bool` that is neither 0 nor 1.
    fn from_cdr_strict(payload: &[u8]) -> Result<Self, DecodeError> {
        cdr::decode::<Self, true>(payload)
    }

    /// Writes the CDR payload to the start of `buffer` and returns its size in bytes.
    fn encode_cdr(&self, order: ByteOrder, buffer: &mut [u8]) -> Result<usize, EncodeError> {
        cdr::encode(self, order, buffer)
    }

    /// The CDR payload.
    #[cfg(feature = "alloc")]
    fn to_cdr(&self, order: ByteOrder) -> Result<alloc::vec::Vec<u8>, EncodeError> {
        let mut payload = alloc::vec![0; cdr::size(self)];
        let size = self.encode_cdr(order, &mut payload)?;
        payload.truncate(size);
        Ok(payload)
    }

    /// Everything in it that breaks a rule of its definition, one rule a value.
    ///
    /// A default message may break some, where 0 is no value that a field may have.
    #[cfg(feature = "alloc")]
    fn validate(&self) -> alloc::vec::Vec<Violation> {
        let mut violations = alloc::vec::Vec::new();
        self.validate_with(&mut |violation| violations.push(violation));
        violations
    }

    /// Calls `report` with everything in it that breaks a rule of its definition.
    fn validate_with(&self, report: &mut dyn FnMut(Violation)) {
        validate::each(self, report);
    }
}

/// A message of fixed size, which therefore has a memory form in uORB.
pub trait UorbMessage: Message {
    /// Size with the padding at its end, in bytes.
    const SIZE: usize;
    /// Size without the padding at its end: what PX4 registers, and the least that a log holds.
    const SIZE_NO_PADDING: usize;
    /// As many bytes as its size.
    type Bytes: AsRef<[u8]> + AsMut<[u8]> + Copy;
    /// So many zeros.
    const ZEROS: Self::Bytes;
    /// Looks at the bytes of a payload, each field being read when it is asked for.
    type View<'b>;

    /// The view of the message at `offset`.
    #[doc(hidden)]
    fn view_at(bytes: &[u8], offset: usize) -> Self::View<'_>;

    /// Reads all fields that a view shows.
    fn from_view(view: Self::View<'_>) -> Self;

    /// Reads a payload, with or without the padding at its end. A `bool` is true unless its byte is 0.
    #[inline]
    fn from_uorb(payload: &[u8]) -> Result<Self, DecodeError> {
        uorb::decode::<Self, false>(payload)
    }

    /// As [`from_uorb`](Self::from_uorb), but refuses a `bool` that is neither 0 nor 1.
    #[inline]
    fn from_uorb_strict(payload: &[u8]) -> Result<Self, DecodeError> {
        uorb::decode::<Self, true>(payload)
    }

    /// Looks at a payload, with or without the padding at its end, without reading all of it.
    #[inline]
    fn view(payload: &[u8]) -> Result<Self::View<'_>, DecodeError> {
        Ok(Self::view_at(uorb::payload::<Self>(payload)?, 0))
    }

    /// The payload, with the padding at its end.
    #[inline]
    fn to_uorb(&self) -> Self::Bytes {
        let mut payload = Self::ZEROS;
        uorb::encode(self, payload.as_mut());
        payload
    }
}
