//! The history of messages as lines of text, for the language server.

use uavspec_codegen::lsp;

use super::catalogue::Catalogue;
use super::{field, presence};
use crate::definitions::Library;

/// The history of messages in all releases.
pub(crate) struct History<'l> {
    catalogue: Catalogue<'l>,
}

impl<'l> History<'l> {
    pub(crate) fn new(library: &'l Library) -> Self {
        Self { catalogue: Catalogue::new(library, None) }
    }
}

impl lsp::History for History<'_> {
    fn lines(&self, message: &str, item: Option<&str>) -> Vec<String> {
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
