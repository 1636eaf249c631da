//! The Flockwave rules (`FW-…`), one per file, and the list of all rules.

mod ack_01;
mod ack_03;
mod ack_04;
pub mod ack_06;
mod asy_01;
mod asy_02;
mod asy_03;
pub mod asy_04;
pub mod asy_04i;
mod asy_06;
mod asy_07;
mod asy_08;
mod asy_09;
pub mod asy_10;
mod asy_10i;
mod asy_11;
mod asy_12;
mod asy_13;
pub mod asy_14;
mod asy_16;
pub mod asy_17;
pub mod asy_18;
pub mod asy_19;
mod asy_20;
mod asy_20j;
mod asy_22;
mod attribution;
mod auth_01;
mod body;
mod bug;
mod conn_inf_01;
mod conn_inf_02;
mod conn_inf_03;
mod dev_01;
mod env_01;
mod env_02;
mod env_02j;
mod env_03;
mod env_03j;
mod env_04;
mod env_05;
pub mod env_05i;
mod env_06;
pub mod env_07;
mod env_08;
mod env_09;
mod env_10;
mod env_11;
mod env_12;
mod env_12j;
pub(crate) mod env_13;
mod env_14;
mod env_15;
mod env_16;
mod env_17;
mod env_18;
pub mod env_19;
pub(crate) mod env_21;
pub mod env_22;
mod env_23;
pub mod env_24;
pub mod env_25;
mod env_26;
pub mod env_27;
mod err_01;
mod err_02;
mod err_03;
mod err_04;
mod err_06;
mod err_07;
mod err_08;
mod err_09;
mod err_10;
mod inf_01;
mod lines;
mod malformed;
mod mutant;
mod obj_del_01;
pub mod obj_del_02;
mod obj_list_01;
mod obj_list_01j;
pub mod obj_list_02;
pub mod obj_list_03;
pub mod obj_list_04;
mod per_connection;
mod prelude;
mod prm_01;
mod reply;
pub mod sample;
mod served;
pub mod sio_01;
pub mod sio_02;
pub mod sio_03;
mod source;
mod sys_close_01;
mod sys_close_02;
mod sys_msg_01;
mod sys_msg_02;
pub mod sys_ping_01;
mod sys_ping_02;
mod sys_ports_01;
mod sys_ports_02;
mod sys_time_01;
mod sys_time_02;
pub mod sys_time_03;
mod sys_ver_01;
mod sys_ver_02;
mod sys_ver_03;
mod sys_ver_04;
pub mod tcp_01;
pub mod tcp_02;
pub mod tcp_03;
pub mod tcp_04;
pub mod trial;
mod uav_inf_01;
mod uav_inf_02;
mod uav_inf_03;
mod uav_inf_04;
mod uav_inf_05;
pub mod uav_inf_06;
pub mod uav_inf_07;
mod uav_inf_08;
mod uav_inf_09;
pub mod uav_land_01;
mod uav_list_01;
mod uav_list_01j;
mod uav_list_02;
mod uav_list_03;
mod udp;
pub mod udp_01;
pub mod udp_02;
pub mod udp_03;
mod ust;
mod ust_attitude;
mod ust_battery;
mod ust_debug;
mod ust_errors;
mod ust_gps;
mod ust_heading;
mod ust_id;
mod ust_light;
mod ust_mode;
mod ust_position;
mod ust_positionxyz;
mod ust_rssi;
mod ust_timestamp;
mod ust_velocity;
mod ust_velocityxyz;
pub(crate) mod val_01;
mod view;
mod wth_01;

use uavspec_flockwave::session::Exchange;
use uavspec_model::{Location, Rule};

use self::attribution::Attribution;
pub use self::attribution::attributed;
use self::bug::Bug;
pub use self::bug::{Needs, Outgoing};
pub(crate) use self::mutant::Mutant;
pub use self::served::BEFORE_LOGIN;
pub use self::source::page;
use self::trial::Trial;
pub use self::trial::shown_by;
pub use self::val_01::plausible;
pub use self::view::{Message, StatusReport};
use super::RuleContext;

/// All Flockwave rules, sorted by id.
pub static RULES: [&FlockwaveRule; 135] = [
    &ack_01::RULE,
    &ack_03::RULE,
    &ack_04::RULE,
    &ack_06::RULE,
    &asy_01::RULE,
    &asy_02::RULE,
    &asy_03::RULE,
    &asy_04::RULE,
    &asy_04i::RULE,
    &asy_06::RULE,
    &asy_07::RULE,
    &asy_08::RULE,
    &asy_09::RULE,
    &asy_10::RULE,
    &asy_10i::RULE,
    &asy_11::RULE,
    &asy_12::RULE,
    &asy_13::RULE,
    &asy_14::RULE,
    &asy_16::RULE,
    &asy_17::RULE,
    &asy_18::RULE,
    &asy_19::RULE,
    &asy_20::RULE,
    &asy_20j::RULE,
    &asy_22::RULE,
    &auth_01::RULE,
    &conn_inf_01::RULE,
    &conn_inf_02::RULE,
    &conn_inf_03::RULE,
    &dev_01::RULE,
    &env_01::RULE,
    &env_02::RULE,
    &env_02j::RULE,
    &env_03::RULE,
    &env_03j::RULE,
    &env_04::RULE,
    &env_05::RULE,
    &env_05i::RULE,
    &env_06::RULE,
    &env_07::RULE,
    &env_08::RULE,
    &env_09::RULE,
    &env_10::RULE,
    &env_11::RULE,
    &env_12::RULE,
    &env_12j::RULE,
    &env_13::RULE,
    &env_14::RULE,
    &env_15::RULE,
    &env_16::RULE,
    &env_17::RULE,
    &env_18::RULE,
    &env_19::RULE,
    &env_21::RULE,
    &env_22::RULE,
    &env_23::RULE,
    &env_24::RULE,
    &env_25::RULE,
    &env_26::RULE,
    &env_27::RULE,
    &err_01::RULE,
    &err_02::RULE,
    &err_03::RULE,
    &err_04::RULE,
    &err_06::RULE,
    &err_07::RULE,
    &err_08::RULE,
    &err_09::RULE,
    &err_10::RULE,
    &inf_01::RULE,
    &obj_del_01::RULE,
    &obj_del_02::RULE,
    &obj_list_01::RULE,
    &obj_list_01j::RULE,
    &obj_list_02::RULE,
    &obj_list_03::RULE,
    &obj_list_04::RULE,
    &prm_01::RULE,
    &sio_01::RULE,
    &sio_02::RULE,
    &sio_03::RULE,
    &sys_close_01::RULE,
    &sys_close_02::RULE,
    &sys_msg_01::RULE,
    &sys_msg_02::RULE,
    &sys_ping_01::RULE,
    &sys_ping_02::RULE,
    &sys_ports_01::RULE,
    &sys_ports_02::RULE,
    &sys_time_01::RULE,
    &sys_time_02::RULE,
    &sys_time_03::RULE,
    &sys_ver_01::RULE,
    &sys_ver_02::RULE,
    &sys_ver_03::RULE,
    &sys_ver_04::RULE,
    &tcp_01::RULE,
    &tcp_02::RULE,
    &tcp_03::RULE,
    &tcp_04::RULE,
    &uav_inf_01::RULE,
    &uav_inf_02::RULE,
    &uav_inf_03::RULE,
    &uav_inf_04::RULE,
    &uav_inf_05::RULE,
    &uav_inf_06::RULE,
    &uav_inf_07::RULE,
    &uav_inf_08::RULE,
    &uav_inf_09::RULE,
    &uav_land_01::RULE,
    &uav_list_01::RULE,
    &uav_list_01j::RULE,
    &uav_list_02::RULE,
    &uav_list_03::RULE,
    &udp_01::RULE,
    &udp_02::RULE,
    &udp_03::RULE,
    &ust_attitude::RULE,
    &ust_battery::RULE,
    &ust_debug::RULE,
    &ust_errors::RULE,
    &ust_gps::RULE,
    &ust_heading::RULE,
    &ust_id::RULE,
    &ust_light::RULE,
    &ust_mode::RULE,
    &ust_position::RULE,
    &ust_positionxyz::RULE,
    &ust_rssi::RULE,
    &ust_timestamp::RULE,
    &ust_velocity::RULE,
    &ust_velocityxyz::RULE,
    &val_01::RULE,
    &wth_01::RULE,
];

/// Finds a rule by its id.
pub fn rule(id: &str) -> Option<&'static FlockwaveRule> {
    RULES.binary_search_by_key(&id, |rule| rule.rule.id).ok().map(|at| RULES[at])
}

/// A Flockwave rule.
#[derive(Debug)]
pub struct FlockwaveRule {
    /// The text and the level of the rule.
    pub rule: Rule,
    /// The code that finds violations.
    pub checks: &'static [Check],
    /// The body schema violations that the rule reports in place of `FW-ENV-18`.
    pub(crate) covers: &'static [Attribution],
    /// The reference server bug that violates the rule.
    pub bug: Bug,
    /// The probe requests that test the rule. A rule without a trial is checked in the probe's survey and in any other
    /// session.
    pub(crate) trial: Option<Trial>,
    /// Captures that violate the rule.
    pub(crate) mutants: &'static [Mutant],
}

impl FlockwaveRule {
    /// Creates a rule from its text. The other functions set its checks, its bug and its mutants, which each rule needs,
    /// and its attributions and its trial, which few rules have.
    const fn new(rule: Rule) -> Self {
        Self { rule, checks: &[], covers: &[], bug: Bug::behaviour(""), trial: None, mutants: &[] }
    }

    /// Sets the code that finds violations.
    const fn checks(self, checks: &'static [Check]) -> Self {
        Self { checks, ..self }
    }

    /// Sets the body schema violations that the rule reports in place of `FW-ENV-18`.
    const fn covers(self, covers: &'static [Attribution]) -> Self {
        Self { covers, ..self }
    }

    /// Sets the reference server bug that violates the rule.
    const fn bug(self, bug: Bug) -> Self {
        Self { bug, ..self }
    }

    /// Sets the probe requests that test the rule.
    const fn trial(self, trial: Trial) -> Self {
        Self { trial: Some(trial), ..self }
    }

    /// Sets the captures that violate the rule.
    const fn mutants(self, mutants: &'static [Mutant]) -> Self {
        Self { mutants, ..self }
    }
}

/// A check of a rule. The kind of check determines the input.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// Checks a single message from the server.
    Message(fn(&Message<'_>, &mut RuleContext<'_>)),
    /// Checks any record except a status report, together with the record's request and operations.
    Exchange(fn(&Exchange<'_>, &mut RuleContext<'_>)),
    /// Checks a status report in the context of its session.
    StatusReport(fn(&StatusReport<'_>, &mut RuleContext<'_>)),
    /// Checks the whole session and keeps state.
    Session(fn() -> Box<dyn SessionCheck>),
}

/// A check that keeps state across a session.
pub trait SessionCheck {
    /// Processes a record that is not a status report.
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>);

    /// Processes a status report.
    fn status_report(&mut self, _report: &StatusReport<'_>, _context: &mut RuleContext<'_>) {}

    /// Handles unreadable data, which may have contained records.
    fn corruption(&mut self, _location: Location) {}

    /// Handles the end of the session.
    fn end(&mut self, _context: &mut RuleContext<'_>) {}
}
