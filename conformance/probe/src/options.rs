//! Options of a probe.

use std::time::Duration;

use uavspec_model::clock::Clock;
use uavspec_model::net::tls::Trust;

use super::selection::Selection;
use super::stop::Stop;
use super::{commands, landing, survey};

/// The time limit of a probe without commands, excluding the listening period.
const TIME_LIMIT: Duration = Duration::from_secs(45);

/// The default time for which a request may remain unanswered.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Options of a probe.
#[derive(Clone, Debug)]
pub struct Options {
    /// The time to listen for notifications.
    pub observe: Duration,
    /// Name and password for the login.
    pub login: Option<(String, String)>,
    /// The UAVs that may receive commands; empty if commands aren't allowed.
    pub uavs: Vec<String>,
    /// The time after which no further requests are sent, excluding [`observe`](Self::observe).
    pub limit: Duration,
    /// The time for which a request may remain unanswered. If the wait was shorter, there is no finding, because it
    /// proves nothing.
    pub timeout: Duration,
    /// A shell command that restarts the server after it has stopped serving.
    pub on_crash: Option<String>,
    /// The time within which an operation of a UAV must progress or end. If the wait was shorter, there is no finding,
    /// because it proves nothing.
    pub progress_timeout: Duration,
    /// The time within which the UAVs that may receive commands must appear.
    pub uav_timeout: Duration,
    /// The time limit for making the commanded UAVs safe. It applies in addition to all other limits.
    pub landing_limit: Duration,
    /// The certificates to trust in connections over TLS.
    pub trust: Trust,
    /// The rules, trials and message types to use.
    pub selection: Selection,
    /// Ends the probe early.
    pub stop: Stop,
    /// The clock by which the probe waits.
    pub clock: Clock,
    /// Receives warnings about UAVs that are not safe yet.
    pub warn: fn(&str),
}

impl Options {
    /// Options with the default time limit.
    pub fn new(observe: Duration, login: Option<(String, String)>, uavs: Vec<String>) -> Self {
        let limit = if uavs.is_empty() { TIME_LIMIT } else { TIME_LIMIT + commands::EXTRA_TIME };
        Self {
            observe,
            login,
            uavs,
            limit,
            timeout: TIMEOUT,
            on_crash: None,
            progress_timeout: commands::PROGRESS_TIMEOUT,
            uav_timeout: survey::NAMED_UAV_TIMEOUT,
            landing_limit: landing::LANDING_LIMIT,
            trust: Trust::default(),
            selection: Selection::default(),
            stop: Stop::default(),
            clock: Clock::real(),
            warn: |_| {},
        }
    }
}
