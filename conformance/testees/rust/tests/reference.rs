//! The reference testee knows everything that can be asked, is right about it, and has manners.

use std::collections::BTreeSet;
use std::time::Duration;

use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::testee::{Case, Options, Target, cases, lint, run};

fn options() -> Options {
    let command = Target::Command(vec![env!("CARGO_BIN_EXE_uavspec-testee").into()]);
    // Nothing here should take long, and on a busy machine it may.
    Options {
        timeout: Duration::from_secs(60),
        start_timeout: Duration::from_secs(120),
        ..Options::new(command)
    }
}

#[test]
fn it_is_right() {
    let definitions = Definitions::built_in();
    let types = definitions.types();
    let cases = cases(&definitions, types);
    let all: Vec<usize> = (0..cases.len()).collect();
    let outcome = run(&cases, &all, types, &options(), &|_, _| {}).expect("it introduces itself");
    let failed: BTreeSet<String> = outcome.failures().map(|(case, _)| Case::name(case)).collect();
    assert_eq!(failed, BTreeSet::new());
    assert!(outcome.protocol_remarks.are_good(), "{:?}", outcome.protocol_remarks);
    assert!(!cases.is_empty() && outcome.counts().passed == cases.len(), "{:?}", outcome.counts());
}

#[test]
fn it_has_manners() {
    let definitions = Definitions::built_in();
    let types = definitions.types();
    let found = lint(&cases(&definitions, types), types, &options(), &[], &|_, _| {}).expect("it starts");
    for (check, outcome) in &found.outcomes {
        assert_eq!(outcome.name(), "pass", "{}: {outcome:?}", check.id);
    }
}
