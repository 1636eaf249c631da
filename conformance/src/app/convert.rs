//! `uavspec convert`.

use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::Args;
use uavspec_capture::input::Input;
use uavspec_capture::rosbag::metadata::folder_of;
use uavspec_check::convert::{
    Action, ConversionReport, Error, Format, Output, Plan, Settings, convert, convert_folder, file_names,
};
use uavspec_check::{open_folder, open_path};
use uavspec_rules::definitions::Definitions;
use uavspec_schema::Failure;
use uavspec_schema::stage::{write_at, write_file, write_folder};

use super::outputs::{self, Inputs, Output as NamedOutput};
use super::progress::Progress;
use super::report::print_result;
use super::{Exit, Format as ReportFormat, Status, library, uninterruptible, unreadable};

const EXAMPLES: &str = "Examples, with the files of `uavspec sample`:
  uavspec convert flight.ulg --to px4@1.16 -o converted.ulg
  uavspec convert flight.mcap --to px4@1.17 -o converted.mcap
  uavspec convert flight.ulg -o bag.mcap
  uavspec convert flight.mcap -o log.ulg
  uavspec convert flight.mcap -o bag.db3

With your own files:
  uavspec convert old.mcap --from px4@1.13 --to px4@1.16 -o new.mcap
  uavspec convert old_bag --to src/my_msgs --hints hints.toml -o new_bag
  uavspec convert messages.jsonl --to px4@1.16 -o out.jsonl";

const DETAILS: &str = "\
The output contains the types, the type hashes and the topic versions of the target. Topics of packages that the \
target doesn't define are copied unchanged. uavspec reads the old definitions from the schemas in a bag. For PX4 \
messages, it uses the definitions of the release that they agree with.

If the name of OUT ends with .mcap, .db3 or .ulg, the output has this format: a log becomes a bag, a bag becomes a log, \
or the storage of a bag changes. In a bag, topics of a log have the names that PX4 uses in ROS 2, such as \
/fmu/out/battery_status1_v1. Texts and events are on /rosout, and parameters on /parameter_events. Times are in UTC if \
the log contains the time of a satellite navigation receiver.

The folder of a bag becomes a new folder, or one file. ROS 2 Foxy and later read the new folder. Its messages and \
files are uncompressed. SQLite files can't contain attachments, metadata records, private records, publish times, \
sequence numbers, and most metadata of channels.

In MCAP files, each chunk keeps its compression. Attachments, metadata records and private records are copied \
unchanged. A truncated attachment is left out. CDR and JSON messages are converted; a JSON message with an unknown or a \
missing field is unreadable. A file that is compressed as a whole becomes an uncompressed file.

The output of a log contains the formats of the target. Parameters, information and logged text stay the \
same. Data that was appended after a crash directly follows the other data.

JSON messages must specify their type or their topic, as for `uavspec check`. Their other members stay the same, and \
so do values that aren't messages. A value that spans several lines is written on one line.

If a part of the input can't be read, the output contains all readable messages, and the exit status is 6. The same \
applies if the input grows or changes during the conversion. After any other error and after Ctrl-C, there is no \
output, and an existing file stays unchanged.

Limits: a converted message may take up to 256 MiB in memory. The schemas and channels of a bag may take up to 64 MiB, \
including the names of attachments and metadata records. The names of schemas and topics in a bag may have up to 256 \
bytes. A JSON value may have up to 16 MiB. A log, or a file with JSON messages, may have up to 10,000 topics and \
types. A SQLite file may have up to 10,000 topics, and a message in it up to 64 MiB. The information of a log may have up to 4 MiB. A temporary file stores an attachment of more than 16 MiB until \
it is complete. It also stores more than 4 MiB of messages of a log until a time in UTC is known, and of a bag that \
becomes a log, and a compressed SQLite file of up to 16 GiB. The index of an MCAP file is in memory until the end: about 0.6 MiB for each GiB of a bag with 235 topics.

Exit status:
  0  success
  2  invalid usage, invalid or unknown definitions, or a mistake in the hints
  3  the input can't be opened or has an unsupported format, the output can't be
     written, or the run was interrupted
  5  no topic was converted; the output contains the copied topics
  6  incomplete: some data can't be read";

/// The exit status after a second Ctrl-C: 128 plus the number of SIGINT.
const INTERRUPTED: i32 = 130;

/// Arguments of `convert`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{DETAILS}"))]
pub(super) struct ConvertArgs {
    /// File or folder to convert: a PX4 log, an MCAP file, a bag of rosbag2 (a .db3 file or a folder), or JSON messages (JSON
    /// Lines, an array, or rosbridge). A file may be compressed with gzip or zstd.
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Definitions of the output: a release, such as px4@1.16 or ros2@humble, or a path. Required unless OUT has
    /// another format than IN [default: the messages keep their types].
    #[arg(long, value_name = "DEFINITIONS")]
    to: Option<PathBuf>,
    /// File or folder to write. A file replaces an existing file, but never the input. A folder must be new.
    ///
    /// If its name ends with .mcap, .db3 or .ulg, the output is a file with this format. Otherwise, it has the form of the
    /// input.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Definitions of the input: a release or a path [default: the schemas in the input, and the release that matches
    /// best].
    #[arg(long, value_name = "DEFINITIONS")]
    from: Option<PathBuf>,
    /// File with hints for differences that the definitions don't resolve.
    ///
    /// They take precedence over uavspec's built-in hints for PX4.
    #[arg(long, value_name = "FILE")]
    hints: Option<PathBuf>,
    /// Copy messages that can't be converted [default: leave them out].
    ///
    /// Such a message doesn't exist in the target release, or a part of its conversion is undecided. The copy
    /// keeps the type of the input.
    #[arg(long)]
    keep_unconverted: bool,
    /// Output format of the report: text or json.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: ReportFormat,
}

/// Runs `uavspec convert`.
pub(super) fn run(args: &ConvertArgs) -> Exit {
    let inputs = Inputs {
        files: std::iter::once(&*args.input).chain(args.hints.as_deref()).collect(),
        definitions: args.from.iter().chain(&args.to).map(PathBuf::as_path).collect(),
        ..Inputs::default()
    };
    outputs::check(&inputs, &[NamedOutput::new("--output", &args.output)])?;
    let source = library(args.from.as_deref(), None, &[])?;
    let target = args.to.as_deref().map(|path| library(Some(path), None, &[])).transpose()?;
    let interrupted = interruption()?;
    let progress = Progress::bytes(Input::Path(args.input.clone()).size().unwrap_or_default());
    let reading = |input| {
        let input = Interruptible { input, interrupted: Arc::clone(&interrupted) };
        progress.reading(input)
    };
    let settings = Settings { format: format_of(&args.output), keeps_unconverted: args.keep_unconverted };
    let plan = |definitions: &Arc<Definitions>| {
        let plan = Plan::new(Arc::clone(definitions), &source, target.as_ref(), args.hints.as_deref());
        plan.map_err(|failure: Failure| Status::Usage.failed(&failure))
    };
    let report = if let Some(folder) = folder_of(&args.input) {
        let opened = open_folder(folder, &source).map_err(|error| unreadable(&args.input, error))?;
        let opened = opened.map_err(|reason| unreadable(&args.input, reason))?;
        if target.is_none() && settings.format.is_none() {
            return Err(without_target("folders", "out.mcap"));
        }
        let plan = plan(&opened.definitions)?;
        let name = file_names(&args.output);
        write(args, settings.format, &interrupted, |output| {
            convert_folder((folder, &opened), &plan, settings, &reading, (&name, output))
        })?
    } else {
        let opened = open_path(&args.input, &source, &reading);
        let opened = opened.map_err(|error| unreadable(&args.input, error))?;
        let opened = opened.map_err(|reason| unreadable(&args.input, reason))?;
        let format = Format::of(&opened).map_err(|error| failed(args, error))?;
        if target.is_none() && settings.format.is_none_or(|wanted| wanted == format) {
            let other = if format == Format::Mcap { "out.db3" } else { "out.mcap" };
            return Err(without_target(&format!("{} files", format.name()), other));
        }
        let plan = plan(&opened.definitions)?;
        write(args, Some(settings.format.unwrap_or(format)), &interrupted, |output| {
            convert((&args.input, opened), &plan, settings, output)
        })?
    };
    drop(progress);
    let text = match args.format {
        ReportFormat::Text => report.to_text(),
        ReportFormat::Json => report.to_json(),
    };
    print_result(&text)?;
    Ok(status(&report))
}

/// Prints the error for a conversion that would change nothing.
fn without_target(both: &str, other: &str) -> Status {
    let help =
        format!("add definitions, such as `--to px4@1.16`, or choose another format, such as `-o {other}`");
    Status::Usage.with_help(format!("--to is required, because IN and OUT are both {both}"), &help)
}

/// The format that the name of a file indicates.
fn format_of(path: &Path) -> Option<Format> {
    let extension = path.extension()?;
    [("mcap", Format::Mcap), ("db3", Format::Sqlite), ("ulg", Format::Log)]
        .into_iter()
        .find_map(|(known, format)| extension.eq_ignore_ascii_case(known).then_some(format))
}

/// Writes the output with `convert`: a file of this format, or a folder. If this fails, prints errors and removes the output.
fn write(
    args: &ConvertArgs,
    format: Option<Format>,
    interrupted: &AtomicBool,
    convert: impl FnOnce(Output<'_>) -> Result<ConversionReport, Error>,
) -> Result<ConversionReport, Status> {
    let convert = |output: Output<'_>| {
        let report = convert(output)?;
        if interrupted.load(Ordering::Relaxed) {
            return Err(Error::Write(io::Error::other("interrupted")));
        }
        Ok(report)
    };
    let result = match format {
        None => write_folder(&args.output, |folder| convert(Output::Folder(folder))),
        Some(Format::Sqlite) => write_at(&args.output, |file| convert(Output::Sqlite(file))),
        Some(_) => write_file(&args.output, |file| convert(Output::Stream(file))),
    };
    if result.is_err() && interrupted.load(Ordering::Relaxed) {
        return Err(Status::Unreadable.because("interrupted: no output was written"));
    }
    result.map_err(|error| failed(args, error))
}

/// Prints an error.
fn failed(args: &ConvertArgs, error: Error) -> Status {
    match error {
        Error::Input(problem) => unreadable(&args.input, problem),
        Error::Hints(failure) => Status::Usage.failed(&failure),
        Error::Write(error) => unreadable(&args.output, error),
    }
}

/// The exit status of a finished conversion.
fn status(report: &ConversionReport) -> Status {
    if !report.is_complete() {
        let help = "the output contains the readable messages";
        return Status::Incomplete.with_help("incomplete: some data of the input can't be read", help);
    }
    let copied = if report.to.is_some() { 0 } else { report.count(Action::Copied) };
    if report.count(Action::Converted) + copied == 0 {
        let help = if report.count(Action::LeftOut) > 0 {
            "the report contains the reason for each topic"
        } else if report.from.is_empty() {
            "set the release of the input, such as --from px4@1.17"
        } else {
            "`uavspec check` lists the topics and their releases"
        };
        return Status::Nothing.with_help("no topic was converted", help);
    }
    Status::Conforms
}

/// Returns a flag that is set when the user presses Ctrl-C. Prints errors.
fn interruption() -> Result<Arc<AtomicBool>, Status> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    let interrupt = move || {
        // A pipe that sends nothing would delay the end after the first signal.
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED);
        }
    };
    ctrlc::set_handler(interrupt).map_err(uninterruptible)?;
    Ok(interrupted)
}

/// An input whose reads fail after Ctrl-C.
struct Interruptible {
    input: Box<dyn Read + Send>,
    interrupted: Arc<AtomicBool>,
}

impl Read for Interruptible {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.interrupted.load(Ordering::Relaxed) {
            return Err(io::Error::other("interrupted"));
        }
        self.input.read(out)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use uavspec_check::Opened;
    use uavspec_check::convert::convert as convert_capture;
    use uavspec_rules::definitions::Library;

    use super::*;

    /// Presses Ctrl-C at its place in an input.
    struct CtrlC(Arc<AtomicBool>);

    impl Read for CtrlC {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            self.0.store(true, Ordering::Relaxed);
            Ok(0)
        }
    }

    #[test]
    fn an_interrupted_conversion_leaves_no_output() {
        let folder = tempfile::tempdir().expect("a folder");
        let output = folder.path().join("out.jsonl");
        let [source, target] =
            ["px4@1.16", "px4@1.17"].map(|release| Library::release(release).expect("a release"));
        let definitions = source.base();
        let plan = Plan::new(Arc::clone(definitions), &source, Some(&target), None).expect("a plan");
        let convert = |rest: fn(Arc<AtomicBool>) -> Box<dyn Read + Send>| {
            let interrupted = Arc::new(AtomicBool::new(false));
            let line = br#"{"type": "px4/ArmingCheckRequest", "message": {"timestamp": 9, "request_id": 6}}"#;
            let input = Box::new(line.chain(rest(Arc::clone(&interrupted))));
            let bytes = Box::new(Interruptible { input, interrupted: Arc::clone(&interrupted) });
            let opened = Opened {
                kind: "JSON",
                definitions: Arc::clone(definitions),
                bytes,
                database: None,
                state: None,
            };
            let args = ConvertArgs {
                input: "in.jsonl".into(),
                to: Some("px4@1.17".into()),
                output: output.clone(),
                from: None,
                hints: None,
                keep_unconverted: false,
                format: ReportFormat::Text,
            };
            let settings = Settings::default();
            write(&args, Some(Format::Json), &interrupted, |output| {
                convert_capture((&args.input, opened), &plan, settings, output)
            })
            .err()
        };
        for before in [None, Some("old")] {
            if let Some(text) = before {
                fs::write(&output, text).expect("a file");
            }
            // An input without an end, and an interruption after the last read.
            let endless = convert(|flag| Box::new(CtrlC(flag).chain(io::repeat(b'\n'))));
            let ended = convert(|flag| Box::new(CtrlC(flag)));
            assert_eq!((endless, ended), (Some(Status::Unreadable), Some(Status::Unreadable)));
            assert_eq!(fs::read_to_string(&output).ok().as_deref(), before);
            assert_eq!(fs::read_dir(&folder).expect("a folder").count(), usize::from(before.is_some()));
        }
        assert_eq!(convert(|_| Box::new(io::empty())), None);
        assert!(fs::read_to_string(&output).expect("a file").contains("valid_registrations_mask"));
    }
}
