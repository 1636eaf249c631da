//! `uavspec compat`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use uavspec_compat::{Application, CompatReport, DdsTopics, Hints, History, Side, compare, definitions_in};
use uavspec_model::text::terminal;
use uavspec_rules::definitions::{Family, Library, ReleaseId};
use uavspec_schema::msg::Dialect;
use uavspec_schema::{Failure, Schema};

use super::report::print_result;
use super::{Exit, Status, library};

/// The first release with the topics `/fmu/in` and `/fmu/out`. Before that, PX4 used a different bridge to ROS 2.
const FIRST: &str = "px4@1.14";

const EXAMPLES: &str = "Examples:
  uavspec compat my_workspace
  uavspec compat my_workspace --with px4@1.15..main
  uavspec compat my_package --definitions px4@1.16 --with px4@1.17
  uavspec compat my_workspace --against ../PX4-Autopilot
  uavspec compat my_workspace --format markdown";

const DETAILS: &str = "\
The sources are C++, Python and Rust files, and launch and YAML files. Names of topics contain `fmu/in/` or `fmu/out/`.

Verdicts:
  works        the application and PX4 use the same name and the same fields
  unused       the sources also name a version of the topic that works better
  translated   they work together if PX4's message translation node runs
  breaks       they exchange no messages, or decode them as garbage
  absent       PX4 doesn't have the topic
  not offered  PX4 has the topic, but doesn't offer it over DDS

A file with hints names topics that the sources contain only in parts:
  [[topic]]
  topic = \"fmu/in/vehicle_command\"
  type = \"VehicleCommand\"

Exit status:
  0  each topic works, at least with the translation node
  1  a topic breaks, is absent or is not offered
  2  invalid usage, unreadable definitions, or a mistake in the hints
  3  the sources can't be read, or the report can't be written
  5  the sources name no topics
  6  incomplete: a part of the sources can't be read";

/// Arguments of `compat`.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, after_long_help = format!("{EXAMPLES}\n\n{DETAILS}"))]
pub(super) struct CompatArgs {
    /// Folder with the sources: a ROS 2 workspace or a package.
    #[arg(value_name = "APP")]
    application: PathBuf,
    /// Releases to compare with: a release such as px4@1.16, or a range such as px4@1.15..main (repeatable).
    ///
    /// The default is all releases since px4@1.14. With --against, the default is none.
    #[arg(long, value_name = "RELEASES", value_delimiter = ',')]
    with: Vec<String>,
    /// PX4 sources or definitions to compare with: a checkout of PX4, or a folder with messages (repeatable).
    #[arg(long, value_name = "PATH")]
    against: Vec<PathBuf>,
    /// Definitions with which the application is built [default: the package `px4_msgs` in APP].
    ///
    /// A release such as px4@1.16, or a folder with messages.
    #[arg(long, value_name = "PATH")]
    definitions: Option<PathBuf>,
    /// File `dds_topics.yaml` with the topics that PX4 offers over DDS [default: the file of --against].
    ///
    /// Without such a file, the report doesn't say whether PX4 offers a topic over DDS. The file applies to all releases.
    #[arg(long, value_name = "FILE")]
    dds_topics: Option<PathBuf>,
    /// File with topics that the sources don't name.
    #[arg(long, value_name = "FILE")]
    hints: Option<PathBuf>,
    /// Format of the report: text, markdown, json or sarif.
    #[arg(long, value_name = "FORMAT", default_value = "text", hide_possible_values = true)]
    format: Format,
}

/// The format of the report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Markdown,
    Json,
    Sarif,
}

/// A version of PX4.
struct Version {
    name: String,
    library: Library,
    /// The topics that it offers over DDS, if they are known.
    dds: Option<DdsTopics>,
}

/// Runs `uavspec compat`.
pub(super) fn run(args: &CompatArgs) -> Exit {
    let usage = |failure: Failure| Status::Usage.failed(&failure);
    let own = own_definitions(args)?;
    let hints = args.hints.as_deref().map(Hints::read).transpose().map_err(usage)?.unwrap_or_default();
    let dds = args.dds_topics.as_deref().map(DdsTopics::read).transpose().map_err(usage)?;
    let labels = labels(args)?;
    let (others, released) = (others(args)?, released()?);
    let named = labels.iter().filter_map(|label| released.iter().find(|version| version.name == *label));
    let sides: Vec<Side<'_>> = named.chain(&others).map(|version| version.side(dds.as_ref())).collect();
    let schema = &own.base().schema;
    let schemas: Vec<&Schema> = std::iter::once(schema).chain(sides.iter().map(|side| side.schema)).collect();
    let application = Application::read(&args.application, &schemas, &hints)
        .map_err(|failure| Status::Unreadable.failed(&failure))?;
    let mut history = History::between_releases();
    for version in released.iter().chain(&others) {
        history.add(&version.library.base().schema);
    }
    let verdicts = compare(&application, schema, &sides, &history);
    let report =
        CompatReport::new(&args.application.to_string_lossy(), own.name(), &application, &sides, verdicts);
    print_result(&match args.format {
        Format::Text => report.to_text(),
        Format::Markdown => report.to_markdown(),
        Format::Json => report.to_json(),
        Format::Sarif => report.to_sarif(&application.sources),
    })?;
    Ok(if report.has_problems() {
        Status::DoesNotConform
    } else if !report.unread.is_empty() {
        Status::Incomplete
    } else if report.topics.is_empty() {
        Status::Nothing
    } else {
        Status::Conforms
    })
}

impl Version {
    /// The version in a comparison. The user's list of DDS topics takes precedence.
    fn side(&self, dds: Option<&DdsTopics>) -> Side<'_> {
        let dds = dds.or(self.dds.as_ref()).cloned();
        Side { name: self.name.clone(), schema: &self.library.base().schema, dds }
    }
}

/// The definitions with which the application is built. Prints errors.
fn own_definitions(args: &CompatArgs) -> Result<Library, Status> {
    let found = || definitions_in(&args.application);
    let Some(path) = args.definitions.clone().or_else(found) else {
        let problem = format!("{}: no package `px4_msgs`", terminal::path(&args.application));
        let help =
            "specify the release with which the application is built, such as `--definitions px4@1.16`";
        return Err(Status::Usage.with_help(problem, help));
    };
    library(Some(&path), Some(Dialect::Px4), &[])
}

/// The releases to compare with. Prints errors.
fn labels(args: &CompatArgs) -> Result<Vec<String>, Status> {
    let all = [format!("{FIRST}..main")];
    let ranges = if args.with.is_empty() && args.against.is_empty() { &all[..] } else { &args.with };
    let releases: Vec<Vec<String>> = ranges.iter().map(|range| releases(range)).collect::<Result<_, _>>()?;
    Ok(releases.concat())
}

/// All releases of PX4. Prints errors.
fn released() -> Result<Vec<Version>, Status> {
    let library = Library::built_in();
    let index = library.index();
    let version = |release| {
        let name = index.label(release);
        let library = Library::release(&name).map_err(|failure| Status::Usage.failed(&failure))?;
        Ok(Version { name, library, dds: None })
    };
    index.releases_of(Family::Px4).map(version).collect()
}

/// The versions of `--against`. Prints errors.
fn others(args: &CompatArgs) -> Result<Vec<Version>, Status> {
    let version = |path: &PathBuf| {
        let messages = path.join("msg");
        let messages = if path.join("src").is_dir() && messages.is_dir() { &messages } else { path };
        let library = library(Some(messages), Some(Dialect::Px4), &[])?;
        let dds = DdsTopics::of_checkout(path).map_err(|failure| Status::Usage.failed(&failure))?;
        Ok(Version { name: path.to_string_lossy().into_owned(), library, dds })
    };
    args.against.iter().map(version).collect()
}

/// The releases of a range such as `px4@1.15..main`. Prints errors.
fn releases(range: &str) -> Result<Vec<String>, Status> {
    let library = Library::built_in();
    let index = library.index();
    let known: Vec<ReleaseId> = index.releases_of(Family::Px4).collect();
    let first = known.iter().position(|release| index.label(*release) == FIRST).unwrap_or(0);
    let at = |name: &str| {
        let label = if name.contains('@') { name.to_owned() } else { format!("px4@{name}") };
        let found = known.iter().position(|release| index.label(*release) == label);
        found.filter(|at| *at >= first).ok_or_else(|| {
            let labels: Vec<String> = known[first..].iter().map(|release| index.label(*release)).collect();
            let problem = format!("can't compare with `{}`", terminal::shown(&label));
            Status::Usage.with_help(problem, &format!("the releases are {}", labels.join(", ")))
        })
    };
    let (from, to) = range.split_once("..").unwrap_or((range, range));
    let (from, to) = (at(from)?, at(to)?);
    if from > to {
        let problem = format!("the range `{}` is empty", terminal::shown(range));
        return Err(Status::Usage.with_help(problem, "start with the older release"));
    }
    Ok(known[from..=to].iter().map(|release| index.label(*release)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_contain_both_ends() {
        assert_eq!(
            releases("px4@1.15..1.17"),
            Ok(["px4@1.15", "px4@1.16", "px4@1.17"].map(str::to_owned).into())
        );
        assert_eq!(releases("px4@main"), Ok(vec!["px4@main".to_owned()]));
        for wrong in ["px4@1.17..1.15", "px4@1.13", "ros2@humble", "px4@1.14..", "..", ""] {
            assert_eq!(releases(wrong), Err(Status::Usage), "{wrong}");
        }
    }
}
