//! AUTH: authentication (`definitions/flockwave/auth.md`).

use data_encoding::BASE64;
use uavspec_types::flockwave::json::{
    AuthenticationMethod, Request, auth_inf, auth_req, auth_resp, auth_whoami,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};

pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    match request {
        Request::AuthInf(_) => Ok(information(hub).into()),
        Request::AuthReq(request) => Ok(log_in(hub, session, &request).into()),
        Request::AuthWhoami(_) => {
            let user = hub.session(session).and_then(|session| session.user.clone());
            Ok(auth_whoami::Response { user: user.unwrap_or_default() }.into())
        }
        other => Err(unknown(&other)),
    }
}

fn information(hub: &Hub) -> auth_inf::Response {
    let required = hub.options.login.is_some();
    let methods = if required { vec![AuthenticationMethod::Basic] } else { Vec::new() };
    auth_inf::Response { methods, required }
}

fn log_in(hub: &mut Hub, session: SessionId, request: &auth_req::Request) -> auth_resp::Response {
    let failed = |reason: &str| auth_resp::Response {
        result: Some(false),
        reason: Some(reason.to_owned()),
        ..auth_resp::Response::default()
    };
    let Some((name, password)) = hub.options.login.clone() else {
        return failed("this server requires no login");
    };
    // Over HTTP, each request may contain the login.
    if hub.session(session).is_some_and(|session| session.user.is_some()) {
        return failed("already authenticated");
    }
    if request.method != AuthenticationMethod::Basic {
        return failed("unsupported method; expected basic");
    }
    let given = BASE64.decode(request.data.as_bytes()).unwrap_or_default();
    if given != format!("{name}:{password}").into_bytes() {
        return failed("wrong name or password");
    }
    if let Some(session) = hub.session(session) {
        session.user = Some(name.clone());
    }
    auth_resp::Response { result: Some(true), user: Some(name), ..auth_resp::Response::default() }
}
