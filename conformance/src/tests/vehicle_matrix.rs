//! Probes of the reference autopilot and the reference component: without a bug there are no findings, and each bug
//! violates its rule, live and in the recording.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::bus::memory::Network;
use crate::check::{Checked, check_path};
use crate::definitions::Library;
use crate::matrix::list;
use crate::model::Findings;
use crate::rules::px4::{Px4Rule, RULES, Side};
use crate::rules::rule;
use crate::vehicle::{Options, Probed, probe, serve};

/// The time of each probe.
const TIME: Duration = Duration::from_millis(6_500);

/// The time between the starts of two participants.
const PAUSE: Duration = Duration::from_millis(150);

/// The number of concurrent probes. Most of the time is spent waiting.
const JOBS: usize = 8;

/// A probe of one or two references.
#[derive(Clone, Copy)]
struct Case {
    /// The references.
    references: &'static [Side],
    /// The role of the probe.
    role: Option<Side>,
    /// The rule that a reference violates.
    bug: Option<&'static Px4Rule>,
}

/// The result of a probe.
struct Row {
    case: Case,
    live: BTreeSet<&'static str>,
    recorded: BTreeSet<&'static str>,
    covered: BTreeSet<&'static str>,
    details: Vec<String>,
    notes: Vec<String>,
}

const AUTOPILOT: Case = Case { references: &[Side::Autopilot], role: Some(Side::Component), bug: None };
const COMPONENT: Case = Case { references: &[Side::Component], role: Some(Side::Autopilot), bug: None };
const BOTH: Case = Case { references: &[Side::Autopilot, Side::Component], role: None, bug: None };

impl Case {
    /// A probe of the reference that has the bug of a rule.
    fn with_bug(entry: &'static Px4Rule) -> Option<Self> {
        let case = match entry.bug.as_ref()?.side {
            Side::Autopilot => AUTOPILOT,
            Side::Component => COMPONENT,
        };
        Some(Self { bug: Some(entry), ..case })
    }

    fn name(&self) -> String {
        let bug = self.bug.map_or("no bug", |entry| entry.rule.id);
        format!("{:?} probed as {:?}, {bug}", self.references, self.role)
    }

    fn expected(&self) -> BTreeSet<&'static str> {
        let also = self.bug.and_then(|entry| entry.bug.as_ref()).into_iter().flat_map(|bug| bug.also);
        also.copied().chain(self.bug).map(|entry| entry.rule.id).collect()
    }

    fn run(self) -> Row {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("run.mcap");
        let (network, library, is_over) = (Network::default(), Library::built_in(), AtomicBool::new(false));
        let mut bus = network.connect("/probe");
        let options = Options {
            time: TIME,
            topics: None,
            role: self.role,
            application: None,
            record: Some(file.clone()),
            is_stopped: Box::new(|| false),
        };
        let probed = thread::scope(|scope| {
            for (index, side) in (1..).zip(self.references) {
                let (network, is_over) = (&network, &is_over);
                let bug = self.bug.and_then(|entry| entry.bug.as_ref());
                scope.spawn(move || {
                    thread::sleep(PAUSE * index);
                    let mut bus = network.connect(&format!("/{side:?}"));
                    let is_over = || is_over.load(Ordering::Relaxed);
                    serve(&mut bus, *side, true, bug, &is_over).expect("a reference");
                });
            }
            let probed = probe(&mut bus, &library, &options, &|_| {});
            is_over.store(true, Ordering::Relaxed);
            probed.expect("a result")
        });
        let Probed { checked: Checked { result, .. }, notes, cut_short } = probed;
        assert_eq!(cut_short, None);
        let recorded = check_path(&file, None, &library, &|input| input).expect("a recording");
        let covered = RULES.iter().filter(|entry| result.findings.covered(&entry.rule) > 0);
        Row {
            case: self,
            live: violated(&result.findings),
            recorded: violated(&recorded.result.findings),
            covered: covered.map(|entry| entry.rule.id).collect(),
            details: details(&result.findings),
            notes,
        }
    }
}

impl Row {
    fn is_right(&self) -> bool {
        self.live == self.case.expected() && self.recorded == self.live
    }
}

fn violated(findings: &Findings) -> BTreeSet<&'static str> {
    findings.groups().map(|group| group.rule.id).collect()
}

fn details(findings: &Findings) -> Vec<String> {
    let groups = findings.groups();
    groups.map(|group| format!("{} {}: {}", group.rule.id, group.subject, group.examples[0].1)).collect()
}

/// Runs cases concurrently.
fn run(cases: &[Case]) -> Vec<Row> {
    let batches = cases.chunks(JOBS).flat_map(|batch| {
        thread::scope(|scope| {
            let jobs: Vec<_> = batch.iter().map(|case| scope.spawn(|| case.run())).collect();
            jobs.into_iter().map(|job| job.join().expect("a row")).collect::<Vec<_>>()
        })
    });
    batches.collect()
}

fn assert_right(rows: &[Row]) {
    let mut wrong = Vec::new();
    for row in rows {
        let Row { case, live, recorded, covered, details, notes } = row;
        let text = format!(
            "{}: {} live, {} recorded; {} covered; {notes:?}",
            case.name(),
            list(live),
            list(recorded),
            covered.len()
        );
        println!("{text}");
        if !row.is_right() {
            wrong.push(format!("{text}\n  {}", details.join("\n  ")));
        }
    }
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

#[test]
fn healthy_participants_have_no_findings() {
    let rows = run(&[AUTOPILOT, COMPONENT, BOTH]);
    assert_right(&rows);
    for row in rows {
        let talk = ["PX-EXT-01", "PX-EXT-02", "PX-EXT-03", "PX-EXT-05", "PX-EXT-06", "PX-TIME-01"];
        let missing: Vec<_> = talk.iter().filter(|id| !row.covered.contains(*id)).collect();
        assert!(missing.is_empty(), "{}: {missing:?}", row.case.name());
        assert_eq!(row.notes, Vec::<String>::new(), "{}", row.case.name());
    }
}

#[test]
fn each_bug_of_a_participant_violates_only_its_rule() {
    let wanted = std::env::var("UAVSPEC_BUGS").unwrap_or_default();
    let is_wanted = |case: &Case| {
        let mut ids = wanted.split(',');
        wanted.is_empty() || case.bug.is_some_and(|entry| ids.any(|id| id == entry.rule.id))
    };
    let cases: Vec<Case> = RULES.into_iter().filter_map(Case::with_bug).filter(is_wanted).collect();
    assert_right(&run(&cases));
}

#[test]
fn rules_on_arming_checks_have_a_bug() {
    let without = RULES.iter().filter(|entry| entry.rule.id.starts_with("PX-EXT") && entry.bug.is_none());
    assert_eq!(without.map(|entry| entry.rule.id).collect::<Vec<_>>(), Vec::<&str>::new());
    assert!(rule("PX-EXT-07").is_some());
}
