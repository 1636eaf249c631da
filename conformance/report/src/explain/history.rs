//! The history of messages as lines of text, for the language server.

use uavspec_rules::definitions::Library;

use super::catalogue::Catalogue;
use super::{field, presence};

/// The history of messages in all releases.
pub struct History<'l> {
    catalogue: Catalogue<'l>,
}

impl<'l> History<'l> {
    /// The history of the releases in a library.
    pub fn new(library: &'l Library) -> Self {
        Self { catalogue: Catalogue::new(library, None) }
    }

    /// Lines with the releases that contain a message, or one of its fields or constants, and the changes between them.
    /// `message` is the full ROS name, such as `px4_msgs/msg/VehicleStatus`.
    pub fn lines(&self, message: &str, item: Option<&str>) -> Vec<String> {
        let catalogue = &self.catalogue;
        let Some(release) = catalogue.newest(message) else { return Vec::new() };
        let definition = catalogue.read(message, release, None);
        let presence = match item {
            Some(item) => field::presence_of(catalogue, &definition, item),
            None => {
                presence::of_definition(catalogue, catalogue.family(release), &catalogue.history(&definition))
            }
        };
        let is_in_history = |release: &String| presence.history.iter().any(|entry| entry.release == *release);
        let since = presence.since.as_ref().filter(|release| !is_in_history(release));
        let since = since.map(|release| format!("since {release}"));
        let changes = presence.history.into_iter().flat_map(|entry| {
            entry.changes.into_iter().map(move |change| format!("{}: {change}", entry.release))
        });
        since.into_iter().chain(changes).collect()
    }
}
