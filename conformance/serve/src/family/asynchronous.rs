//! ASYNC: pending operations (`definitions/flockwave/async.md`).

use uavspec_rules::flockwave::{asy_17, asy_18, asy_19};
use uavspec_types::flockwave::json::{Request, async_cancel, async_resume};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::Outcomes;
use crate::operation::Operation;

pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    match request {
        Request::AsyncCancel(request) => cancel(hub, session, request),
        Request::AsyncResume(request) => resume(hub, session, request),
        other => Err(unknown(&other)),
    }
}

fn cancel(hub: &mut Hub, session: SessionId, request: async_cancel::Request) -> Answer {
    let (is_forgetting, is_pretending) = (hub.has_bug(&asy_17::RULE), hub.has_bug(&asy_18::RULE));
    let outcomes = Outcomes::collect(request.ids, |receipt| {
        match hub.operation(session, receipt) {
            Some(operation) if !is_forgetting => operation.cancel(),
            None if !is_pretending => return Err("no such operation".to_owned()),
            _ => {}
        }
        Ok(())
    })?;
    let (success, error) = outcomes.into_list();
    Ok(async_cancel::Response { success, error }.into())
}

fn resume(hub: &mut Hub, session: SessionId, request: async_resume::Request) -> Answer {
    let is_lenient = hub.has_bug(&asy_19::RULE);
    let outcomes = Outcomes::collect(request.ids, |receipt| {
        match hub.operation(session, receipt).map(Operation::resume) {
            Some(was_suspended) if was_suspended || is_lenient => Ok(()),
            Some(_) => Err("the operation isn't suspended".to_owned()),
            None => Err("no such operation".to_owned()),
        }
    })?;
    let (success, error) = outcomes.into_list();
    Ok(async_resume::Response { success, error }.into())
}
