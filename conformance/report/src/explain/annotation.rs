//! Finds the constants that a field may contain, if the definition doesn't name them.

use uavspec_rules::definitions::ReleaseId;
use uavspec_runtime::Scalar;
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::{Message, Schema};

use super::catalogue::Catalogue;
use super::target::declared_name;

/// The masks of flight modes: the message, the prefix of the field name, and the annotation. According to PX4's
/// comments, bit N belongs to navigation state N.
const MODE_MASKS: [(&str, &str, &str); 3] = [
    ("px4_msgs/msg/FailsafeFlags", "mode_req_", "[@flags VehicleStatus.NAVIGATION_STATE]"),
    ("px4_msgs/msg/VehicleStatus", "valid_nav_states_mask", "[@flags NAVIGATION_STATE]"),
    ("px4_msgs/msg/VehicleStatus", "can_set_nav_states_mask", "[@flags NAVIGATION_STATE]"),
];

/// Words in the names of fields whose values are masks.
const FLAG_WORDS: [&str; 3] = ["flags", "bitfield", "mask"];

/// The source if the definition of the field names the constants.
pub(super) const STATED: &str = "the definition";

/// The source if the constants were inferred. Inferred constants don't specify whether the values are masks.
const BY_NAME: &str = "the names of the constants";
const BY_POSITION: &str = "the position and the names of the constants";

/// An annotation that names the constants of a field.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Annotation {
    /// The line of the definition that declares the field.
    pub(super) line: String,
    /// The annotation.
    pub(super) text: String,
    /// The source of the constants.
    pub(super) known_from: String,
    /// True if the constants were inferred. All other sources specify whether the values are masks.
    pub(super) is_inferred: bool,
}

/// The texts of a definition: in the release to explain, and in all releases, starting with the newest.
pub(super) struct Texts<'t> {
    pub(super) own: &'t str,
    pub(super) all: Vec<(String, &'t str)>,
    pub(super) release: ReleaseId,
}

/// Finds an annotation for a field whose definition has none.
pub(super) fn find(
    catalogue: &Catalogue<'_>,
    texts: &Texts<'_>,
    definition: &str,
    name: &str,
) -> Option<Annotation> {
    let line = texts.own.lines().find(|line| declared_name(line) == Some(name) && !is_constant(line))?;
    let ty = line.split([' ', '[']).next()?;
    let is_integer =
        Scalar::from_name(ty).is_some_and(|scalar| scalar.integer_bounds().is_some() && ty != "bool");
    if !is_integer || has_annotation(line) {
        return None;
    }
    let annotation = |text: String, known_from: &str| Annotation {
        line: line.to_owned(),
        text,
        known_from: known_from.to_owned(),
        is_inferred: false,
    };
    let guess = |prefix: &str, known_from: &str| Annotation {
        is_inferred: true,
        ..annotation(inferred(texts.own, name, prefix), known_from)
    };
    if let Some((.., mask)) =
        MODE_MASKS.iter().find(|(message, start, _)| *message == definition && name.starts_with(start))
    {
        return Some(annotation((*mask).to_owned(), "PX4: bit N belongs to navigation state N"));
    }
    if let Some(text) = documented(catalogue, texts, definition, name) {
        return Some(annotation(text, "uavspec's definition"));
    }
    let other = texts.all.iter().find_map(|(release, text)| Some((release, stated(text, name)?)));
    if let Some((release, text)) = other.filter(|(_, text)| is_used(texts.own, text)) {
        return Some(annotation(text.to_owned(), &format!("the definition in {release}")));
    }
    let is_single = line.split(' ').next() == Some(ty);
    let own = name.to_ascii_uppercase();
    if is_single && constants_with(texts.own, &own).next().is_some() {
        return Some(guess(&own, BY_NAME));
    }
    let prefix = below(texts.own, line, ty).filter(|prefix| is_single && is_named_after(prefix, name))?;
    Some(guess(&prefix, BY_POSITION))
}

/// The annotation for constants that the definition doesn't name.
fn inferred(text: &str, name: &str, prefix: &str) -> String {
    let values = constants_with(text, prefix).filter_map(|(_, value)| value.parse::<i128>().ok());
    let has_zero_and_masks = { values.clone() }.any(|value| value == 0)
        && { values.clone() }.any(|value| value > 1)
        && { values }.all(|value| value == 0 || value.count_ones() == 1);
    // If one of the constants means that no bit is set, masks look like bit numbers.
    let are_flags = FLAG_WORDS.iter().any(|word| name.contains(word)) && !has_zero_and_masks;
    format!("[@{} {prefix}]", if are_flags { "flags" } else { "enum" })
}

/// The annotation of the documented field, with the prefixes that this release uses.
fn documented(catalogue: &Catalogue<'_>, texts: &Texts<'_>, definition: &str, name: &str) -> Option<String> {
    let schema: &Schema = &catalogue.library().base().schema;
    let message: &Message = catalogue.documented(definition)?;
    let field = message.fields.iter().find(|field| field.name == name)?;
    field.ty.element.scalar()?;
    let reference = field.enumeration?;
    let (owner, found) = (schema.message(reference.message), schema.enumeration(reference));
    let full_name = ros_name(schema, owner);
    let is_own = full_name == definition;
    let text = if is_own { texts.own } else { catalogue.text_of(&full_name, texts.release)? };
    // PX4 shortened some prefixes: `BATTERY_WARNING` became `WARNING`.
    let shortened = |prefix: &String| {
        let short = prefix.split_once('_').map(|(_, short)| short.to_owned());
        let known = std::iter::once(prefix.clone()).chain(short);
        known
            .into_iter()
            .find(|prefix| text.lines().filter_map(declared_name).any(|name| has_prefix(name, prefix)))
    };
    let prefixes: Vec<String> = found.prefixes.iter().map(shortened).collect::<Option<_>>()?;
    let word = if found.is_flags { "flags" } else { "enum" };
    let start = if is_own { String::new() } else { format!("{}.", owner.name) };
    let prefixes: Vec<String> = prefixes.into_iter().map(|prefix| format!("{start}{prefix}")).collect();
    Some(format!("[@{word} {}]", prefixes.join(" ")))
}

/// The annotation in the line of a field.
fn stated<'t>(text: &'t str, name: &str) -> Option<&'t str> {
    let line = text.lines().find(|line| declared_name(line) == Some(name) && !is_constant(line))?;
    let start = line.find("[@enum ").or_else(|| line.find("[@flags "))?;
    let end = line[start..].find(']')?;
    Some(&line[start..=start + end])
}

/// True if the definition has constants with each of the prefixes in an annotation.
fn is_used(text: &str, annotation: &str) -> bool {
    let prefixes = annotation.trim_end_matches(']').split(' ').skip(1);
    { prefixes }.all(|prefix| text.lines().filter_map(declared_name).any(|name| has_prefix(name, prefix)))
}

/// The prefix of the constants that are declared below a field. Only fields of the same type may be in between.
fn below(text: &str, line: &str, ty: &str) -> Option<String> {
    let mut lines = text.lines().skip_while(|other| *other != line).skip(1).peekable();
    while lines.next_if(|next| !is_constant(next) && next.split(' ').next() == Some(ty)).is_some() {}
    let mut constants = lines.take_while(|line| is_constant(line)).filter_map(declared_name);
    let first: Vec<&str> = constants.next()?.split('_').collect();
    let mut common = first.len().checked_sub(1)?;
    let mut count = 1;
    for constant in constants {
        let equal =
            first.iter().zip(constant.split('_')).take_while(|(left, right)| **left == *right).count();
        if equal == 0 {
            break;
        }
        (common, count) = (common.min(equal), count + 1);
    }
    let prefix = first[..common].join("_");
    let is_shifted = constants_with(text, &prefix).any(|(name, _)| name.ends_with("_SHIFTS"));
    (common > 0 && count > 1 && !is_shifted).then_some(prefix)
}

fn is_constant(line: &str) -> bool {
    let declaration = line.split(" # ").next().unwrap_or(line);
    declaration.contains('=') && !declaration.starts_with('#')
}

fn has_annotation(line: &str) -> bool {
    line.contains("[@enum ") || line.contains("[@flags ")
}

fn has_prefix(name: &str, prefix: &str) -> bool {
    name.strip_prefix(prefix).is_some_and(|rest| rest.starts_with('_'))
}

/// The names and values of the constants with a prefix.
fn constants_with<'t>(text: &'t str, prefix: &str) -> impl Iterator<Item = (&'t str, &'t str)> + Clone {
    let lines = text.lines().filter(|line| is_constant(line));
    let declarations = lines.map(|line| line.split(" # ").next().unwrap_or(line));
    let constants = declarations.filter_map(|line| line.split_once(' ')?.1.split_once('='));
    let prefix = prefix.to_owned();
    constants.filter(move |(name, _)| has_prefix(name, &prefix))
}

/// True if the last word of a prefix occurs in a field name, possibly in the plural. False for masks that are used for
/// bit shifts, because they aren't values.
fn is_named_after(prefix: &str, name: &str) -> bool {
    let last = prefix.rsplit('_').next().unwrap_or(prefix);
    let is_equal = |word: &str| {
        word.eq_ignore_ascii_case(last)
            || word.strip_suffix('s').is_some_and(|word| word.eq_ignore_ascii_case(last))
    };
    last.len() > 2 && name.split('_').any(is_equal)
}
