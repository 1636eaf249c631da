//! The state of the drone show.

use uavspec_types::flockwave::json::{
    DroneLightsConfiguration, DroneShowConfiguration, LightEffect, StartConditions, StartMethod,
};

/// The configurations of the show.
pub(super) struct Show {
    pub(super) start: DroneShowConfiguration,
    pub(super) lights: DroneLightsConfiguration,
}

impl Default for Show {
    fn default() -> Self {
        let start = StartConditions {
            authorized: false,
            clock: None,
            time: None,
            method: StartMethod::Rc,
            uav_ids: Vec::new(),
            authorization_scope: None,
        };
        Self {
            start: DroneShowConfiguration { start, mapping: None, duration: None },
            lights: DroneLightsConfiguration { effect: Some(LightEffect::Off), color: None },
        }
    }
}
