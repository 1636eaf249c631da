//! What all adapters of Rust share: they read the jobs, and write a line of JSON for each schema and each case.
//! `xtask/interop/README.md` describes both.

use std::collections::BTreeMap;
use std::error::Error;
use std::fs;
use std::io::{self, BufRead as _, BufReader, Write as _};

use serde::Deserialize;
use serde_json::{Value, json};

/// Whatever went wrong, to be shown.
pub type Failure = Box<dyn Error>;

/// The documents by their address.
pub type Documents = BTreeMap<String, Value>;

/// A line of what is to be done.
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

/// Runs all jobs of the file that the command line names. `prepare` takes all documents and gives what compiles the
/// schema of an address, which in turn gives the function that judges an instance: what is wrong with it, if anything.
pub fn serve<Compile, Judge>(
    version: &str,
    prepare: impl FnOnce(Documents) -> Result<Compile, Failure>,
) -> Result<(), Failure>
where
    Compile: FnMut(&str) -> Result<Judge, Failure>,
    Judge: Fn(&str) -> Result<(), String>,
{
    let path = std::env::args().nth(1).ok_or("name the file with the jobs")?;
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
        let judge = match compile(&schema) {
            Ok(judge) => judge,
            Err(error) => {
                write(&json!({ "job": job, "error": error.to_string() }))?;
                continue;
            }
        };
        write(&json!({ "job": job }))?;
        for (case, text) in cases.iter().enumerate() {
            let verdict = judge(text);
            let message = verdict.as_ref().err().map(|message| message.chars().take(300).collect::<String>());
            write(&json!({ "job": job, "case": case, "valid": verdict.is_ok(), "message": message }))?;
        }
    }
    Ok(())
}

/// Standard output ends each line at once, so that what was judged before a crash is known.
fn write(line: &Value) -> io::Result<()> {
    writeln!(io::stdout(), "{line}")
}

/// The version of a dependency by the lock file beside this crate.
pub fn version(name: &str) -> String {
    let lock = include_str!("../../Cargo.lock");
    let entry = lock.split("[[package]]").find(|entry| entry.contains(&format!("\nname = \"{name}\"\n")));
    let line = entry.and_then(|entry| entry.lines().find_map(|line| line.strip_prefix("version = ")));
    line.map_or_else(|| "unknown".to_owned(), |version| version.trim_matches('"').to_owned())
}
