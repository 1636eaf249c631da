//! The command line of `uavspec`.
//!
//! | Exit status | Meaning |
//! |---:|---|
//! | 0 | success: no MUST rule is violated; coverage may be partial |
//! | 1 | does not conform, or another check failed |
//! | 2 | invalid usage, unreadable definitions, or an unreadable baseline |
//! | 3 | an input can't be opened, a report can't be written, or a testee or server failed |
//! | 4 | an entry of a baseline no longer applies |
//! | 5 | nothing was checked |
//! | 6 | incomplete: some data can't be read, or too little was checked |
//!
//! If several statuses apply, the exit status is the first that applies in the order 2, 3, 1, 6, 4, 5.
//!
//! ```no_run
//! let status: std::process::ExitCode = uavspec::app::main();
//! ```

mod access;
mod baseline;
mod check;
mod compat;
mod completions;
mod convert;
mod events;
mod explain;
mod init;
mod inputs;
mod interrupt;
mod lsp;
mod man;
mod new_files;
mod outcome;
mod outputs;
mod probe;
mod progress;
mod report;
mod required;
mod rules;
mod sample;
mod self_test;
mod serve;
#[cfg(not(feature = "stores"))]
mod stores;
#[cfg(not(feature = "tables"))]
mod tables;
mod target;
mod test;
mod testee;
mod watch;

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory as _, Parser, Subcommand, ValueEnum};
use uavspec_codegen::cli;
use uavspec_model::text::{command_line, shown_value, shown_words, similar, terminal};
use uavspec_report::{Outcome, OutcomeKind};
use uavspec_rules::RULES;
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_schema::Failure;
use uavspec_schema::msg::Dialect;
#[cfg(feature = "stores")]
use uavspec_stores as stores;
#[cfg(feature = "tables")]
use uavspec_tables as tables;

const PROGRAM: &str = "uavspec";

const EXAMPLES: &str = "Five things to try:
  uavspec sample               write a log, a bag and a session of one flight
  uavspec check flight.ulg     check the log against the definitions of PX4
  uavspec explain flight.ulg   why the vehicle couldn't arm, and what it did
  uavspec explain 134          what an error code, field or event means
  uavspec init                 generate code from definitions of your own";

const STATUS: &str = "Exit status:
  0  success: no MUST rule is violated; coverage may be partial
  1  does not conform, or another check failed
  2  invalid usage, unreadable definitions, or an unreadable baseline
  3  an input can't be opened, a report can't be written, or a testee or
     server failed
  4  an entry of a baseline no longer applies
  5  nothing was checked
  6  incomplete: some data can't be read, or too little was checked

If several statuses apply, the exit status is the first of 2, 3, 1, 6, 4 and 5
that applies.";

/// The exit statuses of a command that reports an outcome. `failure` is the meaning of status 3. `incomplete` is the
/// meaning of status 6, if the command uses this status. `test`, which runs cases, doesn't.
fn outcome_statuses(failure: &str, incomplete: Option<&str>) -> String {
    let success = incomplete.map_or("no case failed", |_| "no MUST rule is violated");
    let incomplete = incomplete.map(|meaning| format!("\n  6  incomplete: {meaning}")).unwrap_or_default();
    format!(
        "Exit status:
  0  {success}; coverage may be partial
  1  does not conform
  2  invalid usage, unreadable definitions, or an unreadable baseline
  3  {failure}
  4  an entry of a baseline no longer applies
  5  nothing was checked{incomplete}"
    )
}

/// Checks drone software against its interface specifications, and maintains the definitions.
#[derive(Debug, Parser)]
#[command(name = PROGRAM, version, max_term_width = 80)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{STATUS}"))]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a log, a bag and a recorded session to try out the other commands.
    ///
    /// The three files tell the same short flight: the vehicle can't arm before GPS has a fix, takes off, returns because
    /// its battery is low, and lands. Each file violates one rule.
    Sample(sample::SampleArgs),
    /// Create a workspace for definitions.
    ///
    /// If the folder contains .msg, .srv or .action files, uavspec.toml lists them with their package and dialect.
    /// Otherwise, an example is added.
    ///
    /// By default, the outputs are JSON Schemas, documentation, and TypeScript and Python types.
    Init(init::InitArgs),
    #[command(flatten)]
    Definitions(cli::Command),
    /// Check logs, bags, messages and recorded sessions.
    Check(check::CheckArgs),
    /// Compare a ROS 2 application with releases of PX4.
    ///
    /// The topics that the sources name are compared with each release: names, versions and definitions. The report
    /// says which topics work, which need PX4's message translation node, and which break.
    Compat(compat::CompatArgs),
    /// Convert a log, a bag or JSON messages to another release.
    ///
    /// Each message gets the type of the target release. The definitions and the hints decide the values of all fields.
    /// The report lists the data that is lost, and the number of messages that contain such data.
    Convert(convert::ConvertArgs),
    /// Explain a flight, or what a word means: a code, a message, a field, a value, a hash or a rule.
    ///
    /// If WHAT is a capture, the timeline lists the changes that explain what the vehicle did. All labels come from the
    /// definitions.
    ///
    /// Otherwise, WHAT is a word. The answer names the meaning, the unit, the valid values and the alternatives, the
    /// releases of PX4 or ROS 2 that contain the item, and the changes in each release.
    Explain(explain::ExplainArgs),
    /// Test a codec or validator in any language.
    ///
    /// The implementation under test is called a testee. It reads one JSON request per line and writes one JSON
    /// response per line, in any order. uavspec starts the testee as a child process, or connects to it over TCP.
    Test(test::TestArgs),
    /// Check how a testee implements the test protocol.
    #[command(subcommand, after_help = "Example:\n  uavspec testee lint -- ./my-codec --stdio")]
    Testee(testee::TesteeCommand),
    /// Test a live Flockwave server, or check the messages of a live PX4 vehicle.
    ///
    /// To a server, the probe sends each type of request that changes nothing, and it listens for notifications. Then
    /// it tests how the server handles split messages, invalid JSON and about forty malformed requests, each on a new
    /// connection.
    ///
    /// The probe may crash a server that has bugs. Never probe a server that is controlling flying UAVs.
    ///
    /// On the bus of a PX4 vehicle, the probe only listens, unless --as or --application is given. It checks the
    /// messages, and compares the publishers and subscribers of each topic.
    ///
    /// With --allow-commands, the given UAVs are calibrated and tested, put to sleep and woken up. They take off, fly
    /// at 10 m above home, return and land. After the landing, they are halted and restarted.
    ///
    /// Ctrl-C ends the probe. It first lands the UAVs that it commanded, stops their motors and wakes them, and then
    /// writes its reports. A second Ctrl-C leaves immediately. UAVs that may still be flying are the last line printed.
    Probe(Box<probe::ProbeArgs>),
    /// Run a reference Flockwave server, or a reference PX4 flight controller or external mode.
    ///
    /// The server has a simulated fleet. It prints the address of each transport on a separate line. Port 0 selects a
    /// free port. Each HTTP or Socket.IO address serves both HTTP and Socket.IO.
    ///
    /// Clients can send commands to the UAVs. OBJ-CMD also accepts three simulation commands. `error` sets the given
    /// error codes, or clears all codes if none are given. `battery` sets the charge in percent. After `lose`, the UAV
    /// stops reporting.
    ///
    /// Anyone who can reach an address can use the server. Prefer loopback addresses.
    ///
    /// With --px4, the program takes part in the arming checks on a bus: as a flight controller, or with --component as
    /// an external mode. Don't use the bus of a real vehicle.
    Serve(serve::ServeArgs),
    /// Show the fleet of a Flockwave server, or why a PX4 vehicle can't arm, in the terminal.
    ///
    /// For a vehicle or a capture, the display shows the failsafe flags, the modes that can't run, the batteries, and
    /// the external components with their replies to arming checks. It publishes nothing. A capture is replayed.
    ///
    /// For a server, the display requests the UAVs and their states, and changes nothing on the server. If the server reports nothing
    /// about a UAV for two seconds, the display requests the UAV's state. If the connection is lost, the display
    /// reconnects and keeps the last known states visible.
    ///
    /// Press ? for a list of all keys. The environment variable `NO_COLOR` disables colours.
    Watch(watch::WatchArgs),
    /// List the rules, or explain one.
    Rules(rules::RulesArgs),
    /// Test uavspec itself.
    ///
    /// The self-test generates captures that conform to the definitions, and captures that each violate one rule. It
    /// then probes the reference server and the PX4 references, first without bugs and then with one bug at a time. Each
    /// rule must find the violations meant for it and nothing else.
    ///
    /// The probes use free ports of 127.0.0.1 and take about two minutes. The PX4 references communicate within the
    /// process.
    SelfTest(self_test::SelfTestArgs),
    /// Serve an editor that supports the Language Server Protocol.
    ///
    /// The server reports the findings of `lint` while the user types. It also provides quick fixes, completion, texts
    /// about the item under the cursor, navigation, renaming, formatting, and the memory layout of messages.
    Lsp(lsp::LspArgs),
    /// Print a script that completes commands and options in a shell.
    Completions(completions::CompletionsArgs),
    /// Print the man page, or write the man pages of all commands.
    Man(man::ManArgs),
}

/// The command line with its texts.
fn interface() -> clap::Command {
    cli::with_program(Cli::command(), PROGRAM)
}

/// The output format of commands that don't write reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// Text for a terminal.
    Text,
    /// JSON for programs.
    Json,
}

/// The exit status of a run. A later variant takes precedence over an earlier one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Status {
    Conforms,
    Nothing,
    Stale,
    Incomplete,
    DoesNotConform,
    Unreadable,
    Usage,
}

/// The result of a command. An error ends the command early, and has already been printed.
type Exit = Result<Status, Status>;

impl Status {
    /// Prints a problem, and returns this status.
    fn because(self, problem: impl Display) -> Self {
        terminal::error(problem, None);
        self
    }

    /// Prints a problem and how to solve it, and returns this status.
    fn with_help(self, problem: impl Display, help: &str) -> Self {
        terminal::error(problem, Some(help));
        self
    }

    /// Prints a problem, which may have several lines, and returns this status.
    fn with_details(self, problem: impl Display) -> Self {
        terminal::error_with_details(problem);
        self
    }

    /// Prints a failure, and returns this status.
    fn failed(self, failure: &Failure) -> Self {
        terminal::eprintln!("{failure}");
        self
    }

    fn code(self) -> u8 {
        match self {
            Self::Conforms => 0,
            Self::DoesNotConform => 1,
            Self::Usage => 2,
            Self::Unreadable => 3,
            Self::Stale => 4,
            Self::Nothing => 5,
            Self::Incomplete => 6,
        }
    }
}

impl From<&Outcome> for Status {
    fn from(outcome: &Outcome) -> Self {
        match outcome.kind {
            _ if outcome.is_success() => Self::Conforms,
            OutcomeKind::Conforms | OutcomeKind::Partial => Self::Conforms,
            OutcomeKind::DoesNotConform => Self::DoesNotConform,
            OutcomeKind::Incomplete => Self::Incomplete,
            OutcomeKind::Failed => Self::Unreadable,
            OutcomeKind::Stale => Self::Stale,
            OutcomeKind::Nothing => Self::Nothing,
        }
    }
}

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    let Some(command) = terminal::parse_as::<Cli>(interface(), shown_value).command else {
        return introduce();
    };
    let exit = match command {
        Command::Definitions(command) => return command.run(),
        Command::Sample(args) => sample::run(&args),
        Command::Init(args) => init::run(&args),
        Command::Check(args) => check::check(&args),
        Command::Compat(args) => compat::run(&args),
        Command::Convert(args) => convert::run(&args),
        Command::Explain(args) => explain::explain(&args),
        Command::Test(args) => test::test(&args),
        Command::Testee(command) => testee::testee(&command),
        Command::Probe(args) => probe::run(&args),
        Command::Serve(args) => serve::serve(&args),
        Command::Watch(args) => watch::watch(&args),
        Command::Rules(args) => rules::rules(&args),
        Command::SelfTest(args) => self_test::self_test(&args),
        Command::Lsp(args) => lsp::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    finish(exit.unwrap_or_else(|status| status))
}

/// Prints suggestions for a user who named no command.
fn introduce() -> ExitCode {
    terminal::println!("{}\n\n`uavspec --help` lists all commands.", EXAMPLES);
    finish(Status::Conforms)
}

/// The exit code of a status.
fn finish(status: Status) -> ExitCode {
    // Text that couldn't be printed is worse than any finding in it.
    let printed = terminal::finish().map_err(unprinted);
    ExitCode::from(status.max(printed.err().unwrap_or(status)).code())
}

/// The first of these options that is given. The flag of an option is true if the option is given.
fn first_given(options: &[(&'static str, bool)]) -> Option<&'static str> {
    options.iter().find(|(_, is_given)| *is_given).map(|(name, _)| *name)
}

/// Prints an error about a file or folder that can't be used.
fn unreadable(path: &Path, error: impl Display) -> Status {
    Status::Unreadable.because(format_args!("{}: {error}", terminal::path(path)))
}

/// Prints an error about standard output.
fn unprinted(error: impl Display) -> Status {
    Status::Unreadable.because(format_args!("standard output: {error}"))
}

/// Prints an error about the handling of Ctrl-C.
fn uninterruptible(error: impl Display) -> Status {
    Status::Unreadable.because(format_args!("can't handle signals: {error}"))
}

/// Prints an error about a name that doesn't exist. The help suggests a similar name; if there is none, it is `help`.
fn unknown<'k>(problem: &str, name: &str, known: impl Iterator<Item = &'k str>, help: &str) -> Status {
    let help = similar(name, known).map_or_else(|| help.to_owned(), |known| format!("did you mean {known}?"));
    Status::Usage.with_help(problem, &help)
}

/// Prints an error about a rule id that doesn't exist.
fn unknown_rule(problem: &str, id: &str) -> Status {
    unknown(problem, id, RULES.iter().map(|rule| rule.id), "run `uavspec rules` for a list")
}

/// The command line of this run, without secrets.
fn command() -> String {
    let arguments = words();
    command_line(["uavspec"].into_iter().chain(arguments.iter().map(String::as_str)))
}

/// The arguments of the command line, without secrets.
fn words() -> Vec<String> {
    shown_words(std::env::args_os().skip(1).map(|argument| argument.to_string_lossy().into_owned()))
}

/// Loads the definitions at a path, or the built-in definitions. Prints errors.
fn definitions(path: Option<&Path>) -> Result<Definitions, Status> {
    let loaded = path.map_or_else(|| Ok(Definitions::built_in()), Definitions::load);
    loaded.map_err(|failure| Status::Usage.failed(&failure))
}

/// Loads the definitions of a path or a release, or the built-in definitions. Adds JSON Schemas for Flockwave types
/// that have no definition. Prints errors.
fn library(path: Option<&Path>, dialect: Option<Dialect>, schemas: &[PathBuf]) -> Result<Library, Status> {
    let loaded = path.map_or_else(|| Ok(Library::built_in()), |path| Library::load(path, dialect));
    let library = loaded.map_err(|failure| Status::Usage.failed(&failure))?;
    for file in library.left_out() {
        terminal::eprintln!("warning: {file} is left out: it refers to a package that isn't in the folder");
    }
    if library.has_built_in_packages() {
        terminal::eprintln!(
            "note: the packages that {} lacks come from the built-in definitions of ROS 2",
            library.name()
        );
    }
    library.with_schemas(schemas).map_err(|error| Status::Usage.with_details(error))
}
