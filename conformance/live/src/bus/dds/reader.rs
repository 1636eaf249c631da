//! Subscribers of serialized messages.

use std::convert::Infallible;

use rustdds::bytes::Bytes;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter, SimpleDataReader};
use rustdds::{DomainParticipant, QosPolicies, RepresentationIdentifier, Subscriber, TopicKind};
use uavspec_model::{History, Qos};

use super::super::Topic;
use super::{names, qos};

/// The number of messages that rustdds stores for each topic: 256 ms at 250 Hz. It includes messages that have already
/// been read or sent.
pub(crate) const DEPTH: u32 = 64;

/// A subscriber of serialized messages.
pub(crate) type RawReader = SimpleDataReader<Vec<u8>, RawAdapter>;

/// Creates subscribers.
pub(crate) struct Readers {
    participant: DomainParticipant,
    subscriber: Subscriber,
}

impl Readers {
    pub(crate) fn new(participant: &DomainParticipant) -> Result<Self, String> {
        let subscriber = participant.create_subscriber(&QosPolicies::qos_none());
        let subscriber = subscriber.map_err(|error| format!("can't create a DDS subscriber: {error}"))?;
        Ok(Self { participant: participant.clone(), subscriber })
    }

    /// Creates a subscriber of a topic. The number of stored messages is the same for all subscribers, and DDS doesn't
    /// announce it.
    pub(crate) fn create(&self, topic: &Topic, qos: &Qos) -> Result<RawReader, String> {
        let policies = qos::to_policies(&Qos { history: Some(History::KeepLast(DEPTH)), ..qos.clone() });
        let (name, type_name) = (names::topic_to_dds(&topic.name), topic.dds_type());
        self.participant
            .create_topic(name, type_name, &policies, TopicKind::NoKey)
            .and_then(|topic| self.subscriber.create_simple_datareader_no_key(&topic, Some(policies)))
            .map_err(|error| format!("can't subscribe: {error}"))
    }
}

/// An adapter that passes on serialized messages unchanged.
pub(crate) struct RawAdapter;

/// All encodings that rustdds knows.
const ENCODINGS: [RepresentationIdentifier; 17] = {
    use RepresentationIdentifier as Id;
    [
        Id::CDR_LE,
        Id::CDR_BE,
        Id::PL_CDR_BE,
        Id::PL_CDR_LE,
        Id::XML,
        Id::XCDR2_BE,
        Id::XCDR2_LE,
        Id::D_CDR2_BE,
        Id::D_CDR2_LE,
        Id::PL_XCDR2_BE,
        Id::PL_XCDR2_LE,
        Id::CDR2_BE,
        Id::CDR2_LE,
        Id::PL_CDR2_BE,
        Id::PL_CDR2_LE,
        Id::D_CDR_BE,
        Id::D_CDR_LE,
    ]
};

impl DeserializerAdapter<Vec<u8>> for RawAdapter {
    type Error = Infallible;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &ENCODINGS
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for RawAdapter {
    type Decoder = RawDecoder;
    const DECODER: RawDecoder = RawDecoder;
}

/// A decoder that restores the encapsulation header of messages.
#[derive(Clone)]
pub(crate) struct RawDecoder;

impl Decode<'_, Vec<u8>> for RawDecoder {
    type Error = Infallible;

    fn decode_bytes(self, body: &[u8], encoding: RepresentationIdentifier) -> Result<Vec<u8>, Infallible> {
        // rustdds drops the options. They contain at most the number of padding bytes.
        Ok([&encoding.to_bytes(), &[0; 2], body].concat())
    }
}

impl SerializerAdapter<Bytes> for RawAdapter {
    type Error = Infallible;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(value: &Bytes) -> Result<Bytes, Infallible> {
        Ok(value.clone())
    }
}
