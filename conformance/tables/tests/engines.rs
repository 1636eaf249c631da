//! Runs the queries in the guide, in third-party engines.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use tempfile::TempDir;
use uavspec_check::check_capture;
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_report::{CheckedCapture, Origin, Settings, Subject, TableFormat};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_schema::translation::Translations;
use uavspec_tables::Dataset;
use uavspec_test_support::python::python;

/// The engines.
const ENGINES: [&str; 4] = ["duckdb==2.0.1", "polars==2.1.0", "datafusion==55.0.0", "pyarrow==26.0.1"];

#[test]
#[ignore = "installs DuckDB, Polars and DataFusion for Python"]
fn engines_run_the_queries_of_the_guide() {
    let folder = TempDir::new().expect("a folder");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (definitions, texts) = (Definitions::built_in(), Texts::of(Translations::default()));
    let mut tables = Dataset::create(folder.path(), TableFormat::Parquet, true).expect("a new folder");
    let flight = Flight::new(&definitions);
    let captures = uavspec_rules::mutants().flat_map(|mutant| mutant.captures(&flight));
    let subject = |(path, bytes): (String, Vec<u8>)| {
        let result = check_capture(&bytes[..], None, &definitions).expect("bytes can be read");
        let checked = CheckedCapture::new(path, result, Duration::from_millis(7));
        Subject::from_capture(checked, &definitions, &Settings::default())
    };
    let subjects: Vec<Subject> = captures.map(subject).collect();
    for subject in &subjects {
        tables.add(subject, &Origin::default(), None);
    }
    let flight = flight.log().to_bytes();
    let timeline = Timeline::of_bytes(&flight, &definitions, &texts).expect("a timeline");
    tables.add(&subjects[0], &Origin::default(), Some(&timeline));
    // An arming check that fails.
    let event = format!(
        r#"{{"type": "px4/Event", "message": {{"timestamp": 9, "id": 22222072, "event_sequence": 1, "arguments": {:?},
        "log_levels": 51}}}}"#,
        [0; 25]
    );
    let timeline = Timeline::of_bytes(event.as_bytes(), &definitions, &texts).expect("a timeline");
    tables.add(&subjects[0], &Origin::default(), Some(&timeline));
    tables.finish().expect("written");
    let output = Command::new(python("table-engines", &ENGINES))
        .arg(root.join("tests/engines/queries.py"))
        .args([root.join("../../xtask/site/guide/query.md").as_path(), folder.path()])
        .output()
        .expect("Python");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    // Each query has been run in each engine.
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().count(), 11, "{errors}");
}
