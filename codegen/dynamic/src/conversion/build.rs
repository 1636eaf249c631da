//! Builds the conversions between two packages.

mod constants;
mod direction;
mod field;
mod message;
mod neutral;

use std::collections::HashMap;
use std::sync::Arc;

use uavspec_schema::wording::similar;
use uavspec_schema::{Form, Kind, MessageId, Package, Schema};

use self::direction::Pairs;
use super::hints::{Decisions, Hint, Hints, Mistake, missing};
use super::plan::{Conversion, Elements, Step, Undecided};
use crate::breaking::{Between, Comparison, Pair};

/// A package, as one side of a conversion.
#[derive(Clone, Copy, Debug)]
pub struct Version<'s> {
    /// The schema that contains the package.
    pub schema: &'s Schema,
    /// The index of the package.
    pub package: usize,
}

impl<'s> Version<'s> {
    /// The package with this name.
    pub fn find(schema: &'s Schema, name: &str) -> Option<Self> {
        let package = schema.packages.iter().position(|package| package.name == name)?;
        Some(Self { schema, package })
    }

    fn package(self) -> &'s Package {
        &self.schema.packages[self.package]
    }
}

/// All conversions between two packages.
#[derive(Clone, Debug, Default)]
pub struct Conversions {
    /// The index of the old package in its schema.
    pub old: usize,
    /// The index of the new package in its schema.
    pub new: usize,
    /// The conversions from the old to the new package, by name of the new message. Contains only messages that exist
    /// in both packages, and messages that share a topic according to a hint.
    pub forward: Vec<Arc<Conversion>>,
    /// The conversions from the new to the old package, in the same order.
    pub backward: Vec<Arc<Conversion>>,
    /// Mistakes in the hints that are detected only with the definitions, such as wrong types.
    pub mistakes: Vec<Mistake>,
    /// The hints that apply.
    pub applied: Applied,
}

/// The hints that apply to at least one message.
#[derive(Clone, Debug, Default)]
pub struct Applied {
    /// True for each hint that applies, by its index in the file.
    hints: Vec<bool>,
    /// Like `hints`, for the renamed packages.
    packages: Vec<bool>,
}

impl Applied {
    fn none(hints: &Hints) -> Self {
        Self { hints: vec![false; hints.of_messages.len()], packages: vec![false; hints.packages.len()] }
    }

    /// Adds the hints that apply elsewhere.
    pub fn merge(&mut self, other: &Self) {
        for (all, added) in [(&mut self.hints, &other.hints), (&mut self.packages, &other.packages)] {
            all.resize(all.len().max(added.len()), false);
            all.iter_mut().zip(added).for_each(|(all, added)| *all |= added);
        }
    }
}

impl Conversions {
    /// The conversions between two packages of a schema, by name. `None` if a package doesn't exist.
    pub fn within(schema: &Schema, old: &str, new: &str, hints: &Hints) -> Option<Self> {
        Some(Self::between(Version::find(schema, old)?, Version::find(schema, new)?, hints))
    }

    /// The conversions between two packages, which may belong to different schemas. The hints describe changes from
    /// `old` to `new`.
    pub fn between(old: Version<'_>, new: Version<'_>, hints: &Hints) -> Self {
        let mut applied = Applied::none(hints);
        let packages = paired_packages(old, new, hints, &mut applied);
        let mut others = shared_topics(old, new, hints);
        for (before, after) in &packages {
            others.extend(derived_twins((old.schema, *before), (new.schema, *after)));
        }
        let packages = packages.into_iter().map(|(before, after)| (Some(before), Some(after))).collect();
        let comparison =
            Comparison::of_packages((old.schema, new.schema), packages, &others, Between::Releases);
        let mut pairs = Pairs::new();
        for pair in &comparison.pairs {
            pairs.insert(pair.ids, pair);
        }
        let mut found = Self { old: old.package, new: new.package, applied, ..Self::default() };
        let selected = |pair: &&Pair<'_>| (pair.old.package, pair.new.package) == (old.package, new.package);
        let mut listed: Vec<(MessageId, MessageId)> =
            comparison.pairs.iter().filter(selected).map(|pair| pair.ids).collect();
        listed.sort_by_key(|ids| (&new.schema.message(ids.1).name, &old.schema.message(ids.0).name));
        listed.dedup();
        for is_forward in [true, false] {
            let mut builder =
                Builder { pairs: &pairs, hints, is_forward, built: HashMap::new(), found: &mut found };
            let built = listed.iter().filter_map(|ids| builder.conversion(*ids)).collect();
            if is_forward { found.forward = built } else { found.backward = built }
        }
        found.mistakes.sort_by_key(|mistake| (mistake.span, mistake.message.clone()));
        found.mistakes.dedup();
        found
    }

    /// The conversion of a message from one package to the other.
    pub fn find(&self, from: MessageId, to: MessageId, is_forward: bool) -> Option<&Arc<Conversion>> {
        let all = if is_forward { &self.forward } else { &self.backward };
        all.iter().find(|conversion| (conversion.from, conversion.to) == (from, to))
    }

    /// The undecided parts of all conversions. A part that is undecided in both directions is listed once.
    pub fn undecided(&self) -> Vec<&Undecided> {
        let mut all: Vec<&Undecided> =
            self.forward.iter().chain(&self.backward).flat_map(|conversion| &conversion.undecided).collect();
        all.sort_by_key(|found| (found.span, &found.message));
        all.dedup_by_key(|found| (found.span, &found.message));
        all
    }
}

impl Hints {
    /// The hints that don't apply to any conversion, each with its location and the reason. `versions` contains the
    /// packages that explain the reason.
    pub fn unused(&self, applied: &Applied, versions: &[(Version<'_>, Version<'_>)]) -> Vec<Mistake> {
        let help = || "correct the name, or remove the hint".to_owned();
        let is_unused = |applied: &[bool], at: usize| applied.get(at) != Some(&true);
        let hints = self.of_messages.iter().enumerate().filter(|(at, _)| is_unused(&applied.hints, *at));
        let unused = hints.map(|(_, hint)| {
            let reason = versions.iter().find_map(|(old, new)| closest(hint, *old, *new));
            let (span, message) = reason.unwrap_or_else(|| {
                let [old, new] = &hint.messages;
                (old.span, format!("no package has the messages `{}` and `{}`", old.text, new.text))
            });
            Mistake { span, message, help: help() }
        });
        let packages = self.packages.iter().enumerate().filter(|(at, _)| is_unused(&applied.packages, *at));
        let packages = packages.map(|(_, [old, new])| {
            let message = format!("`{}` and `{}` aren't versions of the same package", old.text, new.text);
            Mistake { span: old.span, message, help: help() }
        });
        unused.chain(packages).collect()
    }
}

/// The reason why a hint doesn't apply to the messages that it names, with a suggestion for a misspelled message.
fn closest(hint: &Hint, old: Version<'_>, new: Version<'_>) -> Option<(uavspec_schema::span::Span, String)> {
    let find = |side: Version<'_>, name: &str| -> Option<MessageId> {
        let messages = &side.package().messages;
        messages.iter().copied().find(|id| side.schema.message(*id).name == name)
    };
    for (side, key) in [(old, &hint.messages[0]), (new, &hint.messages[1])] {
        if find(side, &key.text).is_none() {
            let names = side.package().messages.iter().map(|id| side.schema.message(*id).name.as_str());
            let advice = similar(&key.text, names);
            let advice = advice.map_or_else(String::new, |name| format!("; did you mean `{name}`?"));
            return Some((
                key.span,
                format!("`{}` has no message `{}`{advice}", side.package().name, key.text),
            ));
        }
    }
    let before = old.schema.message(find(old, &hint.messages[0].text)?);
    let after = new.schema.message(find(new, &hint.messages[1].text)?);
    missing(hint, [(old.schema, before), (new.schema, after)]).map(|(key, message)| (key.span, message))
}

/// Messages with different names that share a topic according to a hint.
fn shared_topics(old: Version<'_>, new: Version<'_>, hints: &Hints) -> Vec<(MessageId, MessageId)> {
    let mut pairs = Vec::new();
    for hint in hints.of_messages.iter().filter(|hint| hint.messages[0].text != hint.messages[1].text) {
        let find = |side: Version<'_>, at: usize| {
            let messages = &side.package().messages;
            messages.iter().copied().find(|id| side.schema.message(*id).name == hint.messages[at].text)
        };
        let (Some(before), Some(after)) = (find(old, 0), find(new, 1)) else { continue };
        let sides = [(old.schema, old.schema.message(before)), (new.schema, new.schema.message(after))];
        if missing(hint, sides).is_none() && !pairs.contains(&(before, after)) {
            pairs.push((before, after));
        }
    }
    pairs
}

/// The two packages, and all other packages that both schemas contain, under the same name or the name in a hint.
fn paired_packages<'s>(
    old: Version<'s>,
    new: Version<'s>,
    hints: &Hints,
    applied: &mut Applied,
) -> Vec<(&'s Package, &'s Package)> {
    let is_other = |side: Version<'_>, package: &Package| !std::ptr::eq(side.package(), package);
    let mut pairs = vec![(old.package(), new.package())];
    for package in old.schema.packages.iter().filter(|package| is_other(old, package)) {
        let find =
            |name: &str| new.schema.packages.iter().find(|twin| twin.name == name && is_other(new, twin));
        let twin = hints.counterparts(&package.name).find_map(find);
        if let (Some(twin), Form::Msg(_)) = (twin, package.form) {
            pairs.push((package, twin));
        }
    }
    for (at, [before, after]) in hints.packages.iter().enumerate() {
        let is_pair = |(old, new): &(&Package, &Package)| {
            let names = (&old.ros_package, &new.ros_package);
            names == (&before.text, &after.text) || names == (&after.text, &before.text)
        };
        applied.packages[at] = pairs.iter().any(is_pair);
    }
    pairs
}

/// The pairs of messages that ROS 2 derives from services and actions, and of the messages that only these contain. At
/// least one of the packages doesn't list the message.
fn derived_twins(
    (old, old_package): (&Schema, &Package),
    (new, new_package): (&Schema, &Package),
) -> Vec<(MessageId, MessageId)> {
    let by_name = |schema: &Schema, package: &Package| -> HashMap<(Kind, String), MessageId> {
        let ids = (0..).map(MessageId).zip(&schema.messages);
        let own = ids.filter(|(_, message)| std::ptr::eq(schema.package_of(message), package));
        own.map(|(id, message)| ((message.kind, message.name.clone()), id)).collect()
    };
    let is_listed = |package: &Package, id: MessageId| {
        package.messages.contains(&id) || package.interfaces.iter().any(|found| found.parts.contains(&id))
    };
    let after = by_name(new, new_package);
    let pairs = by_name(old, old_package).into_iter().filter_map(|(name, id)| Some((id, *after.get(&name)?)));
    let mut pairs: Vec<(MessageId, MessageId)> =
        pairs.filter(|(old, new)| !is_listed(old_package, *old) || !is_listed(new_package, *new)).collect();
    pairs.sort();
    pairs
}

/// Builds the conversions in one direction.
struct Builder<'b, 'a> {
    pairs: &'a Pairs<'a>,
    hints: &'b Hints,
    is_forward: bool,
    built: HashMap<(MessageId, MessageId), Arc<Conversion>>,
    found: &'b mut Conversions,
}

impl<'b, 'a> Builder<'b, 'a> {
    /// The conversion of a pair of an old and a new message.
    fn conversion(&mut self, ids: (MessageId, MessageId)) -> Option<Arc<Conversion>> {
        if let Some(built) = self.built.get(&ids) {
            return Some(built.clone());
        }
        let pair: &'a Pair<'a> = self.pairs.get(&ids)?;
        let conversion = Arc::new(self.build(pair));
        self.built.insert(ids, conversion.clone());
        Some(conversion)
    }

    /// The decisions of the hints that apply to a pair.
    fn decisions(&mut self, pair: &Pair<'_>) -> Decisions<'b> {
        let sides = [(pair.old_schema, pair.old), (pair.new_schema, pair.new)];
        let mut decisions = Decisions::default();
        for (at, hint) in self.hints.of_messages.iter().enumerate() {
            if missing(hint, sides).is_none() {
                self.found.applied.hints[at] = true;
                decisions.add(hint, self.is_forward);
            }
        }
        decisions
    }
}

/// The nested conversion of a step.
fn nested(step: &Step) -> Option<&Arc<Conversion>> {
    match step {
        Step::Copy(copy) => match &copy.elements {
            Elements::Message(nested) => Some(nested),
            _ => None,
        },
        Step::Fill(_) | Step::Compute(_) => None,
    }
}
