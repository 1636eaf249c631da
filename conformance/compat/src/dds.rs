//! The topics that PX4 offers over DDS, from its file `dds_topics.yaml`.

use std::collections::BTreeMap;
use std::path::Path;

use saphyr_parser::{Event, Parser};
use uavspec_model::text::terminal;
use uavspec_schema::Failure;

use crate::limits::{MAX_DEPTH, MAX_SOURCE};
use crate::source::{Direction, Topic};

/// The folder of PX4's sources that contains the file.
pub(crate) const FOLDER: &str = "src/modules/uxrce_dds_client";

/// The name of the file.
pub(crate) const FILE_NAME: &str = "dds_topics.yaml";

/// The depth of an entry: in a list, in a mapping.
const ENTRY: usize = 3;

/// The topics that PX4 offers over DDS.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DdsTopics(BTreeMap<(Direction, String), Option<f64>>);

impl DdsTopics {
    /// Reads a file.
    ///
    /// # Errors
    /// Fails if the file can't be read, or contains no topics.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let problem = |problem: String| Failure::new(format!("{}: {problem}", terminal::path(path)));
        let text = std::fs::read_to_string(path).map_err(|error| problem(error.to_string()))?;
        Self::parse(&text).map_err(problem)
    }

    /// Reads the file in a checkout of PX4. `None` if there is no such file.
    ///
    /// # Errors
    /// Fails as [`Self::read`] does.
    pub fn of_checkout(path: &Path) -> Result<Option<Self>, Failure> {
        let file = path.join(FOLDER).join(FILE_NAME);
        file.is_file().then(|| Self::read(&file)).transpose()
    }

    fn parse(text: &str) -> Result<Self, String> {
        if text.len() > MAX_SOURCE {
            return Err(format!("it is longer than {MAX_SOURCE} bytes"));
        }
        let mut topics = BTreeMap::new();
        let mut depth = 0usize;
        let (mut key, mut topic) = (None, None);
        for event in Parser::new_from_str(text) {
            match event.map_err(|error| format!("invalid YAML: {error}"))?.0 {
                Event::MappingStart(..) | Event::SequenceStart(..) => {
                    depth += 1;
                    key = None;
                    if depth == ENTRY {
                        topic = None;
                    }
                }
                Event::MappingEnd | Event::SequenceEnd => {
                    depth = depth.saturating_sub(1);
                    key = None;
                }
                Event::Scalar(value, ..) => match key.take().as_deref() {
                    None => key = Some(value.into_owned()),
                    Some("topic") => {
                        topic = named(&value);
                        topics.extend(topic.clone().map(|topic| (topic, None)));
                    }
                    // A rate of 0 and a word mean that all messages are sent.
                    Some("rate_limit") => {
                        let rate = value.parse().ok().filter(|rate| *rate > 0.0);
                        topics.extend(topic.clone().map(|topic| (topic, rate)));
                    }
                    Some(_) => {}
                },
                Event::Alias(_) => key = None,
                _ => {}
            }
            if depth > MAX_DEPTH {
                return Err(format!("it has more than {MAX_DEPTH} nested lists and mappings"));
            }
        }
        if topics.is_empty() { Err("it contains no topics".to_owned()) } else { Ok(Self(topics)) }
    }

    /// The maximum rate of a topic in messages per second, if it is limited. `None` if PX4 doesn't offer the topic.
    pub fn rate(&self, topic: &Topic) -> Option<Option<f64>> {
        self.0.get(&topic.key()).copied()
    }
}

/// The direction and the name of a topic.
fn named(text: &str) -> Option<(Direction, String)> {
    let (topic, _) = Topic::read_full(text)?;
    Some(topic.key())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::source::Version;

    const FILE: &str = "publications:\n  - topic: /fmu/out/wind\n    type: px4_msgs::msg::Wind\n    rate_limit: 1.\n\
                        \x20 - topic: /fmu/out/home_position\n    type: px4_msgs::msg::HomePosition\n\
                        \x20   options: {express: true}\n    rate_limit: unlimited\n\
                        subscriptions:\n  # - topic: /fmu/in/absent\n  - topic: /fmu/in/wind\n    type: px4_msgs::msg::Wind\n\
                        subscriptions_multi:\n";

    #[test]
    fn rates_are_read() {
        let topics = DdsTopics::parse(FILE).expect("topics");
        let rate = |direction, name: &str| {
            topics.rate(&Topic { direction, name: name.to_owned(), version: Version::Stated(1) })
        };
        assert_eq!(rate(Direction::Out, "wind"), Some(Some(1.0)));
        assert_eq!(rate(Direction::In, "wind"), Some(None));
        assert_eq!(rate(Direction::Out, "home_position"), Some(None));
        assert_eq!(rate(Direction::In, "absent"), None);
        assert_eq!(DdsTopics::parse("a: b"), Err("it contains no topics".to_owned()));
        assert!(DdsTopics::parse("a: [").expect_err("no YAML").starts_with("invalid YAML"));
        assert!(DdsTopics::parse(&"[".repeat(100)).expect_err("too deep").contains("nested"));
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[-a:\\[\\]{}&*#!|>'\" \n]{0,60}") {
            let _ = DdsTopics::parse(&text);
        }
    }
}
