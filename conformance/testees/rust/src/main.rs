//! The reference testee: the codecs and checks of `uavspec-codegen`, with the protocol of `uavspec test`.
//!
//! ```text
//! cargo build --package uavspec-testee
//! uavspec test -- target/debug/uavspec-testee
//! ```
//!
//! `--definitions PATH` replaces the definitions of this repository.

mod codec;

use std::env;
use std::io::{self, BufRead as _, Write as _};
use std::path::Path;

use codec::Codec;
use uavspec_rules::definitions::Definitions;

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
    let codec = Codec {
        schema: &definitions.schema,
        types,
        body_schemas: definitions.defined_schemas(),
        events: codec::events(&definitions.schema),
    };
    let mut output = io::stdout().lock();
    // Lines are read as bytes, so that invalid UTF-8 doesn't end the program.
    for line in io::stdin().lock().split(b'\n') {
        // A line that isn't JSON has no id that a response could contain.
        let Ok(request) = serde_json::from_slice(&line?) else { continue };
        if let Some(response) = codec.reply(&request) {
            writeln!(output, "{response}")?;
            output.flush()?;
        }
    }
    Ok(())
}
