//! The names that most files of PX4 rules use.

pub(super) use uavspec_model::{Channel, Detail, Level, Location, Message, Rule, Status, SubjectName};

pub(super) use super::bug::{Bug, Needs, Side};
pub(super) use super::{Check, Checker, Interest, Mutant, PerChannel, Px4Rule};
pub(super) use crate::RuleContext;
pub(super) use crate::sample::{Bag, Encoding, Flight};
