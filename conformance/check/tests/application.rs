//! Tests of the comparison of an application with a vehicle.

use std::sync::{Arc, LazyLock};

use uavspec_check::check_capture;
use uavspec_model::{ApplicationType, Endpoint};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::rule;
use uavspec_rules::sample::{Bag, Flight};
use uavspec_test_support::extent;

static DEFINITIONS: LazyLock<Arc<Definitions>> = LazyLock::new(|| definitions("px4@1.18"));

const TOPIC: &str = "/fmu/out/vehicle_status";

fn definitions(release: &str) -> Arc<Definitions> {
    Arc::clone(Library::release(release).expect("a release").base())
}

/// The vehicle status that an application uses.
fn status(definitions: &Definitions) -> ApplicationType {
    let id = definitions.message_of_topic("vehicle_status").expect("a topic");
    ApplicationType::new(&definitions.schema, definitions.schema.message(id))
}

/// A flight with PX4 1.18, in which the vehicle reports its hash of the vehicle status.
fn bag(application: ApplicationType) -> Bag {
    let mut flight = Flight::new(&DEFINITIONS);
    // Two rounds are sufficient.
    flight.messages.truncate(extent(usize::MAX, 2 * flight.topics.len()));
    let responses = flight.topic("MessageFormatResponse").expect("a topic");
    for sent in flight.messages.iter_mut().filter(|sent| sent.topic == responses) {
        sent.value["topic_name"] = TOPIC.into();
        sent.value["message_hash"] = status(&DEFINITIONS).hash.into();
    }
    let mut bag = flight.bag();
    bag.application = vec![application];
    bag
}

/// Renames the endpoints of the vehicle status.
fn rename(bag: &mut Bag, name: &str) {
    for endpoint in bag.endpoints.iter_mut().filter(|endpoint| endpoint.topic == TOPIC) {
        name.clone_into(&mut endpoint.topic);
    }
}

/// The subject and the message of each finding.
fn found(bag: &Bag) -> Vec<(String, String)> {
    let result = check_capture(&bag.to_bytes()[..], None, &DEFINITIONS).expect("a result");
    let rule = rule("PX-HASH-02").expect("a rule");
    assert!(result.findings.covered(rule) > 0);
    let groups = result.findings.groups();
    groups
        .map(|group| {
            assert_eq!((group.rule.id, group.count), (rule.id, 1));
            (group.subject.clone(), group.examples[0].1.message.clone())
        })
        .collect()
}

#[test]
fn the_definition_of_the_vehicle_conforms() {
    assert_eq!(found(&bag(status(&DEFINITIONS))), []);
}

#[test]
fn another_definition_is_found_with_its_release_and_its_effect() {
    let found = found(&bag(status(&definitions("px4@1.15"))));
    assert_eq!(found.len(), 1);
    let (subject, message) = &found[0];
    assert_eq!(subject, TOPIC);
    let start = "VehicleStatus: the application uses the definition of px4@1.15, but the vehicle uses the definition of px4@1.18 to \
                 px4@main: missing fields: accepts_offboard_setpoints (bool), ";
    assert!(message.starts_with(start), "{message}");
    assert!(message.ends_with(". The values from `valid_nav_states_mask` on are garbage"), "{message}");
}

#[test]
fn unknown_definitions_are_named() {
    let own = ApplicationType { hash: 7, fields: "uint64 timestamp\n".to_owned(), ..status(&DEFINITIONS) };
    let found = found(&bag(own));
    assert!(
        found[0].1.contains("the application uses a definition that matches no known release, but"),
        "{found:?}"
    );
}

#[test]
fn topics_of_the_translation_node_conform() {
    let application = ApplicationType { version: Some(1), ..status(&definitions("px4@1.15")) };
    let mut bag = bag(application);
    rename(&mut bag, "/fmu/out/vehicle_status_v3");
    let (_, message) = &found(&bag)[0];
    let end = ". There is no topic /fmu/out/vehicle_status_v1, only /fmu/out/vehicle_status_v3";
    assert!(message.ends_with(end), "{message}");
    let offered = bag.endpoints.iter().find(|endpoint| endpoint.topic.ends_with("vehicle_status_v3"));
    let topic = "/fmu/out/vehicle_status_v1".to_owned();
    let offered = Endpoint { topic, id: "translated".to_owned(), ..offered.expect("an endpoint").clone() };
    bag.endpoints.push(offered);
    assert_eq!(found(&bag), []);
}
