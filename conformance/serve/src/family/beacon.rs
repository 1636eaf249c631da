//! BCN: beacons (`definitions/flockwave/bcn.md`).

use uavspec_types::flockwave::json::{
    BeaconBasicProperties, BeaconStatusInfo, GPSCoordinate, Latitude, Longitude, ObjectType, Request,
    Timestamp, bcn_inf, bcn_props,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcome, Outcomes};
use crate::world::FIXTURES;

/// The position of the first beacon; the others are north of it.
const POSITION: (Latitude, Longitude) = (Latitude(504_975_000), Longitude(99_510_000));

/// The distance between beacons, in 1e-7 degrees of latitude.
const DISTANCE: i64 = 30_000;

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::BcnInf(request) => {
            let now = hub.timestamp();
            let outcomes = Outcomes::collect(request.ids, |id| Ok(status(id, find(id)?.0, now)))?;
            let (status, error) = outcomes.into_maps();
            Ok(bcn_inf::Response { status, error }.into())
        }
        Request::BcnProps(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| {
                let name = find(id)?.1.to_owned();
                Ok(Outcome::Value(BeaconBasicProperties { id: id.into(), name }))
            })?;
            let (result, error, receipt) = outcomes.into_maps_with_receipts();
            Ok(bcn_props::Response { result, error, receipt }.into())
        }
        other => Err(unknown(&other)),
    }
}

/// The number and the name of a beacon.
fn find(id: &str) -> Result<(i64, &'static str), String> {
    let mut beacons = FIXTURES.iter().filter(|fixture| fixture.kind == ObjectType::Beacon).zip(0..);
    let found = beacons.find(|(fixture, _)| fixture.id == id);
    let (fixture, number) = found.ok_or("no such beacon")?;
    Ok((number, fixture.name))
}

fn status(id: &str, number: i64, timestamp: Timestamp) -> BeaconStatusInfo {
    let (Latitude(latitude), longitude) = POSITION;
    let latitude = Latitude(latitude + number * DISTANCE);
    BeaconStatusInfo {
        id: id.into(),
        timestamp,
        position: Some(GPSCoordinate { latitude, longitude, ..GPSCoordinate::default() }),
        heading: None,
        active: Some(true),
    }
}
