//! Tests that the reference testee supports and passes all cases, and passes lint.

use std::collections::BTreeSet;
use std::time::Duration;

use uavspec_probe::testee::{Case, Options, Target, cases, lint, run};
use uavspec_rules::definitions::Definitions;

fn options() -> Options {
    let command = Target::Command(vec![env!("CARGO_BIN_EXE_uavspec-testee").into()]);
    // Requests are handled fast, but the machine may be busy.
    Options {
        timeout: Duration::from_secs(60),
        start_timeout: Duration::from_secs(120),
        ..Options::new(command)
    }
}

#[test]
fn passes_all_cases() {
    let definitions = Definitions::built_in();
    let types = definitions.types();
    let cases = cases(&definitions, types);
    let all: Vec<usize> = (0..cases.len()).collect();
    let outcome = run(&cases, &all, types, &options(), &|_, _| {}).expect("a valid hello");
    let failed: BTreeSet<String> = outcome.failures().map(|(case, _)| Case::name(case)).collect();
    assert_eq!(failed, BTreeSet::new());
    assert!(outcome.protocol_remarks.is_empty(), "{:?}", outcome.protocol_remarks);
    assert!(!cases.is_empty() && outcome.counts().passed == cases.len() as u64, "{:?}", outcome.counts());
}

#[test]
fn passes_lint() {
    let definitions = Definitions::built_in();
    let types = definitions.types();
    let result =
        lint(&cases(&definitions, types), types, &options(), &[], &|_, _| {}).expect("the testee starts");
    for (check, outcome) in &result.outcomes {
        assert_eq!(outcome.name(), "pass", "{}: {outcome:?}", check.id);
    }
}
