//! Components with events as JSON.

use serde_json::{Map, Value as Json, json};
use uavspec_schema::event::scalar_name;
use uavspec_schema::{Event, EventComponent, EventEnum, Package};

/// The name of a component, and the component as JSON.
pub(super) fn component(package: &Package, component: &EventComponent) -> (String, Json) {
    let enums: Map<String, Json> = component.enums.iter().map(enumeration).collect();
    let events: Map<String, Json> =
        component.events.iter().map(|found| (found.name.clone(), event(package, component, found))).collect();
    let groups: Map<String, Json> =
        component.mode_groups.iter().map(|(bit, modes)| (bit.to_string(), json!(modes))).collect();
    let model = json!({
        "id": component.id,
        "enums": enums,
        "events": events,
        "navigation_mode_groups": groups,
        "supported_protocols": component.protocols,
    });
    (component.namespace.clone(), model)
}

fn enumeration(found: &EventEnum) -> (String, Json) {
    let entries: Map<String, Json> = found
        .entries
        .iter()
        .map(|entry| {
            let model = json!({ "name": entry.name, "description": entry.description });
            (entry.value.to_string(), model)
        })
        .collect();
    let model = json!({
        "type": scalar_name(found.scalar),
        "separator": found.separator,
        "description": found.description,
        "entries": entries,
    });
    (found.name.clone(), model)
}

fn event(package: &Package, component: &EventComponent, event: &Event) -> Json {
    let arguments: Vec<Json> = event
        .arguments
        .iter()
        .map(|argument| {
            json!({
                "name": argument.name,
                "type": package.event_type(component, argument),
                "offset": argument.offset,
                "description": argument.description,
            })
        })
        .collect();
    json!({
        "id": event.id,
        "group": event.group,
        "type": event.kind.name(),
        "message": event.message,
        "description": event.description,
        "instance_arg_index": event.instance_argument,
        "arguments": arguments,
    })
}
