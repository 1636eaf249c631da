//! Tests of the published JSON Schema of stories.

use serde_json::{Value, json};
use uavspec_check::story::{Story, Texts};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::sample::Flight;
use uavspec_schema::translation::Translations;
use uavspec_test_support::schema::{Published, errors};

use super::to_json;

const STORY: Published = Published { title: "Story", file: "story" };

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    STORY.check::<Story>();
}

#[test]
fn the_story_of_a_flight_matches_the_schema() {
    let (definitions, translations) = (Definitions::built_in(), Translations::default());
    let bytes = Flight::new(&definitions).log().to_bytes();
    let story = Story::of_bytes(&bytes, &definitions, &Texts::of(translations)).expect("a story");
    let mut value: Value = serde_json::from_str(&to_json(&story)).expect("JSON");
    let schema = STORY.schema::<Story>();
    assert_eq!(errors(&schema, &value), Vec::<String>::new());
    value["lanes"][0]["kind"] = json!("fine");
    assert!(!errors(&schema, &value).is_empty(), "the schema rejects unknown kinds");
}
