//! The rules, a file each, and the one list of all.
//!
//! A rule is a statement with a permanent id. Rules on single values are checked by a plan that is made once
//! for each format ([`crate::plan`], and for JSON [`crate::json`]); rules on the course of things keep a state of their own ([`Checker`]).

mod fw;
mod fw_ack_01;
mod fw_ack_03;
mod fw_ack_04;
mod fw_ack_06;
mod fw_asy_01;
mod fw_asy_02;
mod fw_asy_03;
mod fw_asy_04;
mod fw_asy_04i;
mod fw_asy_06;
mod fw_asy_07;
mod fw_asy_08;
mod fw_asy_09;
mod fw_asy_10;
mod fw_asy_11;
mod fw_asy_12;
mod fw_asy_13;
mod fw_asy_14;
mod fw_asy_16;
mod fw_asy_17;
mod fw_asy_18;
mod fw_asy_19;
mod fw_asy_20;
mod fw_asy_20j;
mod fw_asy_22;
mod fw_auth_01;
mod fw_conn_inf_01;
mod fw_conn_inf_02;
mod fw_conn_inf_03;
mod fw_dev_01;
mod fw_env_01;
mod fw_env_02;
mod fw_env_02j;
mod fw_env_03;
mod fw_env_03j;
mod fw_env_04;
mod fw_env_05;
mod fw_env_06;
mod fw_env_07;
mod fw_env_08;
mod fw_env_09;
mod fw_env_10;
mod fw_env_11;
mod fw_env_12;
mod fw_env_13;
mod fw_env_14;
mod fw_env_15;
mod fw_env_16;
mod fw_env_17;
mod fw_env_18;
mod fw_env_19;
mod fw_env_22;
mod fw_env_23;
mod fw_env_24;
mod fw_env_25;
mod fw_err_01;
mod fw_err_02;
mod fw_err_03;
mod fw_err_04;
mod fw_err_06;
mod fw_err_07;
mod fw_err_08;
mod fw_err_09;
mod fw_err_10;
mod fw_inf_01;
mod fw_obj_del_01;
mod fw_obj_del_02;
mod fw_obj_list_01;
mod fw_obj_list_01j;
mod fw_obj_list_02;
mod fw_obj_list_03;
mod fw_obj_list_04;
mod fw_prm_01;
mod fw_sys_close_01;
mod fw_sys_close_02;
mod fw_sys_msg_01;
mod fw_sys_msg_02;
mod fw_sys_ping_01;
mod fw_sys_ping_02;
mod fw_sys_ports_01;
mod fw_sys_ports_02;
mod fw_sys_time_01;
mod fw_sys_time_02;
mod fw_sys_time_03;
mod fw_sys_ver_01;
mod fw_sys_ver_02;
mod fw_sys_ver_03;
mod fw_sys_ver_04;
mod fw_tcp_01;
mod fw_trials;
mod fw_uav_inf_01;
mod fw_uav_inf_02;
mod fw_uav_inf_03;
mod fw_uav_inf_04;
mod fw_uav_inf_05;
mod fw_uav_inf_06;
mod fw_uav_inf_08;
mod fw_uav_inf_09;
mod fw_uav_list_01;
mod fw_uav_list_01j;
mod fw_uav_list_02;
mod fw_uav_list_03;
mod fw_udp;
mod fw_udp_01;
mod fw_ust;
mod fw_wth_01;
mod px_arr_01;
mod px_bool_01;
mod px_cdr_01;
mod px_cdr_02;
mod px_data_01;
mod px_data_02;
mod px_data_03;
mod px_enum_01;
mod px_ext;
mod px_ext_01;
mod px_ext_02;
mod px_ext_03;
mod px_ext_04;
mod px_ext_05;
mod px_fmt_01;
mod px_fmt_02;
mod px_fmt_03;
mod px_fsf_03;
mod px_hash_01;
mod px_json_01;
mod px_json_02;
mod px_len_01;
mod px_nan_01;
mod px_queue_01;
mod px_range_01;
mod px_str_01;
mod px_time_01;
mod px_time_02;
mod px_ver_01;

use std::fmt;

pub(crate) use self::fw_asy_22::TYPES as TYPES_WITH_RESULTS;
pub(crate) use self::px_bool_01::RULE as PX_BOOL_01;
pub(crate) use self::px_cdr_01::RULE as PX_CDR_01;
pub(crate) use self::px_cdr_02::RULE as PX_CDR_02;
pub(crate) use self::px_data_01::RULE as PX_DATA_01;
pub(crate) use self::px_data_02::RULE as PX_DATA_02;
pub(crate) use self::px_fmt_01::RULE as PX_FMT_01;
pub(crate) use self::px_fmt_02::RULE as PX_FMT_02;
pub(crate) use self::px_fmt_03::RULE as PX_FMT_03;
pub(crate) use self::px_hash_01::RULE as PX_HASH_01;

use serde::Serialize;
use uavspec_codegen::schema::MessageId;
use uavspec_codegen::source::Span;

use crate::conversation::Turn;
use crate::definitions::Definitions;
use crate::detail::Detail;
use crate::finding::Findings;
use crate::record::{Channel, Message, Place};
use crate::sample::Flight;

/// Every rule, by id.
pub static RULES: [&Rule; 156] = [
    &fw_ack_01::RULE,
    &fw_ack_03::RULE,
    &fw_ack_04::RULE,
    &fw_ack_06::RULE,
    &fw_asy_01::RULE,
    &fw_asy_02::RULE,
    &fw_asy_03::RULE,
    &fw_asy_04::RULE,
    &fw_asy_04i::RULE,
    &fw_asy_06::RULE,
    &fw_asy_07::RULE,
    &fw_asy_08::RULE,
    &fw_asy_09::RULE,
    &fw_asy_10::RULE,
    &fw_asy_11::RULE,
    &fw_asy_12::RULE,
    &fw_asy_13::RULE,
    &fw_asy_14::RULE,
    &fw_asy_16::RULE,
    &fw_asy_17::RULE,
    &fw_asy_18::RULE,
    &fw_asy_19::RULE,
    &fw_asy_20::RULE,
    &fw_asy_20j::RULE,
    &fw_asy_22::RULE,
    &fw_auth_01::RULE,
    &fw_conn_inf_01::RULE,
    &fw_conn_inf_02::RULE,
    &fw_conn_inf_03::RULE,
    &fw_dev_01::RULE,
    &fw_env_01::RULE,
    &fw_env_02::RULE,
    &fw_env_02j::RULE,
    &fw_env_03::RULE,
    &fw_env_03j::RULE,
    &fw_env_04::RULE,
    &fw_env_05::RULE,
    &fw_env_06::RULE,
    &fw_env_07::RULE,
    &fw_env_08::RULE,
    &fw_env_09::RULE,
    &fw_env_10::RULE,
    &fw_env_11::RULE,
    &fw_env_12::RULE,
    &fw_env_13::RULE,
    &fw_env_14::RULE,
    &fw_env_15::RULE,
    &fw_env_16::RULE,
    &fw_env_17::RULE,
    &fw_env_18::RULE,
    &fw_env_19::RULE,
    &fw_trials::ENV_21,
    &fw_env_22::RULE,
    &fw_env_23::RULE,
    &fw_env_24::RULE,
    &fw_env_25::RULE,
    &fw_err_01::RULE,
    &fw_err_02::RULE,
    &fw_err_03::RULE,
    &fw_err_04::RULE,
    &fw_err_06::RULE,
    &fw_err_07::RULE,
    &fw_err_08::RULE,
    &fw_err_09::RULE,
    &fw_err_10::RULE,
    &fw_inf_01::RULE,
    &fw_obj_del_01::RULE,
    &fw_obj_del_02::RULE,
    &fw_obj_list_01::RULE,
    &fw_obj_list_01j::RULE,
    &fw_obj_list_02::RULE,
    &fw_obj_list_03::RULE,
    &fw_obj_list_04::RULE,
    &fw_prm_01::RULE,
    &fw_trials::SIO_01,
    &fw_trials::SIO_02,
    &fw_trials::SIO_03,
    &fw_sys_close_01::RULE,
    &fw_sys_close_02::RULE,
    &fw_sys_msg_01::RULE,
    &fw_sys_msg_02::RULE,
    &fw_sys_ping_01::RULE,
    &fw_sys_ping_02::RULE,
    &fw_sys_ports_01::RULE,
    &fw_sys_ports_02::RULE,
    &fw_sys_time_01::RULE,
    &fw_sys_time_02::RULE,
    &fw_sys_time_03::RULE,
    &fw_sys_ver_01::RULE,
    &fw_sys_ver_02::RULE,
    &fw_sys_ver_03::RULE,
    &fw_sys_ver_04::RULE,
    &fw_tcp_01::RULE,
    &fw_trials::TCP_02,
    &fw_trials::TCP_03,
    &fw_trials::TCP_04,
    &fw_uav_inf_01::RULE,
    &fw_uav_inf_02::RULE,
    &fw_uav_inf_03::RULE,
    &fw_uav_inf_04::RULE,
    &fw_uav_inf_05::RULE,
    &fw_uav_inf_06::RULE,
    &fw_uav_list_03::REPEATED,
    &fw_uav_inf_08::RULE,
    &fw_uav_inf_09::RULE,
    &fw_uav_list_01::RULE,
    &fw_uav_list_01j::RULE,
    &fw_uav_list_02::RULE,
    &fw_uav_list_03::RULE,
    &fw_udp_01::RULE,
    &fw_udp::UDP_02,
    &fw_udp::UDP_03,
    &fw_ust::ATTITUDE,
    &fw_ust::BATTERY,
    &fw_ust::DEBUG,
    &fw_ust::ERRORS,
    &fw_ust::GPS,
    &fw_ust::HEADING,
    &fw_ust::ID,
    &fw_ust::LIGHT,
    &fw_ust::MODE,
    &fw_ust::POSITION,
    &fw_ust::POSITIONXYZ,
    &fw_ust::RSSI,
    &fw_ust::TIMESTAMP,
    &fw_ust::VELOCITY,
    &fw_ust::VELOCITYXYZ,
    &fw_wth_01::RULE,
    &px_arr_01::RULE,
    &px_bool_01::RULE,
    &px_cdr_01::RULE,
    &px_cdr_02::RULE,
    &px_data_01::RULE,
    &px_data_02::RULE,
    &px_data_03::RULE,
    &px_enum_01::RULE,
    &px_ext_01::RULE,
    &px_ext_02::RULE,
    &px_ext_03::RULE,
    &px_ext_04::RULE,
    &px_ext_05::RULE,
    &px_fmt_01::RULE,
    &px_fmt_02::RULE,
    &px_fmt_03::RULE,
    &px_fsf_03::RULE,
    &px_hash_01::RULE,
    &px_json_01::RULE,
    &px_json_02::RULE,
    &px_len_01::RULE,
    &px_nan_01::RULE,
    &px_queue_01::RULE,
    &px_range_01::RULE,
    &px_str_01::RULE,
    &px_time_01::RULE,
    &px_time_02::RULE,
    &px_ver_01::RULE,
];

/// How much a rule binds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "UPPERCASE")]
pub enum Level {
    /// Derived, and shown without being judged.
    Info,
    /// What breaks it should be looked at.
    Should,
    /// What breaks it doesn't conform.
    Must,
}

impl fmt::Display for Level {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Info => "INFO",
            Self::Should => "SHOULD",
            Self::Must => "MUST",
        })
    }
}

/// Whether what a rule says is beyond doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The specification lays it down.
    Normative,
    /// The specification contradicts itself; how, says the text.
    Disputed(&'static str),
    /// It follows from the specification, or from what it is for.
    Advisory,
}

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.pad(match self {
            Self::Normative => "normative",
            Self::Disputed(_) => "disputed",
            Self::Advisory => "advisory",
        })
    }
}

/// A rule.
#[derive(Debug)]
pub struct Rule {
    /// Its id, which never changes its meaning and is never used again.
    pub id: &'static str,
    /// How much it binds.
    pub level: Level,
    /// Whether it is beyond doubt.
    pub status: Status,
    /// What has to hold.
    pub statement: &'static str,
    /// What lays it down.
    pub source: &'static str,
    /// What it is about.
    pub applies_to: &'static str,
    /// What finds breaches.
    pub check: Check,
    /// What it has to find.
    pub mutants: &'static [Mutant],
}

impl Rule {
    /// Whether it is about conversations of Flockwave, and so about no other sources.
    pub fn is_on_flockwave(&self) -> bool {
        self.id.starts_with("FW-")
    }
}

/// What finds breaches of a rule.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// The plan of a format, value by value.
    Value,
    /// Whoever reads the source, since what breaks it can't be read as anything.
    Source,
    /// A state that follows the records of a source. Of the states in reports on UAVs it is but the ids and timestamps that it
    /// looks at.
    State(fn() -> Box<dyn Checker>),
    /// What a conversation knows of each exchange. A report on UAVs, which is about no other message, is judged by what it
    /// says alone.
    Exchange(fn(&Turn<'_>, &mut Judged<'_>)),
    /// The same; and of reports on UAVs it counts when they come, over which connection, and after what. Of the states in
    /// them it is but the ids and timestamps that count.
    Context(fn(&Turn<'_>, &mut Judged<'_>)),
}

/// A source that breaks a rule: a small change of one that conforms.
#[derive(Debug)]
pub struct Mutant {
    /// What is changed.
    pub name: &'static str,
    /// Makes it of a flight; none where the definitions have nothing that could be changed so.
    pub make: fn(&Flight<'_>) -> Option<Vec<u8>>,
    /// The ids of other rules that it can't but break, too.
    pub also: &'static [&'static str],
}

/// What a rule wants to know of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interest {
    /// No more than that it was opened.
    #[default]
    Nothing,
    /// When messages come.
    Times,
    /// What they say.
    Values,
}

/// Follows the records of one source.
pub trait Checker {
    /// A channel is opened: a topic with its type. Only messages of channels that are of interest come.
    fn opened(&mut self, _channel: &Channel<'_>, _judged: &mut Judged<'_>) -> Interest {
        Interest::Nothing
    }

    /// A channel is closed, as it was unsubscribed or its place is given to another. That may be said twice.
    fn closed(&mut self, _channel: &Channel<'_>) {}

    /// When the source was begun, in µs since system start.
    fn started(&mut self, _time: u64) {}

    /// A message comes.
    fn message(&mut self, _channel: &Channel<'_>, _message: &Message<'_>, _judged: &mut Judged<'_>) {}

    /// Something goes over a connection, or happens to it.
    fn exchanged(&mut self, _turn: &Turn<'_>, _judged: &mut Judged<'_>) {}

    /// Records were lost, for so many milliseconds.
    fn dropout(&mut self, _milliseconds: u16, _place: Place) {}

    /// Something can't be read, and records may be lost with it; or it is a message of a channel that is of interest.
    fn damage(&mut self, _place: Place) {}

    /// The source ends.
    fn end(&mut self, _judged: &mut Judged<'_>) {}
}

/// What looks at each exchange alone.
pub(crate) struct EachExchange(pub(crate) fn(&Turn<'_>, &mut Judged<'_>));

impl Checker for EachExchange {
    fn exchanged(&mut self, turn: &Turn<'_>, judged: &mut Judged<'_>) {
        (self.0)(turn, judged);
    }
}

/// A state for each channel.
#[derive(Debug)]
struct PerChannel<T>(Vec<T>);

impl<T: Default + Clone> PerChannel<T> {
    /// Starts anew with a channel.
    fn open(&mut self, channel: &Channel<'_>, state: T) {
        let count = self.0.len().max(channel.index + 1);
        self.0.resize(count, T::default());
        self.0[channel.index] = state;
    }

    /// The state of a channel that was opened.
    fn of(&mut self, channel: &Channel<'_>) -> Option<&mut T> {
        self.0.get_mut(channel.index)
    }
}

impl<T> Default for PerChannel<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

/// Where a rule puts what it finds.
pub struct Judged<'j> {
    /// The rule.
    pub rule: &'static Rule,
    /// What it is judged by.
    pub definitions: &'j Definitions,
    /// All findings.
    pub findings: &'j mut Findings,
    /// How often it was exercised.
    pub exercised: &'j mut u64,
}

impl Judged<'_> {
    /// Where a definition says what its messages are.
    pub(crate) fn defined(&self, definition: Option<MessageId>) -> Option<Span> {
        definition.map(|id| self.definitions.schema.message(id).span)
    }

    /// Where a definition has this field.
    pub(crate) fn field(&self, definition: Option<MessageId>, name: &str) -> Option<Span> {
        let fields = &self.definitions.schema.message(definition?).fields;
        fields.iter().find(|field| field.name == name).map(|field| field.span)
    }

    /// Something was looked at, whatever came of it.
    pub fn exercise(&mut self) {
        *self.exercised += 1;
    }

    /// Something breaks the rule.
    pub fn report(&mut self, subject: &str, place: Place, detail: impl FnOnce() -> Detail) {
        self.findings.report(self.rule, subject, place, None, detail);
    }

    /// Something breaks the rule, which a definition has at this place.
    pub(crate) fn report_defined(
        &mut self,
        subject: &str,
        place: Place,
        definition: Option<Span>,
        detail: impl FnOnce() -> Detail,
    ) {
        self.findings.report(self.rule, subject, place, definition, detail);
    }

    /// A field of the messages of a channel breaks the rule.
    fn report_field(
        &mut self,
        channel: &Channel<'_>,
        name: &str,
        place: Place,
        detail: impl FnOnce() -> Detail,
    ) {
        let definition = self.field(channel.definition, name);
        self.report_defined(&format!("{}.{name}", channel.topic), place, definition, detail);
    }
}

// A rule that finds nothing is none.
const _: () = assert!(have_mutants(&RULES), "a rule without a mutant");

/// Whether each of these rules has a mutant.
const fn have_mutants(mut rules: &[&Rule]) -> bool {
    while let [first, rest @ ..] = rules {
        if first.mutants.is_empty() {
            return false;
        }
        rules = rest;
    }
    true
}

/// The rule of an id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_so_that_they_can_be_looked_up() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }

    #[test]
    fn a_rule_without_a_mutant_is_seen_among_others() {
        let without = Rule { check: Check::Value, mutants: &[], ..px_arr_01::RULE };
        assert!(have_mutants(&RULES));
        assert!(!have_mutants(&[&px_arr_01::RULE, &without, &px_bool_01::RULE]));
    }

    #[test]
    fn levels_and_statuses_are_words_that_keep_to_columns() {
        let levels = [Level::Info, Level::Should, Level::Must].map(|level| format!("{level:7}|"));
        assert_eq!(levels, ["INFO   |", "SHOULD |", "MUST   |"]);
        let statuses = [Status::Normative, Status::Disputed("how"), Status::Advisory];
        assert_eq!(statuses.map(|status| status.to_string()), ["normative", "disputed", "advisory"]);
    }
}
