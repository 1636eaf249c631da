//! What several tests need: a message that has a field of every kind, the published schemas, and a runner.

pub(crate) mod every;

use std::fmt::Debug;
use std::fs;
use std::path::Path;

use jsonschema::{Registry, Resource, Validator};
use proptest::strategy::{Strategy, ValueTree as _};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use serde_json::{Value as Json, json};

/// Calls a macro with each message of the package px4.
macro_rules! for_each_message {
    ($call:ident) => {
        for_each_message!($call ArmingCheckReply ArmingCheckRequest BatteryStatus Event FailsafeFlags
            RegisterExtComponentReply RegisterExtComponentRequest UnregisterExtComponent);
    };
    ($call:ident $($type:ident)*) => {
        $($call::<uavspec::px4::$type>();)*
    };
}
pub(crate) use for_each_message;

/// A runner that draws the same values each time, so that a failure is seen by everybody.
pub(crate) fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// Checks so many values.
#[track_caller]
pub(crate) fn check<S: Strategy>(
    cases: u32,
    strategy: &S,
    test: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    if let Err(error) = runner(cases).run(strategy, test) {
        panic!("{error}");
    }
}

/// Draws so many values.
pub(crate) fn draw<S: Strategy>(cases: usize, strategy: &S) -> Vec<S::Value> {
    let mut runner = runner(1);
    (0..cases).map(|_| strategy.new_tree(&mut runner).expect("a value").current()).collect()
}

/// What the first value that fails is simplified to.
pub(crate) fn simplest<S: Strategy>(strategy: &S, fails: impl Fn(&S::Value) -> bool) -> S::Value
where
    S::Value: Debug,
{
    let mut runner = runner(1);
    for _ in 0..10_000 {
        let mut tree = strategy.new_tree(&mut runner).expect("a value");
        if !fails(&tree.current()) {
            continue;
        }
        let mut goes_on = tree.simplify();
        while goes_on {
            goes_on = if fails(&tree.current()) { tree.simplify() } else { tree.complicate() };
        }
        assert!(fails(&tree.current()), "what is left fails too");
        return tree.current();
    }
    panic!("no value fails");
}

/// The published schemas.
pub(crate) fn published() -> Registry<'static> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    let files = ["px4", "flockwave"].into_iter().flat_map(|package| {
        let entries = fs::read_dir(folder.join(package)).expect("a folder of schemas");
        entries.map(|entry| entry.expect("an entry").path())
    });
    let resources = files.map(|path| {
        let document: Json = serde_json::from_slice(&fs::read(path).expect("a schema")).expect("JSON");
        (document["$id"].as_str().expect("an address").to_owned(), Resource::from_contents(document))
    });
    Registry::new().extend(resources).expect("addresses").prepare().expect("references that hold")
}

/// A validator by the published schema of `px4/Event` and the like.
pub(crate) fn publisher(registry: &Registry<'_>, name: &str) -> Validator {
    let schema = json!({ "$ref": format!("https://uavspec.dev/schemas/{name}.schema.json") });
    jsonschema::options().with_registry(registry).build(&schema).expect("a schema that compiles")
}
