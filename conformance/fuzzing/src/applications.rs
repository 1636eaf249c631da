//! The sources of an application, and lists of DDS topics.

use std::path::Path;
use std::{fs, iter};

use uavspec_compat::{Application, CompatReport, DdsTopics, Hints, History, Side, compare};

use super::DEFINITIONS;

/// Reads the same bytes as a source in each language and as a list of DDS topics, and compares the topics.
pub(super) fn sources(data: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    for name in ["a.cpp", "a.py", "a.rs", "a.yaml", "a.launch", "dds_topics.yaml"] {
        fs::write(path(name), data).expect("a file");
    }
    let dds = DdsTopics::read(&path("dds_topics.yaml")).ok();
    let schema = &DEFINITIONS.schema;
    let application = read(folder.path());
    let side = Side { name: "px4".to_owned(), schema, dds };
    let sides = [side];
    let verdicts = compare(&application, schema, &sides, &History::default());
    let report = CompatReport::new("app", "px4", &application, &sides, verdicts);
    assert!(report.topics.len() <= application.uses.len());
    for text in
        [report.to_text(), report.to_markdown(), report.to_json(), report.to_sarif(&application.sources)]
    {
        assert!(text.ends_with('\n'), "{text:?}");
    }
    let again = read(folder.path());
    assert_eq!((again.uses, again.unread), (application.uses, application.unread));
}

fn read(folder: &Path) -> Application {
    Application::read(folder, &[&DEFINITIONS.schema], &Hints::default()).expect("a folder")
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let texts = [
        "a = create_subscription<px4_msgs::msg::VehicleStatus>(\"/fmu/out/vehicle_status_v1\", qos, [](auto) {});",
        "self.create_publisher(VehicleCommand, f'{ns}/fmu/in/vehicle_command{suffix(VehicleCommand)}', 1)",
        "let a = node.create_publisher::<VehicleCommand>(&format!(\"/{ns}/fmu/in/vehicle_command\"))?; // \"x\"",
        "publications:\n- topic: /fmu/out/vehicle_status\n  rate_limit: 5. # Hz\n",
        "<remap from=\"status\" to=\"$(var ns)/fmu/out/vehicle_status\"/><!-- R\"(' -->",
    ];
    texts.into_iter().chain(iter::once("")).map(|text| text.as_bytes().to_vec()).collect()
}
