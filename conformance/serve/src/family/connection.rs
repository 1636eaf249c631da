//! CONN: the server's connections to devices (`definitions/flockwave/conn.md`).

use uavspec_types::flockwave::json::{
    ConnectionId, ConnectionInfo, ConnectionPurpose, ConnectionStatus, Request, conn_inf, conn_list,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::Outcomes;

/// The radio link to the UAVs.
const RADIO: &str = "radio-1";

/// The connection to the RTK correction source.
pub(super) const CORRECTIONS: &str = "base-1";

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::ConnList(_) => {
            Ok(conn_list::Response { ids: [RADIO, CORRECTIONS].map(ConnectionId::from).into() }.into())
        }
        Request::ConnInf(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| match id {
                RADIO => Ok(radio(hub)),
                CORRECTIONS => Ok(corrections(hub)),
                _ => Err("no such connection".to_owned()),
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(conn_inf::Response { status, error }.into())
        }
        other => Err(unknown(&other)),
    }
}

fn radio(hub: &Hub) -> ConnectionInfo {
    connection(
        hub,
        RADIO,
        ConnectionPurpose::UavRadioLink,
        ConnectionStatus::Connected,
        "Simulated radio link",
    )
}

/// The state of the connection to the RTK correction source.
pub(super) fn corrections(hub: &Hub) -> ConnectionInfo {
    let is_used = hub.world.preset.is_some();
    let status = if is_used { ConnectionStatus::Connected } else { ConnectionStatus::Disconnected };
    connection(hub, CORRECTIONS, ConnectionPurpose::Dgps, status, "Simulated base station")
}

fn connection(
    hub: &Hub,
    id: &str,
    purpose: ConnectionPurpose,
    status: ConnectionStatus,
    description: &str,
) -> ConnectionInfo {
    let (description, timestamp) = (Some(description.to_owned()), Some(hub.timestamp()));
    ConnectionInfo { id: id.into(), purpose, status, description, timestamp }
}
