//! Flights as MCAP files in rosbag2 style: CDR messages with `ros2msg` schemas.

use uavspec_capture::MCAP_MAGIC;
use uavspec_capture::mcap::{APPLICATION, ENDPOINT, metadata_body};
use uavspec_model::{ApplicationType, Durability, Endpoint, EndpointKind, Qos};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::fingerprint::ros_name;

use super::Flight;

/// An MCAP file without chunks.
#[derive(Clone, Debug)]
pub struct Bag {
    /// The channels. The id of a channel is its index.
    pub channels: Vec<BagChannel>,
    /// The types of the application.
    pub application: Vec<ApplicationType>,
    /// The publishers and subscribers, which were discovered before the first message.
    pub endpoints: Vec<Endpoint>,
    /// The messages: channel index, time in ns, and payload.
    pub messages: Vec<(u16, u64, Vec<u8>)>,
}

/// A channel with its schema.
#[derive(Clone, Debug)]
pub struct BagChannel {
    /// The topic.
    pub topic: String,
    /// The name of the message type.
    pub schema: String,
    /// The definition of the message type, with the nested definitions.
    pub text: String,
    /// The type hash.
    pub hash: String,
}

impl Bag {
    /// Creates the file for a flight.
    pub(super) fn from_flight(flight: &Flight<'_>) -> Self {
        let schema = &flight.definitions.schema;
        let channels = flight.topics.iter().map(|topic| {
            let message = schema.message(topic.message);
            BagChannel {
                topic: format!("/fmu/out/{}", topic.name),
                schema: ros_name(schema, message),
                text: flight.definitions.bag_text(topic.message),
                hash: message.type_hash.clone(),
            }
        });
        // A recorder receives the messages in order, regardless of their timestamps.
        let mut now = 0;
        let messages = flight.messages.iter().filter_map(|sent| {
            now = now.max(sent.value["timestamp"].as_u64()? * 1_000);
            let payload = flight.message(sent)?.to_cdr(ByteOrder::LittleEndian).ok()?;
            Some((u16::try_from(sent.topic).ok()?, now, payload))
        });
        let channels: Vec<BagChannel> = channels.collect();
        let endpoints = channels.iter().flat_map(endpoints).collect();
        let application =
            flight.topics.first().map(|topic| ApplicationType::new(schema, schema.message(topic.message)));
        Self {
            channels,
            application: application.into_iter().collect(),
            endpoints,
            messages: messages.collect(),
        }
    }

    /// Changes the last payload.
    #[must_use]
    pub(crate) fn with_payload(mut self, change: impl FnOnce(&mut Vec<u8>)) -> Option<Self> {
        change(&mut self.messages.last_mut()?.2);
        Some(self)
    }

    /// The bytes of the file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MCAP_MAGIC.to_vec();
        record(&mut bytes, 0x01, &[&text("ros2"), &text("uavspec")]);
        for (id, channel) in (0_u16..).zip(&self.channels) {
            // Schema id 0 means no schema.
            let schema = (id + 1).to_le_bytes();
            let definition = sized(channel.text.as_bytes());
            record(&mut bytes, 0x03, &[&schema, &text(&channel.schema), &text("ros2msg"), &definition]);
            let metadata = [text("topic_type_hash"), text(&channel.hash)].concat();
            let id = id.to_le_bytes();
            record(&mut bytes, 0x04, &[&id, &schema, &text(&channel.topic), &text("cdr"), &sized(&metadata)]);
        }
        for ty in &self.application {
            record(&mut bytes, 0x0c, &[&metadata_body(APPLICATION, &ty.to_values())]);
        }
        for endpoint in &self.endpoints {
            record(&mut bytes, 0x0c, &[&metadata_body(ENDPOINT, &endpoint.to_values())]);
        }
        for (sequence, (channel, time, payload)) in (0_u32..).zip(&self.messages) {
            let time = time.to_le_bytes();
            record(
                &mut bytes,
                0x05,
                &[&channel.to_le_bytes(), &sequence.to_le_bytes(), &time, &time, payload],
            );
        }
        record(&mut bytes, 0x0f, &[&[0; 4]]);
        record(&mut bytes, 0x02, &[&[0; 20]]);
        bytes.extend(MCAP_MAGIC);
        bytes
    }
}

/// A publisher of a channel with the quality of service of PX4, and a subscriber that requests less.
fn endpoints(channel: &BagChannel) -> [Endpoint; 2] {
    let publisher = Endpoint {
        id: format!("publisher {}", channel.topic),
        kind: EndpointKind::Publisher,
        node: Some("/px4".to_owned()),
        topic: channel.topic.clone(),
        type_name: channel.schema.clone(),
        type_hash: Some(channel.hash.clone()),
        qos: Some(Qos::PX4),
        is_matched_by_qos: true,
    };
    let subscriber = Endpoint {
        id: format!("subscriber {}", channel.topic),
        kind: EndpointKind::Subscriber,
        node: Some("/application".to_owned()),
        qos: Some(Qos { durability: Durability::Volatile, ..Qos::PX4 }),
        ..publisher.clone()
    };
    [publisher, subscriber]
}

fn record(bytes: &mut Vec<u8>, kind: u8, parts: &[&[u8]]) {
    let body = parts.concat();
    bytes.push(kind);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(body);
}

/// Prefixes bytes with their length.
fn sized(bytes: &[u8]) -> Vec<u8> {
    // No definition exceeds this length.
    [&u32::try_from(bytes.len()).unwrap_or(u32::MAX).to_le_bytes(), bytes].concat()
}

fn text(text: &str) -> Vec<u8> {
    sized(text.as_bytes())
}
