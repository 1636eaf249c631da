//! Tests of the published JSON Schema of conversion reports.

use serde_json::{Value, json};
use uavspec_check::convert::{ConversionReport, Settings};
use uavspec_test_support::schema::{Published, errors};

use super::{converted, sample};

const CONVERSION: Published = Published { title: "ConversionReport", file: "conversion" };

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    CONVERSION.check::<ConversionReport>();
}

#[test]
fn reports_match_the_schema() {
    let schema = CONVERSION.schema::<ConversionReport>();
    let bytes = sample("px4@1.17").bag().to_bytes();
    for bytes in [&bytes[..], &bytes[..bytes.len() / 2]] {
        let (report, _) = converted(bytes, "px4@1.16", Settings::default());
        let mut value: Value = serde_json::from_str(&report.to_json()).expect("JSON");
        assert_eq!(errors(&schema, &value), Vec::<String>::new());
        value["topics"][0]["action"] = json!("lost");
        assert!(!errors(&schema, &value).is_empty(), "the schema rejects unknown actions");
    }
}
