//! The sections of the screen: flags, modes, batteries and components.

use ratatui::style::Style;
use ratatui::text::{Line, Span};
use uavspec_check::timeline::{Label, Part, Refused, Severity, Value, reasons_text};
use uavspec_model::text::{plural, shown};

use super::Scene;
use crate::watch::format;
use crate::watch::vehicle::{Battery, Component, Flag, Groups, Known, Readiness, age, filtered};
use crate::watch::view::theme::Theme;
use crate::watch::view::wrap::{labelled, wrapped};
use crate::watch::words::truncated;

/// The width of the first column.
const INDENT: usize = 10;

type Lines = Vec<Line<'static>>;

/// The flags that are set, by group, most severe first.
pub(super) fn set_flags(scene: &Scene<'_>, filter: &str, width: usize) -> Lines {
    let (theme, vehicle) = (scene.theme, scene.shown.vehicle);
    if vehicle.flags.is_empty() {
        let text = if vehicle.undecided.contains("failsafe_flags") {
            "failsafe_flags of an unknown release: specify it with --definitions, such as px4@1.18"
        } else {
            "no failsafe_flags yet: the vehicle must publish this topic"
        };
        let row = row("", Span::styled(text, theme.faint()), width);
        return [title(theme, "FAILSAFE FLAGS", ""), row].concat();
    }
    let mode = vehicle.status.mode;
    let groups = vehicle.flags.set(mode);
    let num_set: usize = groups.iter().map(Vec::len).sum();
    let num_clear: usize = vehicle.flags.clear(mode).iter().map(Vec::len).sum();
    let mut lines = title(theme, "FAILSAFE FLAGS", &format!("{num_set} of {} set", num_set + num_clear));
    for group in matching(scene, groups, filter) {
        lines.push(Line::styled(group_name(scene, &group), theme.faint()));
        for flag in &group {
            let (word, style) = severity(theme, flag.severity);
            lines.extend(row(Span::styled(word, style), description(scene, flag), width));
        }
    }
    lines
}

/// The flags that aren't set, by group.
pub(super) fn clear_flags(scene: &Scene<'_>, filter: &str, width: usize) -> Lines {
    let (theme, vehicle) = (scene.theme, scene.shown.vehicle);
    let groups = matching(scene, vehicle.flags.clear(vehicle.status.mode), filter);
    if groups.is_empty() {
        return Vec::new();
    }
    let mut lines = title(theme, "FLAGS THAT AREN'T SET", "");
    for group in groups {
        let labels: Vec<String> = group.iter().map(|flag| label(scene, flag.known)).collect();
        let text = format!("{}: {}", group_name(scene, &group), labels.join("; "));
        lines.extend(wrapped(&text, width).into_iter().map(|part| Line::styled(part, theme.faint())));
    }
    lines
}

/// The flags whose name, label or group contains a text.
fn matching<'f>(scene: &Scene<'_>, groups: Groups<'f>, filter: &str) -> Groups<'f> {
    let filter = filter.to_lowercase();
    filtered(groups, |flag| {
        let group = flag.known.group.as_ref().map(|group| group.in_language(scene.language));
        let texts = [&*flag.known.name, &label(scene, flag.known), group.unwrap_or_default()];
        texts.iter().any(|text| text.to_lowercase().contains(&filter))
    })
}

fn group_name(scene: &Scene<'_>, group: &[Flag<'_>]) -> String {
    let label = group.first().and_then(|flag| flag.known.group.as_ref());
    label.map_or_else(|| "Flags".to_owned(), |label| shown(label.in_language(scene.language)))
}

/// The label of a flag with its value, its name and the number of modes that it blocks.
fn description(scene: &Scene<'_>, flag: &Flag<'_>) -> String {
    let value = flag.state.value.as_ref().map(|value| format!(": {}", value_text(scene, value)));
    let modes = match flag.num_modes() {
        0 => String::new(),
        count => format!(" [{}]", plural(count, "mode")),
    };
    let text = label(scene, flag.known);
    let name = if text == flag.known.name { String::new() } else { format!("  {}", flag.known.name) };
    format!("{text}{}{name}{modes}", value.unwrap_or_default())
}

/// The label of a flag, or a text for a requirement without a flag.
fn label(scene: &Scene<'_>, known: &Known) -> String {
    match (&known.label, known.name.as_str()) {
        (Some(label), _) => in_language(scene, label),
        (None, "mode_req_prevent_arming") => "Arming isn't allowed in the current mode".to_owned(),
        (None, "mode_req_other") => "External mode not ready".to_owned(),
        (None, name) => name.to_owned(),
    }
}

fn in_language(scene: &Scene<'_>, label: &Label) -> String {
    shown(label.in_language(scene.language))
}

/// The modes in which the vehicle can't arm, with the reasons in its reports. The current mode comes first.
pub(super) fn refusals(scene: &Scene<'_>, width: usize) -> Lines {
    let refused = scene.shown.vehicle.refused.as_deref().unwrap_or_default();
    if refused.is_empty() {
        return Vec::new();
    }
    let mut lines = title(scene.theme, "CAN'T ARM IN THESE MODES", &refused.len().to_string());
    let texts = refused_texts(scene, refused.iter());
    lines.extend(texts.iter().flat_map(|text| wrapped(text, width)).map(Line::raw));
    lines
}

/// Modes with their reasons. Modes with the same reasons share a text.
pub(super) fn refused_texts<'r>(
    scene: &Scene<'_>,
    refused: impl Iterator<Item = &'r Refused>,
) -> Vec<String> {
    let mut refused: Vec<&Refused> = refused.collect();
    refused.sort_by_key(|refused| scene.shown.vehicle.status.mode != Some(refused.number.into()));
    let mut groups: Vec<(&Refused, Vec<String>)> = Vec::new();
    for found in refused {
        let name = part_text(scene, &found.mode);
        let is_same = |known: &Refused| known.reasons == found.reasons && known.general == found.general;
        match groups.iter_mut().find(|(known, _)| is_same(known)) {
            Some((_, names)) => names.push(name),
            None => groups.push((found, vec![name])),
        }
    }
    let text = |(Refused { reasons, general, .. }, names): &(&Refused, Vec<String>)| {
        let reasons = reasons_text(reasons, general, |part| part_text(scene, part));
        let reasons = reasons.unwrap_or_else(|| "no reason given".to_owned());
        format!("{}: {reasons}", names.join(", "))
    };
    groups.iter().map(text).collect()
}

/// The modes whose requirements aren't met.
pub(super) fn modes(scene: &Scene<'_>, width: usize) -> Lines {
    let (theme, vehicle) = (scene.theme, scene.shown.vehicle);
    let blocked = vehicle.flags.blocked();
    if blocked.is_empty() {
        return Vec::new();
    }
    let count: usize = blocked.iter().map(|(modes, _)| modes.len()).sum();
    let mut lines = title(theme, "MODES THAT CAN'T RUN", &count.to_string());
    for (modes, reasons) in &blocked {
        let names: Vec<String> = modes.iter().map(|mode| mode_name(scene, *mode)).collect();
        let reasons: Vec<String> = reasons.iter().map(|known| label(scene, known)).collect();
        let text = format!("{}: {}", names.join(", "), reasons.join("; "));
        lines.extend(wrapped(&text, width).into_iter().map(Line::raw));
    }
    lines
}

/// The name of a mode. A mode that an external component adds has the name of the component.
fn mode_name(scene: &Scene<'_>, mode: i128) -> String {
    let vehicle = scene.shown.vehicle;
    match (vehicle.components.name_of_mode(mode), vehicle.flags.mode(mode)) {
        (Some(name), _) => truncated(name),
        (None, Some(part)) => truncated(&part.name),
        (None, None) => format!("mode {mode}"),
    }
}

/// The batteries.
pub(super) fn batteries(scene: &Scene<'_>, width: usize) -> Lines {
    let (theme, batteries) = (scene.theme, &scene.shown.vehicle.batteries);
    if batteries.is_empty() {
        return Vec::new();
    }
    let mut lines = title(theme, "BATTERY", "");
    for (id, battery) in batteries {
        let severe = battery.warning.as_ref().map_or(Severity::Normal, |warning| warning.severity);
        let (_, style) = severity(theme, severe);
        let text = battery_text(scene, battery);
        lines.extend(row(format!("battery {id}"), Span::styled(text, style), width));
    }
    lines
}

fn battery_text(scene: &Scene<'_>, battery: &Battery) -> String {
    let percent = battery.percent.map_or(format::MISSING_VALUE.to_owned(), |percent| format!("{percent}%"));
    let volts = battery.tenth_volts.map_or(format::MISSING_VALUE.to_owned(), format::volts);
    let mut parts = vec![percent, format!("{volts} V")];
    if battery.is_connected == Some(false) {
        parts.push("not connected".to_owned());
    }
    if let Some(warning) = battery.warning.as_ref().filter(|warning| warning.severity > Severity::Normal) {
        parts.push(value_text(scene, warning));
    }
    if battery.faults != 0 {
        parts.push(format!("faults {:#x}", battery.faults));
    }
    parts.join("  ")
}

/// The external components.
pub(super) fn components(scene: &Scene<'_>, width: usize) -> Lines {
    let (theme, components) = (scene.theme, &scene.shown.vehicle.components);
    let mut lines = title(theme, "EXTERNAL COMPONENTS", &components.all.len().to_string());
    if components.all.is_empty() && !components.has_request {
        lines.extend(row("", Span::styled("no arming_check_request yet", theme.faint()), width));
    }
    let mut all: Vec<(&i128, &Component)> = components.all.iter().collect();
    all.sort_by_key(|(_, component)| component.readiness());
    for (id, component) in all {
        let (word, severe) = match component.readiness() {
            Readiness::Late => ("late", Severity::Error),
            Readiness::NotReady => ("not ready", Severity::Error),
            Readiness::Unknown => ("no reply", Severity::Warning),
            Readiness::Ready => ("ready", Severity::Normal),
        };
        let (_, style) = severity(theme, severe);
        lines.extend(row(Span::styled(word, style), component_text(scene, *id, component), width));
        for reason in &component.reasons {
            lines.extend(row("", part_text(scene, reason), width));
        }
    }
    if let Some(name) = &components.refused {
        let text = format!("the vehicle refused the registration of `{}`", truncated(name));
        lines.extend(row(Span::styled("refused", theme.server_error()), text, width));
    }
    lines
}

fn component_text(scene: &Scene<'_>, id: i128, component: &Component) -> String {
    let name = component.name.as_deref().map_or("name unknown".to_owned(), truncated);
    let mut parts = vec![format!("{name} (registration {id})")];
    if let Some(replied) = component.replied {
        let age = format::age(Some(age(replied, scene.shown.now)));
        parts.push(format!("reply {age} ago"));
    }
    if component.unanswered > 0 {
        parts.push(format!("{} unanswered", plural(component.unanswered, "request")));
    }
    if component.is_valid == Some(false) {
        parts.push("not registered".to_owned());
    }
    if component.can_run == Some(false) && component.reasons.is_empty() {
        parts.push("no reason given".to_owned());
    }
    parts.join(", ")
}

fn value_text(scene: &Scene<'_>, value: &Value) -> String {
    let parts: Vec<String> = value.parts.iter().map(|part| part_text(scene, part)).collect();
    parts.join("; ")
}

/// The label of a part, or its name.
fn part_text(scene: &Scene<'_>, part: &Part) -> String {
    part.label.as_ref().map_or_else(|| shown(&part.name), |label| in_language(scene, label))
}

/// The title of a section.
fn title(theme: Theme, text: &str, more: &str) -> Lines {
    vec![Line::from(vec![Span::styled(text.to_owned(), theme.title()), Span::raw(format!("  {more}"))])]
}

/// A row with a word in the first column. The text is wrapped into lines.
fn row<'t>(word: impl Into<Span<'t>>, text: impl Into<Span<'t>>, width: usize) -> Lines {
    labelled(word, text, INDENT, width)
}

fn severity(theme: Theme, severity: Severity) -> (&'static str, Style) {
    use uavspec_runtime::Severity as Style;
    match severity {
        Severity::Error => ("error", theme.severity(Style::Error)),
        Severity::Warning => ("warning", theme.severity(Style::Warning)),
        Severity::Normal | Severity::Info => ("", ratatui::style::Style::new()),
    }
}
