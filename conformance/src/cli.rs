//! The command line of `uavspec`.
//!
//! Exit status: 0 conforms; 1 doesn't; 2 wrong usage, or definitions that can't be read; 3 a source that can't be
//! read, or a testee that broke; 5 nothing was checked.

mod test;

use std::io::{self, Write as _};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, Subcommand, ValueEnum};
use uavspec_codegen::schema::MessageId;

use crate::definitions::Definitions;
use crate::finding::Verdict;
use crate::input;
use crate::judge;
use crate::parallel;
use crate::report::{Judged, to_json, to_text};
use crate::rule::{RULES, Rule, rule};

/// Judges outputs of drone software by the specification.
#[derive(Debug, Parser)]
#[command(name = "uavspec", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Judge logs and messages that others wrote.
    Check(CheckArgs),
    /// Ask a codec or validator in any language, as a child process.
    Test(test::TestArgs),
    /// List the rules.
    Rules,
}

/// Arguments of `check`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  uavspec check flight.ulg
  uavspec check --definitions ../px4_msgs/msg logs/*.ulg
  uavspec check --format json flight.ulg > report.json
  uavspec check rosbridge.jsonl bag/bag_0.mcap
  zcat flight.ulg.gz | uavspec check - archive/
  uavspec check --type px4/FailsafeFlags flags.jsonl

JSON is an object a line, or an array of objects. Without --type each says what it is:
  {\"type\": \"px4/FailsafeFlags\", \"message\": {…}}
  {\"op\": \"publish\", \"topic\": \"/fmu/out/failsafe_flags\", \"msg\": {…}}   (rosbridge)

Exit status: 0 conforms, 1 does not, 2 wrong usage or definitions, 3 a file can't be read, 5 nothing was checked.")]
struct CheckArgs {
    /// Logs of PX4 in the format `ULog`, MCAP, or messages as JSON or JSON Lines, also packed with gzip or zstd;
    /// which, is seen by the content. Folders are searched; `-` is standard input.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// What to judge by: a uavspec.toml, a folder with one, or a folder of .msg files; those of this program,
    /// where nothing is said.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// The type of all messages as JSON, which then have nothing around them.
    #[arg(long = "type", value_name = "PACKAGE/NAME")]
    of: Option<String>,
    /// Let formats that differ from the definitions count as breaches (PX-FMT-01).
    #[arg(long)]
    strict_formats: bool,
    /// Rules that have to be exercised: that nothing was there to judge is a breach, too.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    require: Vec<String>,
    /// How many files are read at the same time; as many as there are processors, where nothing is said.
    #[arg(long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
    /// How to report.
    #[arg(long, default_value = "text")]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// For people.
    Text,
    /// For programs.
    Json,
}

/// What a run ends with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Status {
    Conforms = 0,
    Breaks = 1,
    Usage = 2,
    Unreadable = 3,
    Nothing = 5,
}

/// The whole program.
pub fn main() -> ExitCode {
    let status = match Cli::parse().command {
        Command::Check(args) => check(&args),
        Command::Test(args) => test::test(&args),
        Command::Rules => {
            rules();
            Status::Conforms
        }
    };
    ExitCode::from(status as u8)
}

fn rules() {
    for rule in RULES {
        anstream::println!("{:<12} {:<7} {}", rule.id, rule.level, rule.statement);
        anstream::println!("                     by {}", rule.source);
    }
}

fn check(args: &CheckArgs) -> Status {
    let definitions = match definitions(args.definitions.as_deref()) {
        Ok(definitions) => definitions,
        Err(status) => return status,
    };
    let mut required = Vec::new();
    for id in &args.require {
        let Some(rule) = rule(id) else {
            anstream::eprintln!("error: --require {id}: no such rule\n  help: `uavspec rules` lists all");
            return Status::Usage;
        };
        required.push(rule);
    }
    let of = args.of.as_deref().map(|name| (name, definitions.message_of_type(name)));
    if let Some((name, None)) = of {
        anstream::eprintln!("error: --type {name}: the definitions have no such message");
        return Status::Usage;
    }
    let of = of.and_then(|(_, id)| id);
    let files = match input::files(&args.files) {
        Ok(files) => files,
        Err((path, error)) => {
            anstream::eprintln!("error: {}: {error}", path.display());
            return Status::Unreadable;
        }
    };
    let mut judged = Vec::new();
    let mut is_unreadable = false;
    parallel::each(
        &files,
        args.jobs,
        |path| judge(path, of, &definitions),
        |path, result| match result {
            Ok(found) => {
                if args.format == Format::Text {
                    // The stream drops the colours where they would not be shown.
                    let _ = write!(anstream::stdout(), "{}", to_text(&found, &definitions));
                }
                judged.push(found);
            }
            Err(error) => {
                anstream::eprintln!("error: {}: {error}", path.display());
                is_unreadable = true;
            }
        },
    );
    if args.format == Format::Json {
        // A reader that has seen enough closes the pipe: that is no failure.
        let _ = io::stdout().write_all(to_json(&judged, &definitions).as_bytes());
    }
    let status = status(&judged, is_unreadable, args.strict_formats);
    let idle = |rule: &&&Rule| judged.iter().all(|judged| judged.judgement.findings.exercised(rule) == 0);
    for rule in required.iter().filter(idle) {
        anstream::eprintln!(
            "error: {} was required, and nothing was there that it could have judged",
            rule.id
        );
    }
    if required.iter().any(|rule| idle(&rule)) { status.max(Status::Breaks) } else { status }
}

/// The definitions at a path, or those of this program; what is wrong with them has been told.
fn definitions(path: Option<&Path>) -> Result<Definitions, Status> {
    path.map_or_else(|| Ok(Definitions::built_in()), Definitions::load).map_err(|failure| {
        anstream::eprintln!("{failure}");
        Status::Usage
    })
}

fn judge(path: &Path, of: Option<MessageId>, definitions: &Definitions) -> io::Result<Judged> {
    let started = Instant::now();
    let judgement = judge::judge(input::open(path)?, of, definitions)?;
    Ok(Judged { path: path.display().to_string(), judgement, elapsed: started.elapsed().as_millis() })
}

fn status(judged: &[Judged], is_unreadable: bool, are_formats_strict: bool) -> Status {
    let fails = |judged: &Judged| {
        RULES.iter().any(|rule| match judged.judgement.findings.verdict(rule) {
            Verdict::Fail => true,
            Verdict::Shown => are_formats_strict && rule.id == "PX-FMT-01",
            Verdict::Pass | Verdict::Warn | Verdict::NotExercised => false,
        })
    };
    if is_unreadable {
        Status::Unreadable
    } else if judged.iter().any(fails) {
        Status::Breaks
    } else if judged.iter().all(|judged| judged.judgement.judged == 0) {
        Status::Nothing
    } else {
        Status::Conforms
    }
}
