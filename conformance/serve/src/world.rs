//! The simulated world: UAVs and all other objects.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use uavspec_runtime::Severity;
use uavspec_types::flockwave::ErrorCode;
use uavspec_types::flockwave::json::{
    LogMessage, LogSeverity, ObjectType, RTKMessageFormat, RTKSurveySettings, Timestamp,
};

use super::Options;
use super::show::Show;
use super::uav::Uav;

/// All objects of the simulated world.
pub(super) struct World {
    pub(super) uavs: Vec<Uav>,
    /// The UAVs that haven't appeared yet.
    hidden: Vec<Uav>,
    /// The most recently reported error code of each UAV.
    reported: BTreeMap<String, ErrorCode>,
    /// The RTK preset in use.
    pub(super) preset: Option<&'static Preset>,
    /// The base station survey settings.
    pub(super) survey: RTKSurveySettings,
    /// The configurations of the show.
    pub(super) show: Show,
    /// Extensions by id.
    pub(super) extensions: BTreeMap<&'static str, Extension>,
    /// Changed parameters of UAVs, by UAV and name.
    pub(super) parameters: BTreeMap<(String, &'static str), Value>,
}

/// An RTK preset.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Preset {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) format: RTKMessageFormat,
    pub(super) source: &'static str,
}

/// All presets.
pub(super) const PRESETS: [Preset; 2] = [
    Preset {
        id: "base",
        title: "Base station on the hill",
        format: RTKMessageFormat::Rtcm3,
        source: "serial:base",
    },
    Preset {
        id: "network",
        title: "Network of stations",
        format: RTKMessageFormat::Auto,
        source: "ntrip:network",
    },
];

/// An extension.
pub(super) struct Extension {
    pub(super) is_loaded: bool,
    pub(super) name: &'static str,
    pub(super) configuration: BTreeMap<String, Value>,
}

/// An object other than a UAV.
pub(super) struct Fixture {
    pub(super) id: &'static str,
    pub(super) kind: ObjectType,
    pub(super) name: &'static str,
}

/// All objects other than UAVs.
pub(super) const FIXTURES: [Fixture; 4] = [
    Fixture { id: "mark-1", kind: ObjectType::Beacon, name: "Start of the runway" },
    Fixture { id: "mark-2", kind: ObjectType::Beacon, name: "End of the runway" },
    Fixture { id: "hangar-1", kind: ObjectType::Dock, name: "Hangar" },
    Fixture { id: "wind-1", kind: ObjectType::WeatherStation, name: "Windsock" },
];

/// The parameters of each UAV, and their defaults.
pub(super) const PARAMETERS: [(&str, i64); 3] =
    [("CRUISE_SPEED", 8), ("RTH_ALTITUDE", 10), ("LIGHT_MODE", 1)];

/// A UAV error code to report to clients.
pub(super) struct Remark {
    uav: String,
    code: ErrorCode,
}

impl Remark {
    /// The item of a SYS-MSG notification.
    pub(super) fn to_item(&self, now: Timestamp) -> LogMessage {
        let severity = match self.code.severity() {
            Severity::Informational => LogSeverity::Info,
            Severity::Warning => LogSeverity::Warning,
            Severity::Error => LogSeverity::Error,
            Severity::Fatal => LogSeverity::Critical,
        };
        LogMessage {
            message: format!("error code {}", self.code),
            severity: Some(severity),
            sender: Some(self.uav.as_str().into()),
            timestamp: Some(now),
        }
    }
}

impl World {
    pub(super) fn new(options: &Options) -> Self {
        let mut uavs: Vec<Uav> = (0..options.uavs)
            .map(|number| Uav::new(number, options.charge, options.seed, options.start))
            .collect();
        for (id, code) in &options.errors {
            if let Some(uav) = uavs.iter_mut().find(|uav| uav.id == *id) {
                uav.set_errors(&[ErrorCode((*code).into())]);
            }
        }
        let is_late = |uav: &mut Uav| options.appearances.iter().any(|(id, _)| *id == uav.id);
        let hidden: Vec<Uav> = uavs.extract_if(.., is_late).collect();
        let extension = |is_loaded, name| Extension { is_loaded, name, configuration: BTreeMap::new() };
        Self {
            uavs,
            hidden,
            reported: BTreeMap::new(),
            preset: None,
            survey: RTKSurveySettings { duration: 60.0, accuracy: 1.0, ..RTKSurveySettings::default() },
            show: Show::default(),
            extensions: BTreeMap::from([
                ("simulation", extension(true, "Simulated fleet")),
                ("weather", extension(true, "Windsock")),
                ("show", extension(false, "Lights at night")),
            ]),
            parameters: BTreeMap::new(),
        }
    }

    /// Makes a UAV appear.
    pub(super) fn appear(&mut self, id: &str) {
        self.uavs.extend(self.hidden.extract_if(.., |uav| uav.id == id));
    }

    /// All objects, with their types.
    pub(super) fn objects(&self) -> impl Iterator<Item = (&str, ObjectType)> {
        let uavs = self.uavs.iter().map(|uav| (uav.id.as_str(), ObjectType::Uav));
        uavs.chain(FIXTURES.map(|fixture| (fixture.id, fixture.kind)))
    }

    /// The values of the devices of a UAV.
    pub(super) fn values(uav: &Uav) -> Value {
        let [latitude, longitude, above_sea, _, above_ground] = uav.coordinates();
        #[expect(clippy::cast_precision_loss, reason = "the value is at most a few hundred")]
        let voltage = uav.voltage() as f64 / 10.0;
        json!({
            "battery": { "voltage": voltage, "percentage": uav.percentage() },
            "gps": {
                "satellites": uav.satellites(),
                "position": [latitude, longitude, above_sea, above_ground],
            },
        })
    }

    /// The values at a path of the device tree.
    pub(super) fn values_at(&self, path: &str) -> Result<Value, String> {
        let path = path.strip_prefix('/').ok_or("a path must begin with a slash")?;
        if path.is_empty() {
            let all = self.uavs.iter().map(|uav| (uav.id.clone(), Self::values(uav)));
            return Ok(Value::Object(all.collect()));
        }
        let mut parts = path.split('/');
        let id = parts.next().unwrap_or_default();
        let uav = self.uavs.iter().find(|uav| uav.id == id);
        let Some(uav) = uav else {
            let is_fixture = FIXTURES.iter().any(|fixture| fixture.id == id) && parts.next().is_none();
            return if is_fixture { Ok(json!({})) } else { Err("no such object".to_owned()) };
        };
        let mut value = Self::values(uav);
        for part in parts {
            value = value.get_mut(part).map(Value::take).ok_or("no such device or channel")?;
        }
        Ok(value)
    }

    /// Error codes that have changed since the last call.
    pub(super) fn remarks(&mut self) -> Vec<Remark> {
        let mut remarks = Vec::new();
        for uav in &self.uavs {
            let codes = uav.codes().into_iter().filter(|code| code.severity() > Severity::Informational);
            let worst = codes.max_by_key(|code| (code.severity(), *code));
            let before = match worst {
                Some(code) => self.reported.insert(uav.id.clone(), code),
                None => self.reported.remove(&uav.id),
            };
            if let Some(code) = worst.filter(|_| before != worst) {
                remarks.push(Remark { uav: uav.id.clone(), code });
            }
        }
        remarks
    }
}
