//! The reference testee: the codecs and checks of `uavspec-codegen`, behind the protocol of `uavspec test`.
//!
//! ```text
//! cargo build --package uavspec-testee
//! uavspec test -- target/debug/uavspec-testee
//! ```
//!
//! `--definitions PATH` makes it know other types than those of this repository.

mod codec;

use std::env;
use std::io::{self, BufRead as _, Write as _};
use std::path::Path;

use codec::Codec;
use uavspec_conformance::definitions::Definitions;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let definitions = match arguments.as_slice() {
        [] => Definitions::built_in(),
        [option, path] if option == "--definitions" => {
            Definitions::load(Path::new(path)).map_err(|failure| io::Error::other(failure.to_string()))?
        }
        _ => return Err(io::Error::other("usage: uavspec-testee [--definitions PATH]")),
    };
    let types = definitions.types();
    let codec = Codec { schema: &definitions.schema, types, body_schemas: definitions.defined_schemas() };
    let mut output = io::stdout().lock();
    // As bytes: a line that is no UTF-8 must not be the end.
    for line in io::stdin().lock().split(b'\n') {
        // What is no JSON has no id that could be answered.
        let Ok(question) = serde_json::from_slice(&line?) else { continue };
        if let Some(reply) = codec.reply(&question) {
            writeln!(output, "{reply}")?;
            output.flush()?;
        }
    }
    Ok(())
}
