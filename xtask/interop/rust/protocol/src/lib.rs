//! Shared code of the Rust adapters. They read jobs, and write one JSON line for each schema and case; see
//! `xtask/interop/README.md`.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{self, BufRead as _, BufReader, Write as _};

use serde::Deserialize;
use serde_json::{Value, json};

/// Any error.
pub type Failure = Box<dyn Error>;

/// The documents by URL.
pub type Documents = BTreeMap<String, Value>;

/// A line of the input file.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Document { document: String, path: String },
    Job(Job),
}

#[derive(Deserialize)]
struct Job {
    job: usize,
    schema: String,
    cases: Vec<String>,
}

/// Runs all jobs in the file given on the command line. `prepare` receives all documents and returns a compile
/// function. The compile function takes a schema's URL and returns a check function. The check function takes an
/// instance and returns the error, if any.
pub fn serve<Compile, Check>(
    version: &str,
    prepare: impl FnOnce(Documents) -> Result<Compile, Failure>,
) -> Result<(), Failure>
where
    Compile: FnMut(&str) -> Result<Check, Failure>,
    Check: Fn(&str) -> Result<(), String>,
{
    let path = std::env::args().nth(1).ok_or("expected the path of the jobs file")?;
    let mut documents = Documents::new();
    let mut jobs = Vec::new();
    for line in BufReader::new(fs::File::open(path)?).lines() {
        match serde_json::from_str(&line?)? {
            Line::Document { document, path } => {
                documents.insert(document, serde_json::from_str(&fs::read_to_string(path)?)?);
            }
            Line::Job(job) => jobs.push(job),
        }
    }
    write(&json!({ "version": version }))?;
    let mut compile = prepare(documents)?;
    for Job { job, schema, cases } in jobs {
        let check = match compile(&schema) {
            Ok(check) => check,
            Err(error) => {
                write(&json!({ "job": job, "error": error.to_string() }))?;
                continue;
            }
        };
        write(&json!({ "job": job }))?;
        for (case, text) in cases.iter().enumerate() {
            let verdict = check(text);
            let message = verdict.as_ref().err().map(|message| message.chars().take(300).collect::<String>());
            write(&json!({ "job": job, "case": case, "valid": verdict.is_ok(), "message": message }))?;
        }
    }
    Ok(())
}

/// Writes a line. Standard output is flushed after each line, so that verdicts before a crash are preserved.
fn write(line: &Value) -> io::Result<()> {
    writeln!(io::stdout(), "{line}")
}

/// The version of a dependency in the lock file of this workspace.
pub fn version(name: &str) -> String {
    let lock = include_str!("../../Cargo.lock");
    let entry = lock.split("[[package]]").find(|entry| entry.contains(&format!("\nname = \"{name}\"\n")));
    let line = entry.and_then(|entry| entry.lines().find_map(|line| line.strip_prefix("version = ")));
    line.map_or_else(|| "unknown".to_owned(), |version| version.trim_matches('"').to_owned())
}
