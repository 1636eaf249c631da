//! Reads drone interface specifications as their authors write them, and generates code and documentation from them.
//!
//! ```text
//!  text ──msg, table──▶ syntax tree ──resolve──────────▶ Schema ──▶ emit (rust, json_schema, docs, vectors, typescript, python)
//!                            │                                ├──▶ dynamic (codecs and checks at run time)
//!                            └──▶ format                      ├──▶ lint ──────┐
//!                                                             ├──▶ breaking ──┴──▶ report
//!                                                             └──▶ conversion (between packages) ──▶ emit rust
//! ```
//!
//! A stage uses only the types of the stage directly before it. Reading doesn't stop at the first error: each stage
//! returns everything it could read, and a list of [`Diagnostic`]s. After `resolve`, no stage looks up names or parses
//! text. Only `load`, `generate` and `cli` access files.
//!
//! # Design decisions
//!
//! - Spans count bytes across all sources of a run. A span therefore takes only eight bytes, yet identifies its file.
//! - Annotations and literals are read by the parser, not by `resolve`. Values in the syntax tree are typed and in
//!   range, and each error is reported on its line.
//! - One sorted list contains the messages of all packages; a [`schema::MessageId`] is an index into it. Unselected
//!   messages stay in this list, but are not in the lists of the packages.
//! - `[@enum Message.PREFIX]` refers to constants of another message. For example, `battery_warning` of `FailsafeFlags`
//!   uses the constants of `BatteryStatus`, so its enum type belongs to `BatteryStatus`.
//! - If all constants of a flags field are powers of two, the constants are masks; otherwise, they are bit numbers. The
//!   model stores masks in both cases.
//! - ROS 2 rejects names that violate its naming style, so such a name is an error in a ROS 2 definition. PX4 accepts
//!   these names, so they only cause warnings in PX4 definitions. A literal that is valid only in PX4 or only in ROS 2
//!   also causes a warning.
//! - Types and messages on pages describe JSON only. The model of `.msg` files describes memory layout and CDR, so page
//!   types have a separate model ([`schema::json_type`]), separate emitters and a separate Rust module.
//! - Generated JSON types accept any value with the right structure, and don't check ranges, lengths or patterns. A
//!   program can therefore receive an out-of-range value and report it.
//! - Generated types describe themselves to the runtime (`record!`), and all codecs, checks and strategies use this
//!   description. Derives would require more code to generate, read and compile.
//! - `tests/edge.rs` lists where uavspec deliberately deviates from incorrect behaviour of the reference tools, each
//!   with a reason. The test fails if one of these deviations disappears.
//! - [`mod@format`] parses its output again. If the output would differ from the original in meaning or layout, the
//!   text is left unchanged. White space within a comment is part of the comment's meaning.
//! - Parser warnings are [`lint`] rules as well, so users can configure the level of each warning. Rules about comments
//!   and white space receive the syntax tree in addition to the model.
//! - Translations ([`translation`]) are separate from the model, with permanent keys. Emitters look up translations by
//!   key, so emitters can detect text that has no translation.
//! - TypeScript and Python output includes the translated labels, so users who generate code from other definitions get
//!   labels too. Each language file contains only the text in that language; missing text falls back to English.
//! - [`conversion`] matches messages like [`breaking`](mod@breaking), but copies a renamed field only if its comment is the
//!   same. A wrong match in a comparison is a misleading finding; in a conversion, it is wrong data.
//! - A comparison of two sets of definitions uses one [`SourceMap`], so a finding can refer to locations in both.
//! - TypeScript and Python are printed from one intermediate form (`emit::binding`), so their names can't differ.
//! - The JSON and the verdict of a test vector come from the model, and the bytes come from [`dynamic`]. The vector's
//!   id describes the case rather than the result, so the id is permanent.
//!
//! # Performance
//!
//! The following times are medians on two cores, for PX4's 261 messages. Reading and resolving takes 6.3 ms. Emitting
//! takes 42 ms for Rust, 5.3 ms for JSON Schemas and 18 ms for documentation. If there is no existing output, the whole
//! command takes 128 ms (80 to 144), mostly to create 1,050 files. If nothing has changed, the command takes 80 ms.
//! With 4 times as many messages, reading takes 4.1 times as long, emitting Rust takes 4.0 times as long, and the whole
//! command takes 3.9 times as long if nothing has changed. With 16 times as many messages, these three factors are 18,
//! 16 and 16. Emitting the test vectors (26 MB) took at least 80 ms (290 ms including writing the files). Two other
//! programs were using the machine during this measurement. `cargo xtask bench codegen` prints these figures.
//!
//! Applying all [`lint`] rules to these messages, and rendering the 2,700 findings as text, takes 27 ms. The `lint`
//! command with the preset `px4` takes 14 to 21 ms. With 4 times as many messages, the command takes 4.9 times as long.
//! With 16 times as many messages, it takes 19 times as long. [`mod@breaking`] takes 22 ms to compare PX4 1.15 with
//! main. Reading both versions takes half of this time. The `breaking` command takes 30 to 40 ms. Two other programs
//! were using the machine during the measurements of `lint` and `breaking`.
//!
//! The following figures compare [`dynamic`] with generated types on the same bytes; the figures in parentheses are for
//! generated types. Each range covers the medians for three messages of 88 to 232 bytes in one run. Reading takes 24 to
//! 26 ns (9 to 17) for uORB, 8 ns (3) for uORB in place, and 28 to 51 ns (8 to 18) for CDR. Allocation accounts for 20
//! ns of each read. Big-endian CDR takes 46 to 132 ns (9 to 111). Converting uORB to CDR takes 48 to 62 ns (33 to 54).
//! Converting it to JSON text takes 1.9 to 2.4 µs (1.0 to 1.6). `cargo bench -p uavspec-codegen --bench dynamic` prints
//! these figures.
//!
//! The documentation of `uavspec-runtime` lists the compile times and the speed of the generated crate.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod cli;
mod generate;
pub mod load;

pub use generate::{Generated, generate};
