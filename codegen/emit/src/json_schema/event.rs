//! The schema of a component's decoded events: the id, the name, and the arguments by name.

use uavspec_runtime::Scalar;
use uavspec_schema::{Event, EventArgument, EventComponent, Package};

use super::annotation::{annotation, annotations, filled};
use super::tree::{Member, Node, member};

/// The schema members for a decoded event of a component.
pub(super) fn members<'s>(package: &'s Package, component: &'s EventComponent) -> Vec<Member<'s>> {
    let events = component.events.iter().map(|found| event(package, component, found));
    vec![
        member("title", component.namespace.as_str()),
        member(
            "description",
            format!(
                "A decoded event of the component {}: its id, its name, and its arguments.",
                component.namespace
            ),
        ),
        member("type", "object"),
        member("oneOf", events.collect::<Node<'_>>()),
    ]
}

fn event<'s>(package: &'s Package, component: &'s EventComponent, event: &'s Event) -> Node<'s> {
    let names = || event.arguments.iter().map(|found| found.name.as_str());
    let arguments =
        event.arguments.iter().map(|found| (found.name.as_str().into(), argument(package, component, found)));
    let mut members = vec![member("title", event.name.as_str())];
    members.extend(annotation("description", filled(&event.message)));
    members.push(member("type", "object"));
    members.push(member(
        "properties",
        Node::Object(vec![
            member("id", Node::Object(vec![member("const", event.id)])),
            member("name", Node::Object(vec![member("const", event.name.as_str())])),
            member(
                "arguments",
                Node::Object(vec![
                    member("type", "object"),
                    member("properties", Node::Object(arguments.collect())),
                    member("required", names().map(Node::from).collect::<Node<'_>>()),
                    member("additionalProperties", false),
                ]),
            ),
        ]),
    ));
    members.push(member(
        "required",
        ["id", "name", "arguments"].into_iter().map(Node::from).collect::<Node<'_>>(),
    ));
    members.push(member("additionalProperties", false));
    members.extend(annotations([annotation("x-group", Some(event.group.as_str()))]));
    Node::Object(members)
}

/// The schema of an argument. Enums are open, because other firmware may send unknown values.
fn argument<'s>(package: &'s Package, component: &EventComponent, argument: &'s EventArgument) -> Node<'s> {
    let mut members = Vec::new();
    members.extend(annotation("description", filled(&argument.description)));
    if argument.scalar == Scalar::Float32 {
        // As in messages, null means NaN or an infinite number.
        members.push(member("type", ["number", "null"].into_iter().map(Node::from).collect::<Node<'_>>()));
    } else {
        members.push(member("type", "integer"));
        let (low, high) = argument.scalar.integer_bounds().unwrap_or_default();
        members.push(member("minimum", Node::Integer(low)));
        members.push(member("maximum", Node::Integer(high)));
    }
    members.extend(annotations([annotation("x-type", Some(package.event_type(component, argument)))]));
    Node::Object(members)
}
