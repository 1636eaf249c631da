//! ASYNC: operations that are under way (`definitions/flockwave/async.md`).

use serde_json::json;

use super::unknown;
use crate::server::hub::{Answer, Call, Hub};
use crate::server::message::{Outcome, Parts};
use crate::server::operation::Operation;
use crate::server::request::{object, strings};

pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "ASYNC-CANCEL" => cancel(hub, call),
        "ASYNC-RESUME" => resume(hub, call),
        _ => Err(unknown(call)),
    }
}

fn cancel(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let (is_forgetting, is_pretending) = (hub.breaks("FW-ASY-17"), hub.breaks("FW-ASY-18"));
    let mut parts = Parts::new(call.kind, "success");
    for receipt in strings(call.body, "ids")? {
        let outcome = match hub.operation(call.session, &receipt) {
            Some(operation) => {
                if !is_forgetting {
                    operation.cancel();
                }
                Ok(Outcome::Value(json!(true)))
            }
            None if is_pretending => Ok(Outcome::Value(json!(true))),
            None => Err("no such operation is under way".to_owned()),
        };
        parts.put(&receipt, outcome);
    }
    Ok(parts.into_names())
}

fn resume(hub: &mut Hub, call: &Call<'_>) -> Answer {
    object(call.body, "values")?;
    let is_lenient = hub.breaks("FW-ASY-19");
    let mut parts = Parts::new(call.kind, "success");
    for receipt in strings(call.body, "ids")? {
        let was_suspended = hub.operation(call.session, &receipt).map(Operation::resume);
        let outcome = match was_suspended {
            Some(was_suspended) if was_suspended || is_lenient => Ok(Outcome::Value(json!(true))),
            Some(_) => Err("the operation isn't suspended".to_owned()),
            None => Err("no such operation is under way".to_owned()),
        };
        parts.put(&receipt, outcome);
    }
    Ok(parts.into_names())
}
