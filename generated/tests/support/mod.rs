//! Shared test code: a message with a field of every type, the published schemas, and a test runner.

pub(crate) mod every;

use std::env;
use std::fmt::Debug;
use std::fs;
use std::iter;
use std::path::Path;
use std::sync::LazyLock;

use jsonschema::{Registry, Resource, Validator};
use proptest::strategy::{Strategy, ValueTree as _};
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use serde_json::{Value as Json, json};

/// Calls a generic function with each message of the package px4.
macro_rules! for_each_message {
    ($call:ident) => {
        for_each_message!($call ArmingCheckReply ArmingCheckRequest BatteryStatus Event FailsafeFlags
            RegisterExtComponentReply RegisterExtComponentRequest UnregisterExtComponent);
    };
    ($call:ident $($type:ident)*) => {
        $($call::<uavspec_types::px4::$type>();)*
    };
}
pub(crate) use for_each_message;

/// `full` if `UAVSPEC_TEST_THOROUGH` is set, as in `.ci/run --release`; otherwise `quick`.
pub(crate) fn extent<T>(full: T, quick: T) -> T {
    if env::var_os("UAVSPEC_TEST_THOROUGH").is_some_and(|value| value != "0") { full } else { quick }
}

/// A runner that draws the same values each time, so failures are reproducible.
pub(crate) fn runner(cases: u32) -> TestRunner {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha))
}

/// Tests `cases` values of a strategy, or an eighth of this number in a quick run.
#[track_caller]
pub(crate) fn check<S: Strategy>(
    cases: u32,
    strategy: &S,
    test: impl Fn(S::Value) -> Result<(), TestCaseError>,
) {
    if let Err(error) = runner(extent(cases, cases / 8)).run(strategy, test) {
        panic!("{error}");
    }
}

/// Draws values of a strategy endlessly.
pub(crate) fn values<S: Strategy>(strategy: &S) -> impl Iterator<Item = S::Value> {
    let mut runner = runner(1);
    iter::repeat_with(move || strategy.new_tree(&mut runner).expect("a value").current())
}

/// Draws `cases` values of a strategy.
pub(crate) fn draw<S: Strategy>(cases: usize, strategy: &S) -> Vec<S::Value> {
    values(strategy).take(cases).collect()
}

/// Simplifies the first failing value.
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
        let mut can_continue = tree.simplify();
        while can_continue {
            can_continue = if fails(&tree.current()) { tree.simplify() } else { tree.complicate() };
        }
        assert!(fails(&tree.current()), "the simplified value still fails");
        return tree.current();
    }
    panic!("no value fails");
}

/// The published schemas.
pub(crate) static PUBLISHED: LazyLock<Registry<'static>> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    let files = ["px4", "flockwave"].into_iter().flat_map(|package| {
        let entries = fs::read_dir(folder.join(package)).expect("a folder of schemas");
        entries.map(|entry| entry.expect("an entry").path())
    });
    let resources = files.map(|path| {
        let document: Json = serde_json::from_slice(&fs::read(path).expect("a schema")).expect("JSON");
        (document["$id"].as_str().expect("an address").to_owned(), Resource::from_contents(document))
    });
    Registry::new().extend(resources).expect("addresses").prepare().expect("valid references")
});

/// A validator for the published schema with a name such as `px4/Event`.
pub(crate) fn published_validator(name: &str) -> Validator {
    let schema = json!({ "$ref": format!("https://schemas.invalid/{name}.schema.json") });
    jsonschema::options().with_registry(&PUBLISHED).build(&schema).expect("a schema that compiles")
}
