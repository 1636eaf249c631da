//! DEV: devices and channels of UAVs (`definitions/flockwave/dev.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub, SessionId};
use crate::server::message::{Outcome, Parts};
use crate::server::request::{boolean, optional_strings, strings};

/// How many subscriptions a client may have.
const SUBSCRIPTION_LIMIT: usize = 10_000;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "DEV-INF" => values(hub, call),
        "DEV-LIST" => trees(hub, call),
        "DEV-LISTSUB" => subscriptions(hub, call),
        "DEV-SUB" => subscribe(hub, call),
        "DEV-UNSUB" => unsubscribe(hub, call),
        _ => Err(unknown(call)),
    }
}

fn values(hub: &Hub, call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "values");
    for path in strings(call.body, "paths")? {
        parts.put(&path, hub.world.values_at(&path).map(Outcome::Value));
    }
    Ok(parts.into_body())
}

fn trees(hub: &Hub, call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "devices");
    for id in strings(call.body, "ids")? {
        let kind = hub.world.objects().into_iter().find(|(known, _)| *known == id).map(|(_, kind)| kind);
        let tree = match kind {
            Some("uav") => Ok(Outcome::Value(tree())),
            Some(_) => Ok(Outcome::Value(json!({ "type": "object" }))),
            None => Err("there is no such object".to_owned()),
        };
        parts.put(&id, tree);
    }
    Ok(parts.into_body())
}

/// The devices of a UAV. What values there are, [`World`](crate::server::world::World) says.
fn tree() -> Value {
    let channel = |kind: &str, unit: Option<&str>| {
        let mut node = json!({ "type": "channel", "subType": kind, "operations": ["read"] });
        if let Some(unit) = unit {
            node["unit"] = json!(unit);
        }
        node
    };
    let device =
        |class: &str, channels: Value| json!({ "type": "device", "class": class, "children": channels });
    let battery =
        json!({ "voltage": channel("number", Some("V")), "percentage": channel("number", Some("%")) });
    let gps = json!({ "satellites": channel("number", None), "position": channel("gps", None) });
    json!({
        "type": "object",
        "children": { "battery": device("battery", battery), "gps": device("gps", gps) },
    })
}

fn subscribe(hub: &mut Hub, call: &Call<'_>) -> Answer {
    boolean(call.body, "lazy", Some(false))?;
    let mut parts = Parts::new(call.kind, "success");
    for path in strings(call.body, "paths")? {
        let outcome = hub.world.values_at(&path).and_then(|_| add(hub, call.session, &path));
        parts.put(&path, outcome.map(|()| Outcome::Value(json!(true))));
    }
    Ok(parts.into_names())
}

fn add(hub: &mut Hub, session: SessionId, path: &str) -> Result<(), String> {
    let session = hub.session(session).ok_or("the connection has ended")?;
    if session.subscriptions.values().sum::<usize>() >= SUBSCRIPTION_LIMIT {
        return Err("too many subscriptions".to_owned());
    }
    *session.subscriptions.entry(path.to_owned()).or_default() += 1;
    Ok(())
}

fn unsubscribe(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let paths = strings(call.body, "paths")?;
    let is_for_all = boolean(call.body, "removeAll", Some(false))?;
    let has_subtrees = boolean(call.body, "includeSubtrees", Some(false))?;
    let session = hub.session(call.session).ok_or("the connection has ended")?;
    let mut parts = Parts::new(call.kind, "success");
    for path in paths {
        let is_meant = |known: &&String| **known == path || has_subtrees && is_below(known, &path);
        let found: Vec<String> = session.subscriptions.keys().filter(is_meant).cloned().collect();
        if found.is_empty() {
            parts.put(&path, Err("there is no such subscription".to_owned()));
        }
        for path in found {
            let left = session.subscriptions.get_mut(&path).map_or(0, |count| {
                *count -= 1;
                *count
            });
            if is_for_all || left == 0 {
                session.subscriptions.remove(&path);
                session.told.remove(&path);
            }
            parts.put(&path, Ok(Outcome::Value(json!(true))));
        }
    }
    Ok(parts.into_names())
}

fn subscriptions(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let filters = optional_strings(call.body, "pathFilter")?;
    let session = hub.session(call.session).ok_or("the connection has ended")?;
    let mut paths = Vec::new();
    for (path, count) in &session.subscriptions {
        let fits = filters.as_ref().map_or(1, |filters| {
            filters.iter().filter(|filter| path == *filter || is_below(path, filter)).count()
        });
        paths.extend(std::iter::repeat_n(path, count * fits));
        if paths.len() > SUBSCRIPTION_LIMIT {
            return Err("the filters fit too many subscriptions".to_owned());
        }
    }
    Ok(json!({ "type": call.kind, "paths": paths }))
}

/// Whether a path lies below another.
fn is_below(path: &str, above: &str) -> bool {
    let above = above.strip_suffix('/').unwrap_or(above);
    path.strip_prefix(above).is_some_and(|rest| rest.starts_with('/'))
}
