//! Which deviations have rules of their own. Each is told once: by its own rule where it has one, and by `FW-ENV-18`
//! where it has none.
//!
//! Where the rules let null stand for what is left out, since the specification contradicts itself there, the shape of
//! the definition doesn't, so null is left to `FW-ENV-18`.

use super::Fault;
use super::Fault::{Absent, Further, Kind, Null, Value};
use super::check::At;
use crate::flockwave::session::OPERATIONS;
use crate::rules::flockwave::TYPES_WITH_RESULTS;

/// Deviations with a rule of their own.
#[derive(Debug)]
pub(super) struct Told {
    /// The rule.
    pub(super) rule: &'static str,
    /// The types of the messages.
    types: &'static [&'static str],
    /// Where in the body.
    path: &'static [Step],
    /// What is wrong there.
    faults: &'static [Fault],
}

/// A step of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// Into this field.
    Field(&'static str),
    /// Into any field or element.
    Each,
    /// Here, or anywhere below.
    Below,
}

use Step::{Below, Each, Field};

/// Anything but what it should be, null apart.
const WRONG: &[Fault] = &[Kind, Value];

/// No value of its kind.
const NONE: &[Fault] = &[Absent, Null, Kind];

/// No value as it should be.
const UNFIT: &[Fault] = &[Absent, Null, Kind, Value];

const ALL: &[Fault] = &[Absent, Null, Kind, Value, Further];

const RECEIPTS: &[&str] = &OPERATIONS;

const fn told(
    rule: &'static str,
    types: &'static [&'static str],
    path: &'static [Step],
    faults: &'static [Fault],
) -> Told {
    Told { rule, types, path, faults }
}

const fn state(rule: &'static str, path: &'static [Step]) -> Told {
    told(rule, &["UAV-INF"], path, ALL)
}

/// A field of a state, and all in it.
macro_rules! states {
    ($($rule:literal $field:literal),* $(,)?) => {
        [$(state($rule, &[Field("status"), Each, Field($field), Below])),*]
    };
}

static STATES: [Told; 14] = states![
    "FW-UST-ATTITUDE" "attitude",
    "FW-UST-BATTERY" "battery",
    "FW-UST-DEBUG" "debug",
    "FW-UST-GPS" "gps",
    "FW-UST-HEADING" "heading",
    "FW-UST-ID" "id",
    "FW-UST-LIGHT" "light",
    "FW-UST-MODE" "mode",
    "FW-UST-POSITION" "position",
    "FW-UST-POSITIONXYZ" "positionXYZ",
    "FW-UST-RSSI" "rssi",
    "FW-UST-TIMESTAMP" "timestamp",
    "FW-UST-VELOCITY" "velocity",
    "FW-UST-VELOCITYXYZ" "velocityXYZ",
];

static REST: [Told; 50] = [
    told("FW-ACK-03", &["ACK-ACK"], &[Each], &[Further]),
    told("FW-ACK-04", &["ACK-NAK"], &[Each], &[Further]),
    told("FW-ACK-04", &["ACK-NAK"], &[Field("reason")], &[Kind]),
    told("FW-ASY-04", RECEIPTS, &[Field("receipt")], &[Kind]),
    told("FW-ASY-04", RECEIPTS, &[Field("receipt"), Each], UNFIT),
    told("FW-ASY-04", &["LOG-DATA"], &[Field("receipt")], WRONG),
    told("FW-ASY-08", &["ASYNC-RESP"], &[Field("id")], NONE),
    told("FW-ASY-08", &["ASYNC-RESP"], &[Field("error")], &[Kind]),
    told("FW-ASY-12", &["ASYNC-ST"], &[Field("id")], NONE),
    told("FW-ASY-12", &["ASYNC-ST"], &[Field("progress")], NONE),
    told("FW-ASY-12", &["ASYNC-ST"], &[Field("progress"), Field("percentage")], WRONG),
    told("FW-ASY-12", &["ASYNC-ST"], &[Field("suspended")], &[Kind]),
    told("FW-ASY-20", &["ASYNC-TIMEOUT"], &[Field("ids")], NONE),
    told("FW-ASY-20", &["ASYNC-TIMEOUT"], &[Field("ids"), Each], NONE),
    told("FW-ASY-20J", &["ASYNC-TIMEOUT"], &[Field("ids")], &[Value]),
    told("FW-ASY-22", &TYPES_WITH_RESULTS, &[Field("result"), Each], &[Null, Kind]),
    told("FW-CONN-INF-03", &["CONN-INF"], &[Field("status"), Each], NONE),
    told("FW-CONN-INF-03", &["CONN-INF"], &[Field("status"), Each, Field("purpose")], UNFIT),
    told("FW-CONN-INF-03", &["CONN-INF"], &[Field("status"), Each, Field("status")], UNFIT),
    told("FW-ERR-01", &["UAV-INF"], &[Field("status"), Each, Field("errors"), Each], &[Value]),
    // A state that is no object has no id, either.
    told("FW-UST-ID", &["UAV-INF"], &[Field("status"), Each], NONE),
    told("FW-UST-ERRORS", &["UAV-INF"], &[Field("status"), Each, Field("errors")], ALL),
    told("FW-UST-ERRORS", &["UAV-INF"], &[Field("status"), Each, Field("errors"), Each], NONE),
    told("FW-OBJ-DEL-01", &["OBJ-DEL"], &[Field("ids")], NONE),
    told("FW-OBJ-DEL-01", &["OBJ-DEL"], &[Field("ids"), Each], NONE),
    told("FW-OBJ-LIST-01", &["OBJ-LIST"], &[Field("ids")], NONE),
    told("FW-OBJ-LIST-01", &["OBJ-LIST"], &[Field("ids"), Each], NONE),
    told("FW-OBJ-LIST-01J", &["OBJ-LIST"], &[Field("ids")], &[Value]),
    told("FW-OBJ-LIST-01J", &["OBJ-LIST"], &[Field("ids"), Each], &[Value]),
    told("FW-SYS-CLOSE-01", &["SYS-CLOSE"], &[Field("reason")], &[Kind]),
    told("FW-SYS-MSG-01", &["SYS-MSG"], &[Field("items")], NONE),
    told("FW-SYS-MSG-01", &["SYS-MSG"], &[Field("items"), Each], NONE),
    told("FW-SYS-MSG-01", &["SYS-MSG"], &[Field("items"), Each, Field("message")], NONE),
    told("FW-SYS-MSG-02", &["SYS-MSG"], &[Field("items"), Each, Field("severity")], WRONG),
    told("FW-SYS-PORTS-01", &["SYS-PORTS"], &[Field("ports"), Below], UNFIT),
    told("FW-SYS-TIME-01", &["SYS-TIME"], &[Field("timestamp")], NONE),
    told("FW-SYS-VER-01", &["SYS-VER"], &[Field("software")], NONE),
    told("FW-SYS-VER-02", &["SYS-VER"], &[Field("version")], UNFIT),
    told("FW-SYS-VER-03", &["SYS-VER"], &[Field("name")], &[Kind]),
    told("FW-SYS-VER-03", &["SYS-VER"], &[Field("revision")], &[Kind]),
    told("FW-UAV-INF-04", &["UAV-INF"], &[Field("error")], &[Kind]),
    told("FW-UAV-INF-04", &["UAV-INF"], &[Field("error"), Each], NONE),
    told("FW-UAV-LIST-01", &["UAV-LIST"], &[Field("ids")], NONE),
    told("FW-UAV-LIST-01", &["UAV-LIST"], &[Field("ids"), Each], NONE),
    told("FW-UAV-LIST-01J", &["UAV-LIST"], &[Field("ids")], &[Value]),
    told("FW-UAV-LIST-01J", &["UAV-LIST"], &[Field("ids"), Each], &[Value]),
    told("FW-WTH-01", &["WTH-AT"], &[Field("weather")], NONE),
    told("FW-WTH-01", &["WTH-AT"], &[Field("weather"), Field("timestamp")], NONE),
    told("FW-WTH-01", &["WTH-INF"], &[Field("status"), Each], NONE),
    told("FW-WTH-01", &["WTH-INF"], &[Field("status"), Each, Field("timestamp")], NONE),
];

/// The deviations in bodies of a type that have rules of their own.
pub(super) fn told_of(type_name: &str) -> Vec<&'static Told> {
    STATES.iter().chain(&REST).filter(|told| told.types.contains(&type_name)).collect()
}

/// The rule on something that is wrong at a place.
pub(super) fn told_by(told: &[&'static Told], path: &[At<'_>], fault: Fault) -> Option<&'static str> {
    let is_here = |told: &&&Told| told.faults.contains(&fault) && told.holds(path);
    told.iter().find(is_here).map(|told| told.rule)
}

impl Told {
    fn holds(&self, path: &[At<'_>]) -> bool {
        let (steps, is_below) = match self.path {
            [steps @ .., Below] => (steps, true),
            steps => (steps, false),
        };
        let fits = |(step, at): (&Step, &At<'_>)| match step {
            Field(name) => matches!(at, At::Field(field) if field.name == *name),
            Each | Below => true,
        };
        (path.len() == steps.len() || is_below && path.len() > steps.len())
            && steps.iter().zip(path).all(fits)
    }
}

#[cfg(test)]
mod tests {
    use super::super::defined::{self, Defined};
    use super::*;
    use crate::rules::rule;

    fn field(name: &str) -> defined::Field {
        defined::Field {
            name: name.to_owned(),
            is_required: false,
            shape: Defined::Any,
            span: uavspec_codegen::source::Span::default(),
        }
    }

    #[test]
    fn each_is_told_by_a_rule_that_there_is() {
        for told in STATES.iter().chain(&REST) {
            assert!(rule(told.rule).is_some() && !told.types.is_empty(), "{told:?}");
        }
    }

    #[test]
    fn the_rule_depends_on_the_place_and_on_what_is_wrong() {
        let told = told_of("UAV-INF");
        let by = |path: &[At<'_>], fault| told_by(&told, path, fault);
        let [status, position, errors, error] = ["status", "position", "errors", "error"].map(field);
        let kite = [At::Field(&status), At::Key("kite")];
        assert_eq!(
            by(&[kite[0], kite[1], At::Field(&position), At::Element(2, &error)], Kind),
            Some("FW-UST-POSITION")
        );
        assert_eq!(by(&[kite[0], kite[1], At::Field(&errors), At::Index(0)], Value), Some("FW-ERR-01"));
        assert_eq!(by(&[kite[0], kite[1], At::Field(&errors), At::Index(0)], Kind), Some("FW-UST-ERRORS"));
        assert_eq!(by(&kite, Null), Some("FW-UST-ID"));
        assert_eq!(by(&[kite[0], kite[1], At::Key("flaps")], Further), None);
        // An id may be called as a field is.
        assert_eq!(by(&[At::Key("error")], Kind), None);
        assert_eq!(by(&[At::Field(&error)], Kind), Some("FW-UAV-INF-04"));
        assert_eq!(by(&[At::Field(&error)], Null), None);
        assert_eq!(by(&[], Further), None);
        assert!(told_of("LCN-INF").is_empty());
    }
}
