//! A testee with selectable faults, for tests of `uavspec test` and `uavspec testee lint`.
//!
//! Without arguments, this program is the reference testee. `--definitions PATH` replaces the definitions of this
//! repository. Other arguments select a fault. `evil.rs` contains faults in single requests, and `rude.rs` contains
//! protocol violations.

#[path = "../../testees/rust/src/codec.rs"]
mod codec;
mod evil;
mod rude;

use std::env;
use std::io::{self, BufReader, Write};
use std::path::Path;
use std::process::ExitCode;

use codec::Codec;
use evil::RequestFault;
use rude::ProtocolFault;
use serde_json::{Value, json};
use uavspec_rules::definitions::Definitions;

fn main() -> io::Result<ExitCode> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let mut evil = RequestFault::read(&arguments);
    let rude = ProtocolFault::read(&arguments);
    evil.at_start();
    let definitions = match arguments.as_slice() {
        [option, path] if option == "--definitions" => {
            Definitions::load(Path::new(path)).map_err(|failure| io::Error::other(failure.to_string()))?
        }
        _ => Definitions::built_in(),
    };
    let types = definitions.types();
    let codec = Codec { schema: &definitions.schema, types, body_schemas: definitions.defined_schemas() };
    let mut input = BufReader::with_capacity(1 << 16, io::stdin().lock());
    let mut output = io::stdout().lock();
    let mut count = 0;
    while let Some(line) = rude.read_line(&mut input)? {
        let Ok(mut question) = serde_json::from_slice::<Value>(&line) else {
            rude.unreadable(&line);
            continue;
        };
        let is_hello = question["op"] == "hello";
        if rude.is_ignored(&question, count) || !is_hello && evil.instead(count, &question, &mut output)? {
            count += 1;
            continue;
        }
        count += 1;
        rude.before(&mut question, &mut output)?;
        let Some(mut reply) = codec.reply(&question) else { continue };
        rude.corrupt(&question, &mut reply);
        if is_hello {
            writeln!(output, "{reply}")?;
        } else {
            evil.corrupt(types, &question, &mut reply);
            evil.write(&reply, &mut output)?;
        }
        output.flush()?;
    }
    if evil.is("late") {
        writeln!(output, "{}", json!({ "id": 0, "ok": null }))?;
    }
    Ok(rude.at_end())
}
