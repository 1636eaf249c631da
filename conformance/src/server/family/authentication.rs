//! AUTH: who is at the other end (`definitions/flockwave/auth.md`).

use data_encoding::BASE64;
use serde_json::{Value, json};

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::request::string;

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "AUTH-INF" => Ok(information(hub)),
        "AUTH-REQ" => log_in(hub, call),
        "AUTH-WHOAMI" => {
            let user = hub.session(call.session).and_then(|session| session.user.clone());
            Ok(json!({ "type": call.kind, "user": user.unwrap_or_default() }))
        }
        _ => Err(unknown(call)),
    }
}

fn information(hub: &Hub) -> Value {
    let is_required = hub.options.login.is_some();
    let methods: &[&str] = if is_required { &["basic"] } else { &[] };
    json!({ "type": "AUTH-INF", "methods": methods, "required": is_required })
}

fn log_in(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let (method, data) = (string(call.body, "method")?, string(call.body, "data")?);
    let failed = |reason: &str| json!({ "type": "AUTH-RESP", "result": false, "reason": reason });
    let Some((name, password)) = hub.options.login.clone() else {
        return Ok(failed("nobody needs to log in here"));
    };
    if method != "basic" {
        return Ok(failed("the only method is basic"));
    }
    let given = BASE64.decode(data.as_bytes()).unwrap_or_default();
    if given != format!("{name}:{password}").into_bytes() {
        return Ok(failed("wrong name or password"));
    }
    if let Some(session) = hub.session(call.session) {
        session.user = Some(name.clone());
    }
    Ok(json!({ "type": "AUTH-RESP", "result": true, "user": name }))
}
