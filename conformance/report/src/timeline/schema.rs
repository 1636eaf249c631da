//! Tests of the published JSON Schema of timelines.

use serde_json::{Value, json};
use uavspec_check::timeline::{Texts, Timeline};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_schema::translation::Translations;
use uavspec_test_support::schema::{Published, errors};

use super::to_json;

const TIMELINE: Published = Published { title: "Timeline", file: "timeline" };

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    TIMELINE.check::<Timeline>();
}

#[test]
fn the_timeline_of_a_flight_matches_the_schema() {
    let (definitions, translations) = (Definitions::built_in(), Translations::default());
    let bytes = Flight::new(&definitions).log().to_bytes();
    let timeline = Timeline::of_bytes(&bytes, &definitions, &Texts::of(translations)).expect("a timeline");
    let mut value: Value = serde_json::from_str(&to_json(&timeline)).expect("JSON");
    let schema = TIMELINE.schema::<Timeline>();
    assert_eq!(errors(&schema, &value), Vec::<String>::new());
    value["lanes"][0]["kind"] = json!("fine");
    assert!(!errors(&schema, &value).is_empty(), "the schema rejects unknown kinds");
}
