//! Liveliness tokens. A token is a key that describes a node or an endpoint, and exists as long as it does.

use uavspec_model::limits::MAX_NAME;
use uavspec_model::{EndpointKind, Qos};

use super::keys::NO_HASH;
use super::qos::{format_qos, parse_qos};
use crate::bus::Topic;

/// The first part of each token.
const PREFIX: &str = "@ros2_lv";
/// The form of a token.
const FORM: &str = "@ros2_lv/DOMAIN/SESSION/NODE-ID/ID/KIND/ENCLAVE/NAMESPACE/NODE/TOPIC/TYPE/HASH/QOS";
/// The maximum length of a token, in bytes.
const MAX_LENGTH: usize = 2048;
/// The type and the hash of an endpoint whose type is unknown.
const NO_TYPE: (&str, &str) = ("EMPTY_TOPIC_TYPE", "EMPTY_TOPIC_HASH");

/// The token of a publisher or a subscriber.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Token {
    /// The Zenoh session, in hexadecimal digits.
    pub session: String,
    /// The kind of the endpoint.
    pub kind: EndpointKind,
    /// The node with its namespace, such as `/px4/bridge`.
    pub node: String,
    /// The topic. The type is empty if it's unknown.
    pub topic: Topic,
    /// The quality of service.
    pub qos: Qos,
}

impl Token {
    /// Parses a token. Returns `None` for nodes, services and clients. Later versions may append parts.
    pub(super) fn parse(key: &str) -> Result<Option<Self>, String> {
        if key.len() > MAX_LENGTH {
            return Err(format!("expected at most {MAX_LENGTH} bytes, found {}", key.len()));
        }
        let mut parts = key.split('/');
        let mut next = |name| checked(name, parts.next());
        for name in ["prefix", "domain"] {
            next(name)?;
        }
        let session = next("session")?.to_owned();
        for name in ["node id", "id"] {
            next(name)?;
        }
        let kind = match next("kind")? {
            "MP" => EndpointKind::Publisher,
            "MS" => EndpointKind::Subscriber,
            "NN" | "SC" | "SS" => return Ok(None),
            other => {
                return Err(format!("expected kind MP, MS, NN, SC or SS, found `{}`", other.escape_debug()));
            }
        };
        next("enclave")?;
        let namespace = demangle(next("namespace")?);
        let node = format!("{}/{}", namespace.trim_end_matches('/'), demangle(next("node")?));
        let topic = parse_topic(&mut next)?;
        let qos = parse_qos(next("quality of service")?)?;
        Ok(Some(Self { session, kind, node, topic, qos }))
    }

    /// Formats the token. `id` is the number of the endpoint in its session.
    pub(super) fn format(&self, domain: u16, id: u64) -> String {
        let kind = match self.kind {
            EndpointKind::Publisher => "MP",
            EndpointKind::Subscriber => "MS",
        };
        let (namespace, node) = self.node.rsplit_once('/').unwrap_or(("", &self.node));
        let (type_name, hash) = match &*self.topic.type_name {
            "" => (NO_TYPE.0.to_owned(), NO_TYPE.1),
            _ => (mangle(&self.topic.dds_type()), self.topic.type_hash.as_deref().unwrap_or(NO_HASH)),
        };
        let (session, namespace, topic) = (&self.session, mangle(namespace), mangle(&self.topic.name));
        let qos = format_qos(&self.qos);
        format!(
            "{PREFIX}/{domain}/{session}/0/{id}/{kind}/%/{namespace}/{node}/{topic}/{type_name}/{hash}/{qos}"
        )
    }
}

/// The token of a node without a namespace.
pub(super) fn node_token(domain: u16, session: &str, node: &str) -> String {
    format!("{PREFIX}/{domain}/{session}/0/0/NN/%/%/{node}")
}

/// The key that matches all tokens of a domain.
pub(super) fn all_tokens(domain: u16) -> String {
    format!("{PREFIX}/{domain}/**")
}

fn checked<'a>(name: &str, part: Option<&'a str>) -> Result<&'a str, String> {
    match part {
        None | Some("") => Err(format!("expected {FORM}, found no {name}")),
        Some(part) if part.len() > MAX_NAME => {
            Err(format!("{name}: expected at most {MAX_NAME} bytes, found {}", part.len()))
        }
        Some(part) => Ok(part),
    }
}

fn parse_topic<'a>(next: &mut impl FnMut(&'static str) -> Result<&'a str, String>) -> Result<Topic, String> {
    let name = demangle(next("topic")?).into();
    let (type_name, hash) = (demangle(next("type")?), next("type hash")?);
    let type_name = if type_name == NO_TYPE.0 { String::new() } else { Topic::ros_type(&type_name) };
    let has_hash = hash != NO_HASH && hash != NO_TYPE.1;
    Ok(Topic { name, type_name: type_name.into(), type_hash: has_hash.then(|| hash.into()) })
}

/// Replaces slashes, which separate the parts of a key.
fn mangle(name: &str) -> String {
    if name.is_empty() { "%".to_owned() } else { name.replace('/', "%") }
}

fn demangle(part: &str) -> String {
    part.replace('%', "/")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PX4: &str = "@ros2_lv/3/aac3178e/0/10/MP/%/%/px4/%fmu%out%vehicle_status/\
                       px4_msgs::msg::dds_::VehicleStatus_/RIHS01_0a/2:1:,1:,:,:,,";

    fn parse(key: &str) -> Token {
        Token::parse(key).expect("valid").expect("an endpoint")
    }

    fn token() -> impl Strategy<Value = Token> {
        let topic =
            ("(/[a-z]{1,5}){1,3}", "[a-z]{1,5}/msg/[A-Z]{1,5}", prop::option::of("RIHS01_[0-9]{1,4}"));
        let kind = prop::sample::select(vec![EndpointKind::Publisher, EndpointKind::Subscriber]);
        ("[0-9a-f]{1,8}", kind, "(/[a-z]{1,5}){1,3}", topic).prop_map(|(session, kind, node, topic)| {
            let (name, type_name, type_hash) = topic;
            let topic = Topic {
                name: name.into(),
                type_name: type_name.into(),
                type_hash: type_hash.map(Into::into),
            };
            Token { session, kind, node, topic, qos: Qos::PX4 }
        })
    }

    proptest! {
        #[test]
        fn a_formatted_token_parses_to_itself(token in token(), domain: u16, id: u64) {
            prop_assert_eq!(Token::parse(&token.format(domain, id)), Ok(Some(token)));
        }

        #[test]
        fn changed_tokens_never_panic(at in 0..PX4.len(), text in "[/%:,9é*]{0,3}", rest in 0..PX4.len()) {
            drop(Token::parse(&format!("{}{text}{}", &PX4[..at], &PX4[rest..])));
        }
    }

    #[test]
    fn a_parsed_token_formats_to_itself() {
        let token = parse(PX4);
        assert_eq!((&*token.node, token.kind), ("/px4", EndpointKind::Publisher));
        let names = (&*token.topic.name, &*token.topic.type_name);
        assert_eq!(names, ("/fmu/out/vehicle_status", "px4_msgs/msg/VehicleStatus"));
        assert_eq!(token.qos, Qos::PX4);
        assert_eq!(token.format(3, 10), PX4);
        assert_eq!(parse(&format!("{PX4}/later")), token);
    }

    #[test]
    fn nodes_and_services_are_no_endpoints() {
        for kind in ["NN", "SS", "SC"] {
            assert_eq!(Token::parse(&PX4.replace("MP", kind)), Ok(None));
        }
    }

    #[test]
    fn hashes_and_types_may_be_missing() {
        let humble = parse(&PX4.replace("RIHS01_0a", NO_HASH));
        assert_eq!((&*humble.topic.type_name, humble.topic.type_hash), ("px4_msgs/msg/VehicleStatus", None));
        let unknown = parse("@ros2_lv/0/a/0/1/MS/%/%ns/n/%t/EMPTY_TOPIC_TYPE/EMPTY_TOPIC_HASH/::,:,:,:,,");
        assert_eq!((&*unknown.node, &*unknown.topic.type_name), ("/ns/n", ""));
        assert_eq!(unknown.topic.type_hash, None);
    }

    #[test]
    fn errors_name_the_part() {
        for (key, part) in [
            ("@ros2_lv/0/a", "found no node id"),
            ("@ros2_lv/0/a/0/1/ZZ", "found `ZZ`"),
            (&PX4.replace("2:1", "7:1"), "reliability"),
            (&PX4.replace("status", &"x".repeat(300)), "topic: expected at most 256 bytes"),
            (&"x".repeat(MAX_LENGTH + 1), "expected at most 2048 bytes"),
        ] {
            let error = Token::parse(key).expect_err("an error");
            assert!(error.contains(part), "{error}");
        }
    }
}
