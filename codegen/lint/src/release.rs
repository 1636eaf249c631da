//! Releases: the definitions of a whole distribution as one text, without comments.
//!
//! A release contains facts only: names, types, constants, units, constraints, enums, topics and versions. From
//! comments, a release keeps only the words `NaN` and `bitmask`, which exempt values from checks. The text has the form
//! that bags use for definitions: each definition follows a line of `=` characters and a line with its name.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! use uavspec_lint::release;
//!
//! let mut sources = SourceMap::default();
//! let text = "# Wind\n\nuint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed over ground\n";
//! let id = sources.add("Wind.msg", text.into()).unwrap();
//! let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! let (schema, _) = read(&sources, &packages);
//!
//! let text = release::write(&schema);
//! let entry = release::entries(&text).next().unwrap();
//! assert_eq!((entry.package, entry.name), ("px4_msgs", "Wind"));
//! assert_eq!(entry.text, "uint64 timestamp # [us]\nfloat32 speed # [m/s] [@range 0, 60]\n");
//! ```

mod entries;
mod fingerprint;
mod history;
mod selection;
mod text;

pub use self::entries::{Entry, Section, entries, packages, sections};
pub use self::fingerprint::{Fingerprint, LayoutHashes, fingerprints, keys_hash};
pub use self::history::{Change, ReleaseText, Releases, Step, history};
pub use self::selection::{full_name, select};
pub use self::text::write;

/// A key that sorts releases by the numbers in their names, from the oldest to the newest. Names come after numbers.
pub fn age(name: &str) -> Vec<Result<u32, String>> {
    name.split('.').map(|part| part.parse().map_err(|_| part.to_owned())).collect()
}
