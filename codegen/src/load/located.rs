//! Errors in the configuration file.

use uavspec_schema::failure::Failure;
use uavspec_schema::render;
use uavspec_schema::source::SourceMap;

/// A failure caused by an error at a location in the configuration file.
pub(super) fn failure_at(path: &str, text: &str, range: std::ops::Range<usize>, message: &str) -> Failure {
    let mut sources = SourceMap::default();
    match sources.add(path, text.as_bytes().to_vec()) {
        Ok(id) => Failure::new(render::plain(message, sources.span(id).part(range), &sources)),
        Err(_) => Failure::new(format!("{path}: {message}")),
    }
}
