//! The sources that rules cite: parts of the specification, and their pages.

use std::path::Path;

use uavspec_model::Rule;

pub(super) const GENERAL: &str = "Flockwave 2.10, general description of messages";
pub(super) const SCHEMA: &str = "Flockwave 2.10, published JSON Schema";
pub(super) const TRANSPORT: &str = "Flockwave 2.10, transport";
pub(super) const TYPES: &str = "Flockwave 2.10, types";
pub(super) const ERRORS: &str = "Flockwave 2.10, error codes";
pub(super) const ASYNC: &str = "Flockwave 2.10, asynchronous operations";
pub(super) const MESSAGES: &str = "Flockwave 2.10, description of the message";
pub(super) const DERIVED: &str = "derived from Flockwave 2.10";

/// The folder of the pages.
const PAGES: &str = "https://doc.collmot.com/public/skybrush-protocol-spec/latest";

/// The pages of message families.
const FAMILIES: [&str; 20] = [
    "ack", "async", "auth", "bcn", "clk", "cmd", "conn", "dev", "dock", "ext", "fw", "lcn", "obj", "prm",
    "rtk", "show", "sys", "timesync", "uav", "wth",
];

/// The URL of the specification's page about a finding: the page of the violated definition, of the rule's source, or of
/// the message. `None` if there is no such page.
pub fn page(rule: &Rule, subject: &str, definition: Option<&str>) -> Option<String> {
    if !rule.is_on_flockwave() {
        return None;
    }
    let of_definition =
        definition.and_then(|path| page_of_definition(Path::new(path).file_stem()?.to_str()?));
    let of_source = match rule.source {
        GENERAL => Some("general".to_owned()),
        TRANSPORT => Some("transport".to_owned()),
        TYPES => Some("types".to_owned()),
        ERRORS => Some("errors".to_owned()),
        ASYNC => Some("async".to_owned()),
        _ => None,
    };
    let family = || subject.split('-').next().unwrap_or_default().to_ascii_lowercase();
    let page = of_definition.or(of_source).or_else(|| page_of_family(&family()))?;
    Some(format!("{PAGES}/{page}.html"))
}

/// The page about the content of a file with definitions.
fn page_of_definition(stem: &str) -> Option<String> {
    match stem {
        "envelope" => Some("general".to_owned()),
        "error-codes" => Some("errors".to_owned()),
        "types" => Some("types".to_owned()),
        family => page_of_family(family),
    }
}

fn page_of_family(family: &str) -> Option<String> {
    FAMILIES.contains(&family).then(|| format!("messages/{family}"))
}
