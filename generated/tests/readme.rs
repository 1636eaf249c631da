//! The example of the README, compiled and run; and held to be the README's, word for word.

#[test]
#[rustfmt::skip]
fn example() {
// README
use uavspec::flockwave::ErrorCode;
use uavspec::px4::arming_check_reply::HealthComponentIndex;
use uavspec::px4::{ArmingCheckReply, Event};
use uavspec_runtime::{Message, Severity, UorbMessage};

let mut reply = ArmingCheckReply { request_id: 7, num_events: 1, ..Default::default() };
reply.events[0] = Event { id: 0x0100_0001, ..Default::default() };
assert_eq!(reply.health_component_index, HealthComponentIndex::NONE);

assert_eq!(ArmingCheckReply::TOPICS, ["arming_check_reply"]);
assert_eq!(ArmingCheckReply::VERSION, Some(1));
assert_eq!(ArmingCheckReply::SIZE, 232);

let code = ErrorCode(199);
assert_eq!(code, ErrorCode::LOWBAT_FATAL);
assert_eq!(code.severity(), Severity::Fatal);
assert_eq!(code.alternatives(), [ErrorCode::LOWBAT_WARNING, ErrorCode::LOWBAT_ERROR]);
// README
}

#[test]
fn is_that_of_the_readme() {
    let example = include_str!("readme.rs").split("// README\n").nth(1).expect("the example");
    let readme = include_str!("../../README.md");
    assert!(readme.contains(&format!("```rust\n{example}```\n")), "the README shows another example");
}
