//! `uavspec probe` for PX4 vehicles.

use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use globset::{Glob, GlobSet, GlobSetBuilder};
use uavspec_check::Checked;
use uavspec_live::bus::{self, Address};
use uavspec_live::vehicle::{Namespace, Options, probe};
use uavspec_model::clock::Clock;
use uavspec_model::text::plural;
use uavspec_report::CheckedCapture;
use uavspec_rules::px4::Side;

use super::application::Application;
use super::{ProbeArgs, report, start_reports};
use crate::app::progress::Progress;
use crate::app::{Exit, Status, baseline, first_given, interrupt, library};

/// The default time to listen.
const TIME: Duration = Duration::from_secs(20);

/// The characters with a special meaning in patterns.
const PATTERN: &[char] = &['*', '?', '[', ']', '{', '}', '!', '\\'];

/// Arguments for PX4 vehicles.
#[derive(Args, Debug)]
#[command(next_help_heading = "Options for PX4 vehicles")]
pub(super) struct VehicleArgs {
    /// Topics to receive, as a glob pattern (repeatable) [default: all].
    ///
    /// For example, '/fmu/out/*'. Publishers and subscribers of other topics are compared as well. A rosbridge server
    /// without rosapi can't list its topics, so give the full name of each topic instead of a pattern.
    #[arg(long, value_name = "GLOB", value_delimiter = ',')]
    topics: Vec<Glob>,
    /// Namespace of the vehicle, such as alpha for topics in /alpha/fmu [default: the namespace of the only vehicle].
    ///
    /// For --as and --application.
    #[arg(long, value_name = "NAMESPACE")]
    namespace: Option<Namespace>,
    /// IP address of a computer that multicast doesn't reach (DDS, repeatable).
    #[arg(long, value_name = "ADDRESS")]
    peer: Vec<IpAddr>,
    /// Definitions with which an application was built: a folder, or a PX4 release such as px4@1.15.
    ///
    /// The probe asks the flight controller for its definition of each topic in /fmu/in and /fmu/out, as applications do,
    /// and compares it with the application's definition. If files in the folder name such topics, only these are compared.
    #[arg(long, value_name = "PATH|RELEASE")]
    pub(super) application: Option<PathBuf>,
    /// Take part in the arming checks: as the flight controller (autopilot), to test components; or as a component, to
    /// test a flight controller [default: only listen].
    ///
    /// A component registers, refuses arming in a single reply, and unregisters. The probe sends no commands and never
    /// arms. Don't use `--as autopilot` on a bus with a flight controller: components would receive two sets of
    /// requests.
    #[arg(long = "as", value_name = "ROLE", value_parser = roles(), hide_possible_values = true)]
    role: Option<Side>,
}

/// The names of the sides on which the probe can take part in arming checks.
fn roles() -> impl TypedValueParser<Value = Side> {
    PossibleValuesParser::new(["autopilot", "component"])
        .map(|name| if name == "autopilot" { Side::Autopilot } else { Side::Component })
}

impl VehicleArgs {
    /// The first of these options that is given.
    pub(super) fn given(&self) -> Option<&'static str> {
        first_given(&[
            ("--topics", !self.topics.is_empty()),
            ("--namespace", self.namespace.is_some()),
            ("--peer", !self.peer.is_empty()),
            ("--application", self.application.is_some()),
            ("--as", self.role.is_some()),
        ])
    }

    /// The items of `--topics` that are names, not patterns.
    fn names(&self) -> Vec<String> {
        let names = self.topics.iter().map(Glob::glob).filter(|glob| !glob.contains(PATTERN));
        names.map(str::to_owned).collect()
    }

    /// The patterns in `--topics`. `None` if all topics are received.
    fn selected(&self) -> Option<GlobSet> {
        let mut set = GlobSetBuilder::new();
        for glob in &self.topics {
            set.add(glob.clone());
        }
        // Each pattern is valid.
        set.build().ok().filter(|_| !self.topics.is_empty())
    }
}

pub(super) fn probe_vehicle(args: &ProbeArgs, address: &Address) -> Exit {
    let library = args.events.add_to(library(args.definitions.as_deref(), None, &[])?)?;
    let application = args.vehicle.application.as_deref().map(Application::load).transpose()?;
    let (application, note) = application.map(|found| (found.types, found.note)).unzip();
    let required = args.require.rules()?;
    let outputs = start_reports(args)?;
    let baselines = baseline::read(&args.baseline)?;
    let interruptible = uavspec_probe::Options::new(Duration::ZERO, None, Vec::new());
    interrupt::install(&interruptible)?;
    let stop = interruptible.stop;
    let failed = |problem: String| Status::Unreadable.because(format_args!("{address}: {problem}"));
    let mut bus = bus::connect(address, &args.vehicle.peer, &args.vehicle.names()).map_err(failed)?;
    let stopped = stop.clone();
    let options = Options {
        time: args.time.unwrap_or(TIME),
        topics: args.vehicle.selected(),
        namespace: args.vehicle.namespace.clone(),
        role: args.vehicle.role,
        application,
        record: args.record.clone(),
        is_stopped: Box::new(move || stopped.is_requested()),
    };
    let started = Clock::real().now();
    let progress = Progress::time();
    let total = usize::try_from(options.time.as_millis()).unwrap_or(usize::MAX);
    let probed = probe(&mut *bus, &library, &options, &|state| {
        progress.set(usize::try_from(state.elapsed.as_millis()).unwrap_or(total).min(total), total);
        progress.describe(format!(
            "{}, {}, {}",
            plural(state.topics, "topic"),
            plural(state.messages, "message"),
            plural(state.findings, "finding"),
        ));
    });
    drop(progress);
    let probed = probed.map_err(|error| failed(format!("can't write the recording: {error}")))?;
    let Checked { result, definitions } = probed;
    let elapsed = Clock::real().now() - started;
    let checked = CheckedCapture {
        notes: note.flatten().into_iter().collect(),
        ..CheckedCapture::new(address.to_string(), result, elapsed)
    };
    let mut settings = args.outcome.settings();
    settings.allows_incomplete &= !stop.is_requested();
    settings.is_unrecorded = args.record.is_none();
    Ok(report(outputs, vec![checked], Vec::new(), &definitions, &required, baselines, settings))
}
