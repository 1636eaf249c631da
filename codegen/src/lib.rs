//! Reads drone interface specifications in the form their authors write them, and generates from them.
//!
//! ```text
//!  text ──msg, table──▶ syntax tree ──resolve──────────▶ Schema ──▶ emit (rust, json_schema, docs, vectors, typescript, python)
//!                            │                                ├──▶ dynamic (codecs and checks at run time)
//!                            └──▶ format                      ├──▶ lint ──────┐
//!                                                             └──▶ breaking ──┴──▶ report
//! ```
//!
//! A stage can't see the types of the stage before the last. Reading never stops at the first
//! mistake: every stage returns what it could make out and a list of [`Diagnostic`]s. After
//! `resolve` no name is looked up and no text is parsed. Only `load`, `generate` and `cli` touch files.
//!
//! # Choices
//!
//! - Spans count through all sources of a run, so that one is eight bytes and names its file too.
//! - Annotations and literals are read by the parser, not by `resolve`: a value in the tree is typed and
//!   in range, and a mistake in it is reported with the line that it stands in.
//! - All messages of all packages stand in one list, sorted; a [`schema::MessageId`] is an index into it.
//!   Messages that aren't selected stay in the list, and the packages don't list them.
//! - `[@enum Message.PREFIX]` names the constants of another message: `battery_warning` of
//!   `FailsafeFlags` holds those of `BatteryStatus`, and is of the same type.
//! - The constants of a mask are masks where all are powers of two, else the numbers of bits; the model
//!   holds masks in both cases.
//! - ROS 2 refuses names that break its style, so they are errors there; PX4 takes them, so they are
//!   warnings. Literals that only one of the two worlds reads are warnings too.
//! - Types and messages of pages are JSON and nothing else, so they have a model, emitters and a module of generated
//!   Rust of their own ([`schema::json_type`]), beside that of `.msg` files, which is about memory and CDR.
//! - Generated JSON types read whatever has the right shape, and leave ranges, lengths and patterns to whoever judges:
//!   a program that meets a value out of range can still say so.
//! - Generated types describe themselves to the runtime once (`record!`), and all codecs, checks and
//!   strategies work from that: less to generate, to read and to compile than derives.
//! - Where the reference tools are mistaken, `tests/edge.rs` lists the deviation with its reason, and
//!   fails when one of them is none any more.
//! - The layout of a definition ([`mod@format`]) is read again, and must say the same and be its own layout; else
//!   the text is kept as it was. White space within the text of a comment belongs to what it says.
//! - What the readers warn of are rules of [`lint`] too, so that their level can be chosen; rules that look at
//!   comments and white space get the syntax tree beside the model.
//! - Translations ([`translation`]) stand beside the model, by keys that last: whoever emits pages looks up what to
//!   show, and knows which texts are still in English.
//! - Labels of translated definitions are emitted with TypeScript and Python, not added by who packs these, so that users
//!   of other definitions have them too. A language holds its own texts alone and finds the rest in English.
//! - Two sets of definitions that are compared stand in one [`SourceMap`], so that a finding names places in both.
//! - TypeScript and Python print one lowering of the model (`emit::binding`), so that names can't differ between them.
//! - A vector's JSON and its verdict come from the model, its bytes from [`dynamic`]; ids say what is tried,
//!   not what comes of it, so that they last.
//!
//! # Measured
//!
//! On two cores, with PX4's 261 messages, medians: read and resolved in 6.3 ms; Rust emitted in 42 ms,
//! JSON Schemas in 5.3 ms, documentation in 18 ms; the whole command, files to files, in 128 ms where no
//! output is there yet (80 to 144; much of it goes to creating 1,050 files, which depends on the file
//! system), and in 80 ms where nothing has changed. With 4 and 16 times as many messages, reading takes
//! 4.1 and 18 times as long, emitting Rust 4.0 and 16 times, the whole command on unchanged output 3.9
//! and 16 times. Test vectors, 26 MB of them, took 80 ms at best while two others used the machine, and
//! 290 ms files to files. `cargo xtask bench codegen` prints these figures.
//!
//! All rules of [`lint`] on these messages, with 2,700 findings as text, take 27 ms, the command with the preset `px4`
//! 14 to 21 ms; with 4 and 16 times as many messages 4.9 and 19 times as long. [`mod@breaking`] between PX4 1.15 and
//! main takes 22 ms, half of it to read both, the command 30 to 40 ms. Two other programs used the machine.
//!
//! Handling messages at run time ([`dynamic`]) beside generated types on the same bytes, in one run, medians of
//! three messages of 88 to 232 bytes: reading uORB 24 to 26 ns where generated code takes 9 to 17, looking at it
//! where it is 8 ns (3), reading CDR 28 to 51 ns (8 to 18), from uORB to CDR 48 to 62 ns (33 to 54), from uORB to the
//! text of JSON 1.9 to 2.4 µs (1.0 to 1.6). Of reading, 20 ns go to the allocation. Big-endian CDR takes
//! 46 to 132 ns (9 to 111). `cargo bench -p uavspec-codegen --bench dynamic` prints these figures.
//!
//! What the generated crate takes to compile, and how fast it is, stands in the documentation of
//! `uavspec-runtime`.

pub mod breaking;
mod characters;
#[cfg(feature = "cli")]
pub mod cli;
pub mod diagnostic;
mod directive;
pub mod dynamic;
pub mod emit;
mod example;
#[cfg(feature = "files")]
mod failure;
pub mod finding;
pub mod format;
// Parts of both are for commands alone.
#[cfg(feature = "files")]
#[cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]
mod generate;
pub mod lint;
#[cfg(feature = "files")]
#[cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports))]
pub mod load;
pub mod msg;
#[cfg(feature = "files")]
mod path;
mod pattern;
mod prose;
mod read;
pub mod render;
pub mod report;
mod resolve;
#[cfg(feature = "files")]
pub mod rewrite;
pub mod schema;
pub mod source;
mod span;
mod table;
pub mod translation;
mod unit;
pub mod value;

pub use diagnostic::Diagnostic;
#[cfg(feature = "files")]
pub use failure::Failure;
#[cfg(feature = "files")]
pub use generate::{Generated, generate};
pub use read::{PackageInput, read};
pub use schema::Schema;
pub use source::{SourceId, SourceMap};

/// Parsers and examples, for the tests of this crate alone.
#[doc(hidden)]
pub mod internal {
    pub use crate::example::{Example, catalogues, is_catalogue, packages};
    pub use crate::msg::annotation::Note;
    pub use crate::msg::parse as parse_definition;
    pub use crate::table::parse as parse_page;
}
