//! The traits of messages.

use crate::cdr::{self, ByteOrder};
use crate::error::{DecodeError, EncodeError};
use crate::record::Record;
use crate::uorb;
use crate::validate::{self, Violation};

/// The facts that a definition states about a message as a whole.
///
/// One constant for all of them is faster to compile than one constant for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Definition {
    /// See [`Message::PACKAGE`].
    pub package: &'static str,
    /// See [`Message::NAME`].
    pub name: &'static str,
    /// See [`Message::TOPICS`].
    pub topics: &'static [&'static str],
    /// See [`Message::VERSION`].
    pub version: Option<u32>,
    /// See [`Message::QUEUE_LENGTH`].
    pub queue_length: u32,
    /// See [`Message::HASH`].
    pub hash: u32,
    /// See [`Message::TYPE_HASH`].
    pub type_hash: &'static str,
    /// See [`Message::CDR_SIZE`].
    pub cdr_size: Option<usize>,
}

impl Definition {
    /// The definition of a message without topics, version, hashes and a fixed size in CDR.
    pub const fn new(package: &'static str, name: &'static str) -> Self {
        Self {
            package,
            name,
            topics: &[],
            version: None,
            queue_length: 1,
            hash: 0,
            type_hash: "",
            cdr_size: None,
        }
    }
}

/// A message of a definition: its constants, its CDR form and its checks.
///
/// ```
/// use uavspec_runtime::cdr::ByteOrder;
/// use uavspec_runtime::{Definition, Message, record};
///
/// #[derive(Clone, Debug, Default, PartialEq)]
/// struct Altitude {
///     metres: f32,
/// }
///
/// impl Message for Altitude {
///     const DEFINITION: Definition = Definition::new("example", "Altitude");
/// }
///
/// record! {
///     Altitude[1];
///     0 metres = float32("metres", 0);
/// }
///
/// let mut payload = [0; 8];
/// let size = Altitude { metres: 1.5 }.encode_cdr(ByteOrder::LittleEndian, &mut payload)?;
/// assert_eq!(Altitude::from_cdr(&payload[..size]).unwrap().metres, 1.5);
/// # Ok::<(), uavspec_runtime::EncodeError>(())
/// ```
pub trait Message: Record + Clone + Default + PartialEq {
    /// The facts that the constants below are taken from.
    const DEFINITION: Definition;
    /// Name of the package.
    const PACKAGE: &'static str = Self::DEFINITION.package;
    /// Name within the package.
    const NAME: &'static str = Self::DEFINITION.name;
    /// The uORB topics that carry it; the first is not always the default one.
    const TOPICS: &'static [&'static str] = Self::DEFINITION.topics;
    /// Version of the fields: `MESSAGE_VERSION`.
    const VERSION: Option<u32> = Self::DEFINITION.version;
    /// Number of messages that a topic holds before the oldest is lost: `ORB_QUEUE_LENGTH`.
    const QUEUE_LENGTH: u32 = Self::DEFINITION.queue_length;
    /// PX4's hash of the fields.
    const HASH: u32 = Self::DEFINITION.hash;
    /// ROS type hash: `RIHS01_` and 64 hexadecimal digits.
    const TYPE_HASH: &'static str = Self::DEFINITION.type_hash;
    /// Size in CDR with the encapsulation header, in bytes, if all values have one size.
    const CDR_SIZE: Option<usize> = Self::DEFINITION.cdr_size;

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
    const SIZE: usize = Self::DESCRIPTOR.padded_size();
    /// Size without the padding at its end: what PX4 registers, and the least that a log holds.
    const SIZE_NO_PADDING: usize = Self::DESCRIPTOR.no_padding();
    /// An array of `SIZE` bytes.
    type Bytes: uorb::Bytes;
    /// A payload of zeros.
    const ZEROS: Self::Bytes = <Self::Bytes as uorb::Bytes>::ZEROS;
    /// A view of the bytes of a payload, which reads a field when its method is called.
    type View<'b>: uorb::View<'b>;

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
        Ok(uorb::View::at(uorb::payload::<Self>(payload)?, 0))
    }

    /// The payload, with the padding at its end.
    #[inline]
    fn to_uorb(&self) -> Self::Bytes {
        let mut payload = Self::ZEROS;
        uorb::encode(self, payload.as_mut());
        payload
    }
}
