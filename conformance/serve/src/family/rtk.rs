//! RTK: real-time kinematic corrections (`definitions/flockwave/rtk.md`).

use std::collections::BTreeMap;

use uavspec_types::flockwave::json::{
    CarrierToNoiseRatio, GPSCoordinate, Latitude, Longitude, RTKAntennaInfo, RTKConfigurationPreset,
    RTKMessageObservations, RTKPresetId, RTKPresetType, RTKSurveyStatus, Request, conn_inf, rtk_inf,
    rtk_list, rtk_source, rtk_stat, rtk_survey,
};

use super::connection::{CORRECTIONS, corrections};
use super::unknown;
use crate::hub::{Answer, Hub, SessionId};
use crate::message::{Outcomes, acknowledgment};
use crate::world::{PRESETS, Preset};

/// A message type, the age of its last message in milliseconds, and its rate in bits per second.
type Observations = (&'static str, i64, f64);

/// The received corrections.
const RECEIVED: [Observations; 2] = [("rtcm3/1005", 480, 160.0), ("rtcm3/1077", 120, 2400.0)];

/// The corrections sent to the UAVs.
const SENT: [Observations; 1] = [("rtcm3/1077", 150, 2400.0)];

/// The signal-to-noise ratios of satellites.
const RATIOS: [(&str, f64); 3] = [("G04", 44.5), ("G17", 39.0), ("E11", 41.0)];

pub(super) fn answer(hub: &mut Hub, _session: SessionId, request: Request) -> Answer {
    match request {
        Request::RtkList(_) => {
            let ids = PRESETS.map(|preset| RTKPresetId::from(preset.id)).into();
            Ok(rtk_list::Response { ids }.into())
        }
        Request::RtkInf(request) => {
            let (preset, error) = Outcomes::collect(request.ids, |id| find(id).map(describe))?.into_maps();
            Ok(rtk_inf::Response { preset, error }.into())
        }
        Request::RtkSource(request) => match request.id {
            Some(chosen) => choose(hub, chosen.as_deref()),
            None => {
                Ok(rtk_source::Response { id: hub.world.preset.map(|preset| preset.id.to_owned()) }.into())
            }
        },
        Request::RtkStat(_) => Ok(statistics(hub).into()),
        Request::RtkSurvey(request) => {
            if let Some(settings) = request.settings {
                hub.world.survey = settings;
            }
            Ok(rtk_survey::Response { settings: Some(hub.world.survey.clone()) }.into())
        }
        other => Err(unknown(&other)),
    }
}

fn find(id: &str) -> Result<&'static Preset, String> {
    PRESETS.iter().find(|preset| preset.id == id).ok_or_else(|| "no such preset".to_owned())
}

fn describe(preset: &Preset) -> RTKConfigurationPreset {
    RTKConfigurationPreset {
        title: preset.title.to_owned(),
        format: preset.format,
        sources: vec![preset.source.into()],
        r#type: Some(RTKPresetType::Builtin),
    }
}

/// Selects a preset, or none.
fn choose(hub: &mut Hub, id: Option<&str>) -> Answer {
    let chosen = id.map(find).transpose()?;
    let has_changed = hub.world.preset.is_some() != chosen.is_some();
    hub.world.preset = chosen;
    if has_changed {
        let status = BTreeMap::from([(CORRECTIONS.to_owned(), corrections(hub))]);
        hub.announce("CONN-INF", conn_inf::Notification { status: Some(status) }.into());
    }
    Ok(acknowledgment())
}

fn statistics(hub: &Hub) -> rtk_stat::Response {
    if hub.world.preset.is_none() {
        return rtk_stat::Response { messages_tx: Some(BTreeMap::new()), ..rtk_stat::Response::default() };
    }
    let position = GPSCoordinate {
        latitude: Latitude(504_980_500),
        longitude: Longitude(99_525_000),
        amsl: Some(908_000),
        ..GPSCoordinate::default()
    };
    rtk_stat::Response {
        antenna: RTKAntennaInfo {
            station_id: Some(Some(7.0)),
            descriptor: Some(Some("Mast".to_owned())),
            position: Some(Some(position)),
            ..RTKAntennaInfo::default()
        },
        messages: observations(&RECEIVED),
        messages_tx: Some(observations(&SENT)),
        cnr: RATIOS.map(|(satellite, ratio)| (satellite.to_owned(), CarrierToNoiseRatio(ratio))).into(),
        survey: RTKSurveyStatus { accuracy: 0.8, flags: 5 },
    }
}

fn observations(known: &[Observations]) -> BTreeMap<String, RTKMessageObservations> {
    let observed = |(kind, age, bitrate): &Observations| {
        (kind.to_string(), RTKMessageObservations { age: *age, bitrate: *bitrate })
    };
    known.iter().map(observed).collect()
}
