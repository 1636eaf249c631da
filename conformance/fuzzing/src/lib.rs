//! The fuzz targets of this crate: one function for each kind of input. A function reads arbitrary bytes, and panics if
//! a property doesn't hold. `cargo xtask fuzz` runs the functions.

mod applications;
mod bag_metadata;
#[cfg(feature = "schemas")]
mod body_schema_grammar;
mod captures;
mod conversions;
mod definitions;
mod events;
mod lists;
#[cfg(feature = "schemas")]
mod schemas;
mod server;
mod testees;
mod transports;
mod watching;

use std::io::{self, Cursor, Read};
use std::sync::LazyLock;

use uavspec_capture::rosbag::SQLITE_MAGIC;
use uavspec_capture::{MCAP_MAGIC, ULOG_MAGIC};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::Encoding;

/// A kind of input.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The name of the target.
    pub name: &'static str,
    /// Checks an input.
    pub check: fn(&[u8]),
    /// Creates the inputs with which a first run starts.
    pub seeds: fn() -> Vec<Vec<u8>>,
}

/// All targets.
pub const TARGETS: &[Target] = &[
    Target {
        name: "ulog",
        check: |data| captures::starting_with(&ULOG_MAGIC, data),
        seeds: || [events::logs(), captures::flights(Encoding::Ulog)].concat(),
    },
    Target {
        name: "mcap",
        check: |data| captures::starting_with(&MCAP_MAGIC, data),
        seeds: || captures::flights(Encoding::Mcap),
    },
    Target {
        name: "sqlite-bag",
        check: |data| captures::starting_with(&SQLITE_MAGIC, data),
        seeds: captures::sqlite_bag_seeds,
    },
    Target { name: "bag-metadata", check: captures::bag_metadata, seeds: captures::bag_metadata_seeds },
    Target { name: "bag-metadata-grammar", check: bag_metadata::grammar, seeds: choices },
    Target { name: "application", check: applications::sources, seeds: applications::seeds },
    Target { name: "json-capture", check: captures::json, seeds: captures::json_seeds },
    Target { name: "convert", check: conversions::mcap, seeds: conversions::mcap_seeds },
    Target { name: "convert-format", check: conversions::log, seeds: || captures::flights(Encoding::Ulog) },
    Target {
        name: "session",
        check: |data| captures::starting_with(b"{", data),
        seeds: captures::session_seeds,
    },
    Target { name: "compressed", check: captures::compressed, seeds: captures::compressed_seeds },
    Target { name: "baseline", check: lists::baseline, seeds: lists::seeds },
    Target { name: "baseline-grammar", check: lists::grammar, seeds: choices },
    #[cfg(feature = "schemas")]
    Target { name: "body-schema", check: schemas::body_schema, seeds: schemas::body_schema_seeds },
    #[cfg(feature = "schemas")]
    Target { name: "body-schema-grammar", check: body_schema_grammar::grammar, seeds: choices },
    Target { name: "http", check: transports::http, seeds: transports::http_seeds },
    Target { name: "web-socket", check: transports::web_socket, seeds: transports::web_socket_seeds },
    Target { name: "socket-io", check: transports::socket_io, seeds: transports::socket_io_seeds },
    Target { name: "endpoint", check: transports::endpoint, seeds: transports::endpoint_seeds },
    Target { name: "tcp-server", check: server::tcp, seeds: server::seeds },
    Target { name: "udp-server", check: server::udp, seeds: server::seeds },
    Target { name: "udp-client", check: watching::datagrams, seeds: watching::seeds },
    Target { name: "testee", check: testees::answers, seeds: testees::seeds },
    Target { name: "edits", check: definitions::edits, seeds: definitions::edit_seeds },
    Target {
        name: "configuration",
        check: definitions::configuration,
        seeds: definitions::configuration_seeds,
    },
    Target { name: "configuration-grammar", check: definitions::configuration_grammar, seeds: choices },
    Target { name: "hints", check: definitions::hints, seeds: definitions::hint_seeds },
    Target { name: "hints-grammar", check: definitions::hints_grammar, seeds: choices },
    Target { name: "translations", check: definitions::translations, seeds: definitions::translation_seeds },
    Target { name: "event-metadata", check: events::metadata, seeds: events::seeds },
];

/// The built-in definitions.
static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);

/// The definitions of all releases.
static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

/// Makes choices that depend on bytes. When no bytes are left, it chooses the first option.
struct Choices<'b>(std::slice::Iter<'b, u8>);

impl<'b> Choices<'b> {
    fn new(bytes: &'b [u8]) -> Self {
        Self(bytes.iter())
    }

    /// A number below a limit.
    fn below(&mut self, limit: usize) -> usize {
        self.0.next().map_or(0, |byte| usize::from(*byte) % limit)
    }

    fn of<T: Copy>(&mut self, options: &[T]) -> T {
        options[self.below(options.len())]
    }
}

/// Inputs for grammars: constant, ascending and descending bytes.
fn choices() -> Vec<Vec<u8>> {
    vec![vec![1; 60], (0..=255).collect(), (0..=120).rev().collect()]
}

/// A reader that returns a few bytes at a time, in varying numbers.
struct Pieces {
    bytes: Cursor<Vec<u8>>,
    length: usize,
}

impl Pieces {
    fn new(bytes: &[u8]) -> Self {
        Self { bytes: Cursor::new(bytes.to_vec()), length: 0 }
    }
}

impl Read for Pieces {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.length = self.length % 7 + 1;
        let length = self.length.min(out.len());
        self.bytes.read(&mut out[..length])
    }
}

#[cfg(test)]
mod tests {
    use uavspec_test_support::{Random, extent};

    use super::TARGETS;

    /// Each target accepts its seeds, and mutated seeds.
    #[test]
    fn the_properties_of_each_input_hold_for_seeds_and_mutants() {
        // In quick mode, the step skips the conversion, which takes long to prepare.
        for target in TARGETS.iter().skip(extent(0, 1)).step_by(extent(1, 3)) {
            let seeds = (target.seeds)();
            assert!(!seeds.is_empty(), "{} has no seeds", target.name);
            let mut random = Random(7);
            let step = seeds.len().div_ceil(extent(8, 2));
            for seed in seeds.into_iter().step_by(step) {
                (target.check)(&seed);
                for _ in 0..extent(3, 1) {
                    let mut changed = seed.clone();
                    changed[random.index(seed.len())] ^= 1 << random.below(8);
                    (target.check)(&changed);
                    changed.truncate(random.index(seed.len()));
                    (target.check)(&changed);
                }
            }
        }
    }

    /// Random bytes select texts of each grammar, and edits of documents.
    #[test]
    fn the_properties_hold_for_random_texts_of_each_grammar() {
        let mut random = Random(7);
        for target in TARGETS {
            let cases = match target.name {
                // Each edit is followed by all requests.
                "edits" => extent(24, 12),
                name if name.ends_with("-grammar") => extent(256, 42),
                _ => 0,
            };
            for _ in 0..cases {
                let length = random.index(100);
                (target.check)(&random.bytes(length));
            }
        }
    }
}
