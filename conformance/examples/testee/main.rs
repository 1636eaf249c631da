//! A testee with selectable faults, for tests of `uavspec test` and `uavspec testee lint`.
//!
//! Without arguments, this program is the reference testee. `--definitions PATH` replaces the definitions of this
//! repository. The arguments after that select a fault. `evil.rs` contains faults in single requests, and `rude.rs`
//! contains protocol violations.

#[path = "../../testees/rust/src/codec.rs"]
mod codec;
mod evil;
mod rude;

use std::env;
use std::io::{self, BufReader, Write};
use std::process::ExitCode;

use codec::Codec;
use evil::RequestFault;
use rude::ProtocolFault;
use serde_json::{Value, json};
use uavspec_codegen::load::read_definitions;
use uavspec_dynamic::Types;
use uavspec_flockwave::body_schema::DefinedSchemas;
use uavspec_rules::definitions::Definitions;

fn main() -> io::Result<ExitCode> {
    let mut arguments: Vec<String> = env::args().skip(1).collect();
    let schema = if arguments.first().is_some_and(|first| first == "--definitions") {
        let path: Vec<String> = arguments.drain(..2).collect();
        read_definitions(&path[1]).map_err(|failure| io::Error::other(failure.to_string()))?.1
    } else {
        Definitions::built_in().schema
    };
    let mut evil = RequestFault::read(&arguments);
    let rude = ProtocolFault::read(&arguments);
    evil.at_start();
    let (types, body_schemas) = (Types::new(&schema), DefinedSchemas::new(&schema));
    let codec =
        Codec { schema: &schema, types: &types, body_schemas: &body_schemas, events: codec::events(&schema) };
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
            evil.corrupt(&types, &question, &mut reply);
            evil.write(&reply, &mut output)?;
        }
        output.flush()?;
    }
    if evil.is("late") {
        writeln!(output, "{}", json!({ "id": 0, "ok": null }))?;
    }
    Ok(rude.at_end())
}
