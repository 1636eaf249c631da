//! SYS: the server itself (`definitions/flockwave/sys.md`).

use std::collections::BTreeMap;

use uavspec_rules::flockwave::sys_time_03;
use uavspec_types::flockwave::json::{PortNumber, Request, clk_inf, sys_ports, sys_time, sys_ver};

use super::{clock, unknown};
use crate::hub::{Answer, Hub, SessionId};
use crate::message::acknowledgment;

/// The maximum total adjustment of the clock, in milliseconds: a hundred years.
const ADJUSTMENT_LIMIT: u64 = 100 * 365 * 86_400_000;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::SysPing(_) => Ok(acknowledgment()),
        Request::SysPorts(_) => {
            let ports = hub.ports.iter().map(|(name, port)| ((*name).to_owned(), PortNumber((*port).into())));
            Ok(sys_ports::Response { ports: ports.collect() }.into())
        }
        Request::SysTime(request) => {
            request.adjustment.map(|adjustment| adjust(hub, adjustment)).transpose()?;
            Ok(sys_time::Response { timestamp: hub.timestamp() }.into())
        }
        Request::SysVer(_) => Ok(sys_ver::Response {
            software: "uavspec".to_owned(),
            version: env!("CARGO_PKG_VERSION").into(),
            ..sys_ver::Response::default()
        }
        .into()),
        other => Err(unknown(&other)),
    }
}

fn adjust(hub: &mut Hub, adjustment: f64) -> Result<(), String> {
    if hub.has_bug(&sys_time_03::RULE) && adjustment == 0.0 {
        hub.adjustment += 3_600_000;
    }
    if adjustment < 0.0 {
        // After a negative adjustment, UAV timestamps would be in the future or go backwards.
        return Err("a negative adjustment isn't supported".to_owned());
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
    let adjusted = hub.adjustment.saturating_add(adjustment.round() as u64);
    if adjusted > ADJUSTMENT_LIMIT {
        return Err("the adjustment is too large".to_owned());
    }
    if adjusted != hub.adjustment {
        hub.adjustment = adjusted;
        let status = BTreeMap::from([(clock::SYSTEM.to_owned(), clock::system(hub))]);
        hub.announce("CLK-INF", clk_inf::Notification { status: Some(status) }.into());
    }
    Ok(())
}
