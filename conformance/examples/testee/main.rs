//! The reference testee: the codecs and checks of `uavspec-codegen`, behind the protocol of `uavspec test`.
//!
//! ```text
//! cargo build --example testee
//! uavspec test -- target/debug/examples/testee
//! ```
//!
//! `--definitions PATH` makes it know other types than those of this repository. With another argument it misbehaves, for the tests of the runner: see `evil.rs`.

mod codec;
mod evil;

use std::env;
use std::io::{self, BufRead, Write};
use std::path::Path;

use codec::Codec;
use evil::Evil;
use serde_json::{Value, json};
use uavspec_codegen::dynamic::Types;
use uavspec_conformance::definitions::Definitions;

fn main() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let mut evil = Evil::read(&arguments);
    evil.at_start();
    let definitions = match arguments.as_slice() {
        [option, path] if option == "--definitions" => {
            Definitions::load(Path::new(path)).map_err(|failure| io::Error::other(failure.to_string()))?
        }
        _ => Definitions::built_in(),
    };
    let types = Types::new(&definitions.schema);
    let codec = Codec { schema: &definitions.schema, types: &types };
    let mut output = io::stdout().lock();
    for (count, line) in io::stdin().lock().lines().enumerate() {
        // What is no JSON has no id that could be answered.
        let Ok(request) = serde_json::from_str::<Value>(&line?) else { continue };
        if request["op"] == "hello" {
            writeln!(output, "{}", codec.hello())?;
        } else if evil.instead(count, &request, &mut output)? {
            continue;
        } else {
            let mut answer = codec.answer(&request);
            evil.spoil(&types, &request, &mut answer);
            answer["id"] = request["id"].clone();
            evil.write(&answer, &mut output)?;
        }
        output.flush()?;
    }
    if evil.is("late") {
        writeln!(output, "{}", json!({ "id": 0, "ok": null }))?;
    }
    Ok(())
}
