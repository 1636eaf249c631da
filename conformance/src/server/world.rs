//! What there is beside the connections: UAVs, and all else that clients ask about.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::Options;
use super::request::Body;
use super::uav::Uav;

/// Everything that the server simulates or pretends to have.
pub(super) struct World {
    pub(super) uavs: Vec<Uav>,
    /// The last code of each UAV that people were told about.
    remarked: BTreeMap<String, u16>,
    /// The RTK preset in use.
    pub(super) preset: Option<&'static Preset>,
    /// How the base station surveys.
    pub(super) survey: Body,
    /// Extensions by id.
    pub(super) extensions: BTreeMap<&'static str, Extension>,
    /// Parameters of UAVs, by UAV and name, where they were changed.
    pub(super) parameters: BTreeMap<(String, &'static str), Value>,
}

/// An RTK preset.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Preset {
    pub(super) id: &'static str,
    pub(super) title: &'static str,
    pub(super) format: &'static str,
    pub(super) source: &'static str,
}

/// The presets that there are.
pub(super) const PRESETS: [Preset; 2] = [
    Preset { id: "base", title: "Base station on the hill", format: "rtcm3", source: "serial:base" },
    Preset { id: "network", title: "Network of stations", format: "auto", source: "ntrip:network" },
];

/// An extension.
pub(super) struct Extension {
    pub(super) is_loaded: bool,
    pub(super) name: &'static str,
    pub(super) configuration: Body,
}

/// An object that is no UAV: its id, type and name.
pub(super) const FIXTURES: [(&str, &str, &str); 4] = [
    ("mark-1", "beacon", "Start of the runway"),
    ("mark-2", "beacon", "End of the runway"),
    ("hangar-1", "dock", "Hangar"),
    ("wind-1", "weatherStation", "Windsock"),
];

/// Parameters that each UAV has, and their values where nobody has changed them.
pub(super) const PARAMETERS: [(&str, i64); 3] =
    [("CRUISE_SPEED", 8), ("RTH_ALTITUDE", 10), ("LIGHT_MODE", 1)];

/// Something that people should know of a UAV.
pub(super) struct Remark {
    uav: String,
    code: u16,
}

impl Remark {
    /// The item of a message to people.
    pub(super) fn to_item(&self, now: u64) -> Value {
        let severity = match (self.code & 0xFF) >> 6 {
            1 => "warning",
            2 => "error",
            _ => "critical",
        };
        let message = format!("error code {}", self.code);
        json!({ "message": message, "severity": severity, "sender": self.uav, "timestamp": now })
    }
}

impl World {
    pub(super) fn new(options: &Options) -> Self {
        let mut uavs: Vec<Uav> = (0..options.uavs)
            .map(|number| Uav::new(number, options.charge, options.seed, options.start))
            .collect();
        for (id, code) in &options.errors {
            if let Some(uav) = uavs.iter_mut().find(|uav| uav.id == *id) {
                uav.set_error(*code);
            }
        }
        let extension = |is_loaded, name| Extension { is_loaded, name, configuration: Body::new() };
        Self {
            uavs,
            remarked: BTreeMap::new(),
            preset: None,
            survey: Body::new(),
            extensions: BTreeMap::from([
                ("simulation", extension(true, "Simulated fleet")),
                ("weather", extension(true, "Windsock")),
                ("show", extension(false, "Lights at night")),
            ]),
            parameters: BTreeMap::new(),
        }
    }

    /// All objects, with their types.
    pub(super) fn objects(&self) -> Vec<(&str, &str)> {
        let uavs = self.uavs.iter().map(|uav| (uav.id.as_str(), "uav"));
        uavs.chain(FIXTURES.iter().map(|(id, kind, _)| (*id, *kind))).collect()
    }

    /// The values of the devices of a UAV.
    pub(super) fn values(uav: &Uav) -> Value {
        let [latitude, longitude, above_sea, _, above_ground] = uav.coordinates();
        #[expect(clippy::cast_precision_loss, reason = "a few hundred")]
        let voltage = uav.voltage() as f64 / 10.0;
        json!({
            "battery": { "voltage": voltage, "percentage": uav.percentage() },
            "gps": {
                "satellites": uav.gps().1,
                "position": [latitude, longitude, above_sea, above_ground],
            },
        })
    }

    /// What stands at a path of the device tree.
    pub(super) fn values_at(&self, path: &str) -> Result<Value, String> {
        let path = path.strip_prefix('/').ok_or("a path begins with a slash")?;
        if path.is_empty() {
            let all = self.uavs.iter().map(|uav| (uav.id.clone(), Self::values(uav)));
            return Ok(Value::Object(all.collect()));
        }
        let mut parts = path.split('/');
        let id = parts.next().unwrap_or_default();
        let uav = self.uavs.iter().find(|uav| uav.id == id);
        let Some(uav) = uav else {
            let is_fixture = FIXTURES.iter().any(|(known, ..)| *known == id) && parts.next().is_none();
            return if is_fixture { Ok(json!({})) } else { Err("there is no such object".to_owned()) };
        };
        let mut value = Self::values(uav);
        for part in parts {
            value = value.get_mut(part).map(Value::take).ok_or("there is no such device or channel")?;
        }
        Ok(value)
    }

    /// What people should know and weren't told.
    pub(super) fn remarks(&mut self) -> Vec<Remark> {
        let mut remarks = Vec::new();
        for uav in &self.uavs {
            let worst =
                uav.codes().into_iter().filter(|code| (code & 0xFF) >= 64).max_by_key(|code| code & 0xFF);
            let before = match worst {
                Some(code) => self.remarked.insert(uav.id.clone(), code),
                None => self.remarked.remove(&uav.id),
            };
            if let Some(code) = worst.filter(|_| before != worst) {
                remarks.push(Remark { uav: uav.id.clone(), code });
            }
        }
        remarks
    }
}
