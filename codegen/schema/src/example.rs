//! Small example definitions for the documentation and tests of rules.

use std::path::Path;

use crate::Form;
use crate::msg::{Dialect, Kind};
use crate::read::PackageInput;
use crate::source::{SourceId, SourceMap};

/// An example definition.
#[derive(Clone, Copy, Debug)]
pub struct Example {
    /// The file name. A `.msg` file inside a folder belongs to a ROS 2 package; other `.msg` files belong to PX4. A
    /// `.json` file is event metadata. A `.po` file translates `TRANSLATED`. A `.toml` file contains hints for the conversions between the packages of
    /// `CONVERTED`.
    pub path: &'static str,
    /// The content.
    pub text: &'static str,
}

/// Builds an example PX4 message from the lines that follow its timestamp.
#[doc(hidden)] // only for the rules of other crates
#[macro_export]
macro_rules! glider {
    ($($line:literal),* $(,)?) => {
        $crate::example::Example {
            path: "Glider.msg",
            text: concat!(
                "# State of a glider\n\nuint64 timestamp  # [us] Time since system start\n",
                $($line, "\n"),*
            ),
        }
    };
}

/// The definition that example catalogues translate.
pub(crate) const TRANSLATED: Example = crate::glider!["float32 sink      # [m/s] Sink rate"];

/// The definitions that example hints convert.
pub const CONVERTED: [Example; 2] = [
    Example { path: "old_msgs/Glider.msg", text: "float64 sink\n" },
    Example { path: "new_msgs/Glider.msg", text: "float32 sink\nbool is_landed\n" },
];

/// The file of a message whose values also occur in event metadata.
const STATUS: &str = "VehicleStatus.msg";

/// The event metadata that contains the values of [`STATUS`].
const STATUS_EVENTS: Example = Example {
    path: "events.json",
    text: concat!(
        r#"{"version": 2, "components": {"1": {"namespace": "px4", "enums": {"#,
        "\n",
        r#" "arm_disarm_reason_t": {"type": "uint8_t", "entries": {"#,
        "\n",
        r#"  "6": {"name": "landing", "description": "landing"}}},"#,
        "\n",
        r#" "navigation_mode_group_t": {"type": "uint32_t", "is_bitfield": true, "entries": {"#,
        "\n",
        r#"  "1": {"name": "manual", "description": "Manual"}}}}}}}"#,
        "\n"
    ),
};

/// The extension of event metadata.
const EVENTS: &str = ".json";

/// The package of PX4 examples.
const PACKAGE: &str = "demo";

/// Adds the definitions in `files` (path and text) to `sources`, and returns their packages. Displayed paths start with
/// `folder`.
pub fn packages<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Vec<PackageInput> {
    let mut packages: Vec<PackageInput> = Vec::new();
    for (path, text) in files.into_iter().filter(|(path, _)| !is_catalogue(path) && !is_hints(path)) {
        let form = match path.split_once('/') {
            _ if path.ends_with(EVENTS) => Form::Events,
            _ if Kind::of(path).is_none() => Form::Table,
            Some(_) => Form::Msg(Dialect::Ros2),
            None => Form::Msg(Dialect::Px4),
        };
        let name = package_of(path);
        let Some(id) = add(path, text, folder, sources) else { continue };
        match packages.iter_mut().find(|package| package.name == name) {
            Some(package) => package.sources.push(id),
            None => packages.push(PackageInput::new(name, form, vec![id])),
        }
    }
    packages
}

/// The package of an example file.
fn package_of(path: &str) -> &str {
    match path.split_once('/') {
        _ if Kind::of(path).is_none() => "pages",
        Some((package, _)) => package,
        None => PACKAGE,
    }
}

/// Adds the catalogues in `files` to `sources`, like [`packages`].
pub fn catalogues<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Vec<SourceId> {
    let files = files.into_iter().filter(|(path, _)| is_catalogue(path));
    files.filter_map(|(path, text)| add(path, text, folder, sources)).collect()
}

/// Adds the hints in `files` to `sources`, like [`packages`].
pub fn hints<'f>(
    files: impl IntoIterator<Item = (&'f str, &'f str)>,
    folder: &str,
    sources: &mut SourceMap,
) -> Option<SourceId> {
    let mut files = files.into_iter().filter(|(path, _)| is_hints(path));
    files.next().and_then(|(path, text)| add(path, text, folder, sources))
}

fn add(path: &str, text: &str, folder: &str, sources: &mut SourceMap) -> Option<SourceId> {
    let shown = if folder.is_empty() { path.to_owned() } else { format!("{folder}/{path}") };
    // Examples are short and valid UTF-8, so this can't fail.
    sources.add(shown, text.as_bytes().to_vec()).ok()
}

/// True if a file contains translations.
pub fn is_catalogue(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|extension| extension == "po")
}

/// True if a file contains hints for conversions.
pub fn is_hints(path: &str) -> bool {
    Path::new(path).extension().is_some_and(|extension| extension == "toml")
}

impl Example {
    /// The path and text.
    pub fn file(&self) -> (&'static str, &'static str) {
        (self.path, self.text)
    }

    /// The name of the package.
    pub fn package(&self) -> &'static str {
        package_of(self.path)
    }

    /// True if the file has no comments in which a finding could be ignored.
    pub fn is_data(&self) -> bool {
        is_catalogue(self.path) || is_hints(self.path) || self.path.ends_with(EVENTS)
    }

    /// The path and text. A catalogue or hints file is preceded by the definitions that it refers to. The file
    /// `STATUS` is preceded by the event metadata that contains its values.
    pub fn files(&self) -> Vec<(&'static str, &'static str)> {
        let definitions: &[Self] = match self.path {
            path if is_catalogue(path) => &[TRANSLATED],
            path if is_hints(path) => &CONVERTED,
            STATUS => &[STATUS_EVENTS],
            _ => &[],
        };
        definitions.iter().chain([self]).map(Self::file).collect()
    }
}
