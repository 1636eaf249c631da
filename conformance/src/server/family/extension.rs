//! EXT: extensions of the server (`definitions/flockwave/ext.md`).

use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::request::{Body, object, strings};
use crate::server::world::Extension;

/// The longest configuration that is kept, in characters of JSON.
const CONFIGURATION_LIMIT: usize = 4096;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "EXT-LIST" => Ok(list(hub)),
        "EXT-CFG" => each(hub, call, |_, extension| Ok(Value::Object(extension.configuration.clone()))),
        "EXT-INF" => each(hub, call, |id, extension| {
            Ok(json!({ "id": id, "loaded": extension.is_loaded, "name": extension.name }))
        }),
        "EXT-LOAD" => each(hub, call, |_, extension| load(extension, true)),
        "EXT-UNLOAD" => each(hub, call, |id, extension| match id {
            "simulation" => Err("the server can't do without it".to_owned()),
            _ => load(extension, false),
        }),
        "EXT-RELOAD" => each(hub, call, |_, extension| {
            if extension.is_loaded { Ok(json!({})) } else { Err("it isn't loaded".to_owned()) }
        }),
        "EXT-SETCFG" => configure(hub, call),
        _ => Err(unknown(call)),
    }
}

fn list(hub: &Hub) -> Value {
    let extensions = &hub.world.extensions;
    let of = |is_loaded: bool| -> Vec<&str> {
        extensions
            .iter()
            .filter(|(_, extension)| extension.is_loaded == is_loaded)
            .map(|(id, _)| *id)
            .collect()
    };
    json!({ "type": "EXT-LIST", "loaded": of(true), "available": of(false) })
}

fn load(extension: &mut Extension, is_loaded: bool) -> Result<Value, String> {
    if extension.is_loaded == is_loaded {
        return Err(if is_loaded { "it is loaded" } else { "it isn't loaded" }.to_owned());
    }
    extension.is_loaded = is_loaded;
    Ok(json!({}))
}

fn each(
    hub: &mut Hub,
    call: &Call<'_>,
    act: impl Fn(&str, &mut Extension) -> Result<Value, String>,
) -> Answer {
    let mut parts = Parts::new(call.kind, "status");
    for id in strings(call.body, "ids")? {
        let extension = hub.world.extensions.get_mut(id.as_str());
        let outcome = extension.ok_or_else(no_such).and_then(|extension| act(&id, extension));
        parts.put(&id, outcome.map(Outcome::Value));
    }
    Ok(parts.into_body())
}

fn configure(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let mut parts = Parts::new(call.kind, "status");
    for (id, configuration) in object(call.body, "ids")?.ok_or("ids is missing")? {
        let configuration: &Body = configuration.as_object().ok_or("a configuration is no object")?;
        let is_long = Value::Object(configuration.clone()).to_string().len() > CONFIGURATION_LIMIT;
        let outcome = match hub.world.extensions.get_mut(id.as_str()) {
            None => Err(no_such()),
            Some(_) if is_long => Err(format!("more than {CONFIGURATION_LIMIT} characters")),
            Some(extension) => {
                extension.configuration.clone_from(configuration);
                Ok(Outcome::Value(json!({})))
            }
        };
        parts.put(id, outcome);
    }
    Ok(parts.into_body())
}

fn no_such() -> String {
    "there is no such extension".to_owned()
}
