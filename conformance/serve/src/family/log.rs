//! LOG: flight logs (`definitions/flockwave/log.md`).

use uavspec_types::flockwave::json::{
    FlightLog, FlightLogBody, FlightLogMetadata, ReceiptId, Request, log_data, log_inf,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcome, Outcomes, value};
use crate::operation::Operation;

/// The id of the only log of each UAV.
const LOG: &str = "1";

/// The content of the log.
const TEXT: &str = "took off\nlanded\n";

/// The time that it takes to fetch a log, in seconds.
const FETCHING: f64 = 2.0;

pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    match request {
        Request::LogInf(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| match hub.uav(id) {
                Some(_) => Ok(Outcome::Value(vec![metadata()])),
                None => Err(no_such_uav()),
            })?;
            let (result, error, receipt) = outcomes.into_maps_with_receipts();
            Ok(log_inf::Response { result, error, receipt }.into())
        }
        Request::LogData(request) => Ok(match fetch(hub, session, &request) {
            Ok(receipt) => {
                log_data::Response { receipt: Some(ReceiptId(receipt)), ..log_data::Response::default() }
            }
            Err(error) => log_data::Response { error: Some(error), ..log_data::Response::default() },
        }
        .into()),
        other => Err(unknown(&other)),
    }
}

fn no_such_uav() -> String {
    "no such UAV".to_owned()
}

fn metadata() -> FlightLogMetadata {
    #[expect(clippy::cast_precision_loss, reason = "the length is small")]
    let size = TEXT.len() as f64;
    FlightLogMetadata { id: LOG.into(), kind: "text".to_owned(), timestamp: None, size: Some(size) }
}

/// Starts fetching a log, and returns the receipt.
fn fetch(hub: &mut Hub, session: SessionId, request: &log_data::Request) -> Result<String, String> {
    hub.uav(&request.uav_id.0).ok_or_else(no_such_uav)?;
    if request.log_id.0 != LOG {
        return Err("no such log".to_owned());
    }
    let FlightLogMetadata { id, kind, timestamp, size } = metadata();
    let log = FlightLog { id, kind, body: FlightLogBody::String(TEXT.to_owned()), timestamp, size };
    hub.start(session, |receipt| Operation::lasting(receipt, FETCHING, value(&log)))
}
