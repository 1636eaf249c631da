//! Runs a library that `cargo xtask bench peers` compares with uavspec. Each command reads whole files and prints the
//! number of messages, so the benchmark can check that nothing was skipped.

mod bag;
mod capture;
mod codec;

use std::env;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mcap::io::MessageReader;
use px4_ulog::stream_parser::{Message, SimpleCallbackResult, read_file_with_simple_callback};
use roslibrust_codegen::find_and_generate_ros_messages_without_ros_package_path;
use serde::de::IgnoredAny;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// The number of messages in the JSON Lines.
const LINES: usize = 100_000;

/// The number of UAV states in a capture.
const STATES: usize = 300_000;

/// The sizes of the reports, in UAVs.
const REPORTS: [usize; 2] = [1, 50];

const USAGE: &str =
    "usage: uavspec-peers ulog|mcap|skip|roslibrust|make PATH ..., or cdr|cdr-encoding|uavspec COUNT";

/// The size of a read buffer. The libraries are slower if a file is read into memory as a whole.
const BUFFER: usize = 1 << 16;

fn main() -> ExitCode {
    let mut arguments = env::args().skip(1);
    let command = arguments.next().unwrap_or_default();
    let arguments: Vec<String> = arguments.collect();
    let result = match command.as_str() {
        "ulog" => sum(&arguments, ulog),
        "mcap" => sum(&arguments, mcap),
        "skip" => sum(&arguments, skip),
        "roslibrust" => sum(&arguments, roslibrust),
        "cdr" | "cdr-encoding" | "uavspec" => sum(&arguments, |count| codec::decode(&command, count)),
        "make" => make(&arguments),
        _ => Err(USAGE.into()),
    };
    match result {
        Ok(count) => {
            println!("{count}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn sum(arguments: &[String], run: impl Fn(&str) -> Result<u64>) -> Result<u64> {
    let run = |argument: &String| run(argument).map_err(|error| format!("{argument}: {error}").into());
    arguments.iter().map(run).sum()
}

/// Reads the data messages of a log.
fn ulog(path: &str) -> Result<u64> {
    let mut count = 0;
    read_file_with_simple_callback(path, &mut |message| {
        count += u64::from(matches!(message, Message::Data(_)));
        SimpleCallbackResult::KeepReading
    })?;
    Ok(count)
}

/// Reads the messages of a bag.
fn mcap(path: &str) -> Result<u64> {
    let mut count = 0;
    for message in MessageReader::new(BufReader::with_capacity(BUFFER, File::open(path)?)) {
        message?;
        count += 1;
    }
    Ok(count)
}

/// Parses the JSON value on each line without storing it.
fn skip(path: &str) -> Result<u64> {
    let mut file = BufReader::with_capacity(BUFFER, File::open(path)?);
    let mut line = Vec::new();
    let mut count = 0;
    while file.read_until(b'\n', &mut line)? > 0 {
        serde_json::from_slice::<IgnoredAny>(&line)?;
        line.clear();
        count += 1;
    }
    Ok(count)
}

/// Generates a Rust file next to a folder of packages. Returns the number of definitions.
fn roslibrust(path: &str) -> Result<u64> {
    let packages = vec![PathBuf::from(path)];
    let (tokens, paths) = find_and_generate_ros_messages_without_ros_package_path(packages)?;
    fs::write(Path::new(path).with_extension("rs"), tokens.to_string())?;
    Ok(paths.len() as u64)
}

/// Makes bags and captures in a folder, from a log and the folder of its definitions.
fn make(arguments: &[String]) -> Result<u64> {
    let [folder, log, definitions] = arguments else { return Err(USAGE.into()) };
    let folder = Path::new(folder);
    let file = |name: &str| File::create(folder.join(name)).map(BufWriter::new);
    capture::write_lines(LINES, &mut file("FailsafeFlags.jsonl")?)?;
    for each in REPORTS {
        capture::write_reports(STATES, each, &mut file(&format!("reports-{each}.jsonl"))?)?;
    }
    bag::make(folder, Path::new(log), Path::new(definitions))
}
