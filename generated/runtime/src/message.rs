//! The traits of messages.

use crate::cdr::{self, ByteOrder};
use crate::error::{DecodeError, EncodeError};
use crate::record::Record;
use crate::uorb;
use crate::validate::{self, Violation};

/// The constants of a message.
///
/// One constant with all values compiles faster than one constant for each value.
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
    /// The constants of a message that has no topics, version, hashes or fixed CDR size.
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

/// A message: its constants, its CDR codec and its validation.
///
/// ```
/// use uavspec_runtime::cdr::ByteOrder;
/// use uavspec_runtime::{Definition, Message, record};
///
/// #[derive(Clone, Default, PartialEq)]
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
pub trait Message: Record + Clone + Default + PartialEq + 'static {
    /// A struct with all constants of the message.
    const DEFINITION: Definition;
    /// The name of the package.
    const PACKAGE: &'static str = Self::DEFINITION.package;
    /// The name within the package.
    const NAME: &'static str = Self::DEFINITION.name;
    /// The uORB topics with this message type. The first topic is not always the default topic.
    const TOPICS: &'static [&'static str] = Self::DEFINITION.topics;
    /// The version of the message: `MESSAGE_VERSION`.
    const VERSION: Option<u32> = Self::DEFINITION.version;
    /// The number of messages that a topic queues before it drops the oldest message: `ORB_QUEUE_LENGTH`.
    const QUEUE_LENGTH: u32 = Self::DEFINITION.queue_length;
    /// PX4's hash of the fields.
    const HASH: u32 = Self::DEFINITION.hash;
    /// The ROS type hash: `RIHS01_` and 64 hexadecimal digits.
    const TYPE_HASH: &'static str = Self::DEFINITION.type_hash;
    /// The fixed CDR size in bytes, including the header, or `None` if the size varies.
    const CDR_SIZE: Option<usize> = Self::DEFINITION.cdr_size;

    /// Decodes a CDR payload in either byte order. A `bool` is false if its byte is 0, otherwise true.
    ///
    /// The payload may end with up to three padding bytes, which extend it to a multiple of four bytes.
    fn from_cdr(payload: &[u8]) -> Result<Self, DecodeError> {
        cdr::decode::<Self, false>(payload)
    }

    /// Like [`from_cdr`](Self::from_cdr), but a `bool` that is neither 0 nor 1 is an error.
    fn from_cdr_strict(payload: &[u8]) -> Result<Self, DecodeError> {
        cdr::decode::<Self, true>(payload)
    }

    /// Writes the CDR payload to the start of `buffer` and returns its size in bytes.
    fn encode_cdr(&self, order: ByteOrder, buffer: &mut [u8]) -> Result<usize, EncodeError> {
        cdr::encode(self, order, buffer)
    }

    /// Encodes the message as a CDR payload.
    #[cfg(feature = "alloc")]
    fn to_cdr(&self, order: ByteOrder) -> Result<alloc::vec::Vec<u8>, EncodeError> {
        let mut payload = alloc::vec![0; cdr::size(self)];
        let size = self.encode_cdr(order, &mut payload)?;
        payload.truncate(size);
        Ok(payload)
    }

    /// All violations of the definition, at most one per value.
    ///
    /// Even a default message can have violations, because 0 is not valid in every field.
    #[cfg(feature = "alloc")]
    fn validate(&self) -> alloc::vec::Vec<Violation> {
        let mut violations = alloc::vec::Vec::new();
        self.validate_with(&mut |violation| violations.push(violation));
        violations
    }

    /// Calls `report` with each violation of the definition.
    fn validate_with(&self, report: &mut dyn FnMut(Violation)) {
        validate::each(self, report);
    }
}

/// A fixed-size message, which has a memory layout in uORB.
pub trait UorbMessage: Message {
    /// Size in bytes, including the trailing padding.
    const SIZE: usize = Self::DESCRIPTOR.padded_size();
    /// Size without the trailing padding: the size that PX4 registers, and the minimum payload size in a log.
    const SIZE_NO_PADDING: usize = Self::DESCRIPTOR.no_padding();
    /// An array of `SIZE` bytes.
    type Bytes: uorb::Bytes;
    /// A payload of zeros.
    const ZEROS: Self::Bytes = <Self::Bytes as uorb::Bytes>::ZEROS;
    /// A view of a payload. Each method of the view reads one field.
    #[cfg(feature = "views")]
    type View<'b>: crate::view::View<'b>;

    /// Reads all fields of a view.
    #[cfg(feature = "views")]
    fn from_view(view: Self::View<'_>) -> Self;

    /// Decodes a payload, with or without the padding at its end. A `bool` is false if its byte is 0, otherwise true.
    #[inline]
    fn from_uorb(payload: &[u8]) -> Result<Self, DecodeError> {
        uorb::decode::<Self, false>(payload)
    }

    /// Like [`from_uorb`](Self::from_uorb), but a `bool` that is neither 0 nor 1 is an error.
    #[inline]
    fn from_uorb_strict(payload: &[u8]) -> Result<Self, DecodeError> {
        uorb::decode::<Self, true>(payload)
    }

    /// Creates a view of a payload, which may omit the padding at its end. Each field is read on access.
    #[cfg(feature = "views")]
    #[inline]
    fn view(payload: &[u8]) -> Result<Self::View<'_>, DecodeError> {
        Ok(crate::view::View::at(uorb::payload::<Self>(payload)?, 0))
    }

    /// Encodes the message, including the padding at its end.
    #[inline]
    fn to_uorb(&self) -> Self::Bytes {
        let mut payload = Self::ZEROS;
        uorb::encode(self, payload.as_mut());
        payload
    }
}
