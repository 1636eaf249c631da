//! The parts of a probe that the user selected.

use std::collections::BTreeSet;

use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_model::Rule;
use uavspec_model::text::similar;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::{RULES, trial};
use uavspec_schema::json_type::Direction;

/// The rules, trials and message types that a probe uses.
///
/// A name is the id of a rule (`FW-TCP-03`), a family of rules (`FW-TCP`), a message type (`UAV-INF`), a family of
/// message types (`UAV`), or the description of a trial (`after a line that is not JSON: words`).
#[derive(Clone, Debug, Default)]
pub struct Selection {
    only: Vec<String>,
    skip: Vec<String>,
    has_no_trials: bool,
}

impl Selection {
    /// Creates a selection: everything or only the names in `only`, without the names in `skip`.
    ///
    /// # Errors
    /// Returns a message about the first unknown name.
    pub fn new(
        only: Vec<String>,
        skip: Vec<String>,
        definitions: &Definitions,
        endpoint: &Endpoint,
    ) -> Result<Self, String> {
        let known = names(definitions, endpoint);
        match only.iter().chain(&skip).find(|name| !known.contains(name.as_str())) {
            None => Ok(Self { only, skip, has_no_trials: false }),
            Some(unknown) => {
                let hint = similar(unknown, known.iter().map(String::as_str)).map_or_else(
                    || {
                        "expected a rule such as FW-TCP-03, a message type such as UAV-INF, a family such as FW-TCP or \
                         UAV, or the description of a trial"
                            .to_owned()
                    },
                    |name| format!("did you mean `{name}`?"),
                );
                Err(format!("{unknown}: no such rule, message type, family or trial; {hint}"))
            }
        }
    }

    /// Removes all trials.
    #[must_use]
    pub fn without_trials(self) -> Self {
        Self { has_no_trials: true, ..self }
    }

    /// True if requests of this type are selected, for the survey and for commands.
    pub(super) fn has_request(&self, type_name: &str) -> bool {
        self.selects(&[type_name])
    }

    /// True if this trial of a rule is selected.
    pub(super) fn has_trial(&self, rule: &Rule, how: &str, type_name: Option<&str>) -> bool {
        !self.has_no_trials && self.selects(&[rule.id, how, type_name.unwrap_or_default()])
    }

    /// True if findings of a rule are reported. If only message types or trials are selected, the findings of all rules
    /// are reported.
    pub(super) fn has_rule(&self, rule: &Rule) -> bool {
        let is_of = |name: &String| is_in(rule.id, name);
        let is_rule = |name: &String| RULES.iter().any(|entry| is_in(entry.rule.id, name));
        !self.skip.iter().any(is_of) && (!self.only.iter().any(is_rule) || self.only.iter().any(is_of))
    }

    fn selects(&self, ids: &[&str]) -> bool {
        let is_named = |names: &[String]| names.iter().any(|name| ids.iter().any(|id| is_in(id, name)));
        (self.only.is_empty() || is_named(&self.only)) && !is_named(&self.skip)
    }
}

/// True if `name` equals the id or the family of the id.
fn is_in(id: &str, name: &str) -> bool {
    id.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'))
}

/// All names that a selection may contain.
fn names(definitions: &Definitions, endpoint: &Endpoint) -> BTreeSet<String> {
    let rules = RULES.iter().map(|entry| entry.rule.id);
    let types: Vec<&str> = definitions.defined_schemas().types(Direction::Request).collect();
    let ids: Vec<&str> = rules.chain(types).collect();
    let families = ids.iter().flat_map(|id| id.match_indices('-').map(|(at, _)| &id[..at]));
    let trials = trial::attempts(endpoint).into_iter().map(|(_, attempt)| attempt.how);
    let requests = trial::requests(&[]).into_iter().map(|(_, request)| request.how.to_owned());
    let named = trials.chain(requests).filter(|how| !how.is_empty());
    families.chain(ids.iter().copied()).map(str::to_owned).chain(named).collect()
}

#[cfg(test)]
mod tests {
    use uavspec_rules::rule;

    use super::*;

    fn selection(only: &[&str], skip: &[&str]) -> Result<Selection, String> {
        let owned = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
        let endpoint: Endpoint = "tcp://localhost:5001".parse()?;
        Selection::new(owned(only), owned(skip), &Definitions::built_in(), &endpoint)
    }

    #[test]
    fn selects_by_rule_family_type_and_trial() -> Result<(), String> {
        let tcp_03 = rule("FW-TCP-03").ok_or("no rule")?;
        let words = "after a line that is not JSON: words";
        let all = Selection::default();
        assert!(all.has_request("UAV-INF") && all.has_trial(tcp_03, words, None) && all.has_rule(tcp_03));
        let tcp = selection(&["FW-TCP"], &[words])?;
        assert!(!tcp.has_request("UAV-INF") && tcp.has_rule(tcp_03));
        assert!(!tcp.has_trial(tcp_03, words, None) && tcp.has_trial(tcp_03, "other", None));
        let uav = selection(&["UAV"], &["UAV-INF"])?;
        assert!(uav.has_request("UAV-LIST") && !uav.has_request("UAV-INF") && !uav.has_request("SYS-VER"));
        assert!(uav.has_rule(tcp_03), "types don't limit the rules");
        let no_tcp = selection(&[], &["FW-TCP-03"])?.without_trials();
        assert!(!no_tcp.has_rule(tcp_03) && no_tcp.has_request("UAV-INF"));
        assert!(!no_tcp.has_trial(tcp_03, "other", None));
        Ok(())
    }

    #[test]
    fn suggests_a_similar_name() {
        let error = selection(&["FW-TPC-03"], &[]).expect_err("an unknown name");
        assert!(error.contains("did you mean `FW-TCP-03`?"), "{error}");
        let error = selection(&[], &["wind"]).expect_err("an unknown name");
        assert!(error.contains("no such rule"), "{error}");
    }
}
