//! A test of the JSON Schema of reports. Other tests check that reports match the schema.

use uavspec_test_support::schema::Published;

use super::Report;

#[test]
fn the_published_schema_is_up_to_date_and_described() {
    Published { title: "Report", file: "report" }.check::<Report>();
}
