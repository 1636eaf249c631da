//! WTH: the weather (`definitions/flockwave/wth.md`).

use uavspec_types::flockwave::json::{
    GPSCoordinate, Heading, Latitude, Longitude, ObjectId, Percentage, Request, Temperature, Weather, wth_at,
    wth_inf, wth_list,
};

use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::Outcomes;

/// The id of the only weather station.
const STATION: &str = "wind-1";

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::WthList(_) => Ok(wth_list::Response { ids: vec![ObjectId::from(STATION)] }.into()),
        Request::WthAt(_) => Ok(wth_at::Response { weather: Some(weather(hub)) }.into()),
        Request::WthInf(request) => {
            let outcomes = Outcomes::collect(request.ids, |id| match id {
                STATION => Ok(weather(hub)),
                _ => Err("no such station".to_owned()),
            })?;
            let (status, error) = outcomes.into_maps();
            Ok(wth_inf::Response { status, error }.into())
        }
        other => Err(unknown(&other)),
    }
}

/// The weather, which is always fair.
fn weather(hub: &Hub) -> Weather {
    Weather {
        position: GPSCoordinate {
            latitude: Latitude(504_977_000),
            longitude: Longitude(99_512_000),
            amsl: Some(905_000),
            ..GPSCoordinate::default()
        },
        timestamp: hub.timestamp(),
        station_id: Some(STATION.into()),
        code: Some(801),
        temperature: Some(Temperature(2902)),
        pressure: Some(101_800),
        humidity: Some(Percentage(54)),
        wind_direction: Some(Heading(2350)),
        wind_speed: Some(3400),
        wind_gust: Some(5200),
        ..Weather::default()
    }
}
