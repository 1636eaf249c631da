//! The command line of `uavspec`.
//!
//! Exit status: 0 conforms; 1 doesn't; 2 wrong usage, or definitions or lists that can't be read; 3 a source that
//! can't be read, or a testee that broke; 4 a list of known failures no longer holds true; 5 nothing was checked.
//! Where several apply, 2 goes before 3, 1, 4 and 5.

mod known;
mod progress;
mod self_test;
mod test;
mod testee;

use std::fs;
use std::io::{self, Write as _};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Args, Parser, Subcommand, ValueEnum};
use uavspec_codegen::schema::MessageId;

use self::progress::Progress;
use crate::definitions::Definitions;
use crate::finding::Verdict;
use crate::input;
use crate::judge;
use crate::known::{Checked, Scope, excuse_findings, of_findings, of_unread};
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
    /// Work on a testee, before it is asked in earnest.
    #[command(subcommand)]
    Testee(testee::TesteeCommand),
    /// List the rules.
    Rules,
    /// Judge recordings that are made of the definitions, and others that break each rule: whether this program
    /// finds what it should, and nothing else.
    SelfTest(self_test::SelfTestArgs),
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
  uavspec check --known known.toml archive/

JSON is an object a line, or an array of objects. Without --type each says what it is:
  {\"type\": \"px4/FailsafeFlags\", \"message\": {…}}
  {\"op\": \"publish\", \"topic\": \"/fmu/out/failsafe_flags\", \"msg\": {…}}   (rosbridge)

A list of known failures is TOML:
  [[known]]                       # or [[flaky]]: it may also pass
  rule = \"PX-RANGE-01\"
  subject = \"battery_status.*\"    # which may be absent, as all but the reason
  file = \"archive/2019-*.ulg\"
  message = \"0 is out of range\"   # how the message begins
  reason = \"firmware 1.11 leaves it 0\"
  link = \"https://example.org/issues/7\"
  expires = 2027-06-30

Exit status: 0 conforms, 1 does not, 2 wrong usage, definitions or list, 3 a file can't be read, 4 a list of known
failures no longer holds true, 5 nothing was checked.")]
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
    #[command(flatten)]
    known: known::KnownArgs,
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

/// What a run ends with, from the best to that which goes before all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Status {
    Conforms,
    Nothing,
    Stale,
    Breaks,
    Unreadable,
    Usage,
}

impl Status {
    fn code(self) -> u8 {
        match self {
            Self::Conforms => 0,
            Self::Breaks => 1,
            Self::Usage => 2,
            Self::Unreadable => 3,
            Self::Stale => 4,
            Self::Nothing => 5,
        }
    }
}

/// The whole program.
pub fn main() -> ExitCode {
    let status = match Cli::parse().command {
        Command::Check(args) => check(&args),
        Command::Test(args) => test::test(&args),
        Command::Testee(command) => testee::testee(&command),
        Command::Rules => {
            rules();
            Status::Conforms
        }
        Command::SelfTest(args) => self_test::self_test(&args),
    };
    ExitCode::from(status.code())
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
    let mut known = match args.known.read() {
        Ok(known) => known,
        Err(status) => return status,
    };
    let show = |judged: &Judged| {
        // The stream drops the colours where they would not be shown.
        let _ = write!(anstream::stdout(), "{}", to_text(judged, &definitions));
    };
    // With lists it takes all files to tell which findings count.
    let is_shown_at_once = args.format == Format::Text && known.lists.is_empty();
    let mut judged = Vec::new();
    let mut unread = Vec::new();
    let sizes = files.iter().filter_map(|path| Some(fs::metadata(path).ok()?.len()));
    let progress = Progress::bytes(sizes.sum());
    parallel::each(
        &files,
        args.jobs,
        |path| judge(path, of, &definitions, &progress),
        |path, result| match result {
            Ok(found) => {
                if is_shown_at_once {
                    progress.pausing(|| show(&found));
                }
                judged.push(found);
            }
            Err(error) => {
                progress.pausing(|| anstream::eprintln!("error: {}: {error}", path.display()));
                unread.push(path.display().to_string());
            }
        },
    );
    drop(progress);
    let settled = settle(&mut known, &mut judged, &unread);
    if args.format == Format::Text && !is_shown_at_once {
        judged.iter().for_each(show);
    }
    if args.format == Format::Json {
        // A reader that has seen enough closes the pipe: that is no failure.
        let _ = io::stdout().write_all(to_json(&judged, &definitions).as_bytes());
    }
    let status = status(&judged, !unread.is_empty(), args.strict_formats).max(settled);
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

fn judge(
    path: &Path,
    of: Option<MessageId>,
    definitions: &Definitions,
    progress: &Progress,
) -> io::Result<Judged> {
    let started = Instant::now();
    let source = input::unpacked(progress.reading(input::open(path)?))?;
    let judgement = judge::judge(source, of, definitions)?;
    Ok(Judged { path: path.display().to_string(), judgement, elapsed: started.elapsed().as_millis() })
}

/// Holds the lists of known failures against what was found, and notes at each finding what excuses it.
fn settle(known: &mut known::Known, judged: &mut [Judged], unread: &[String]) -> Status {
    let mut checked: Vec<Checked<'_>> = unread.iter().flat_map(|path| of_unread(path)).collect();
    for judged in judged.iter() {
        checked.extend(of_findings(&judged.path, &judged.judgement.findings));
    }
    let status = known.settle(Scope::Rules, &checked);
    for judged in judged {
        excuse_findings(&known.lists, &judged.path, &mut judged.judgement.findings);
    }
    status
}

fn status(judged: &[Judged], is_unreadable: bool, are_formats_strict: bool) -> Status {
    let fails = |judged: &Judged| {
        RULES.iter().any(|rule| match judged.judgement.findings.verdict(rule) {
            Verdict::Fail => true,
            Verdict::Shown => are_formats_strict && rule.id == "PX-FMT-01",
            Verdict::Pass | Verdict::Known | Verdict::Warn | Verdict::NotExercised => false,
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
