//! File URIs.

use std::path::{Path, PathBuf};

use lsp_types::Uri;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_decode_str, utf8_percent_encode};
use uavspec_schema::path::normalise;

/// The characters that are encoded in the path of a URI.
const ENCODED: &AsciiSet =
    &NON_ALPHANUMERIC.remove(b'/').remove(b'-').remove(b'_').remove(b'.').remove(b'~').remove(b':');

/// The path of a file URI, or `None` for other URIs, such as the URIs of unsaved documents.
pub(super) fn to_path(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.0.strip_prefix("file://")?;
    let path = rest.get(rest.find('/')?..)?;
    let path = percent_decode_str(path).decode_utf8().ok()?;
    // On Windows, the drive follows a slash: `file:///c:/msg`.
    let drive = cfg!(windows).then(|| path.strip_prefix('/')).flatten();
    Some(normalise(Path::new(drive.unwrap_or(&path))))
}

/// The URI of an absolute path.
pub fn from_path(path: &Path) -> Uri {
    let path = path.to_string_lossy();
    let path = if cfg!(windows) { path.replace('\\', "/") } else { path.into_owned() };
    let slash = if path.starts_with('/') { "" } else { "/" };
    Uri(format!("file://{slash}{}", utf8_percent_encode(&path, ENCODED)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_survive_a_round_trip() {
        for path in ["/tmp/a b/Ünï.msg", "/px4/msg/100%#1?.msg", "/"] {
            assert_eq!(to_path(&from_path(Path::new(path))).as_deref(), Some(Path::new(path)));
        }
        assert_eq!(from_path(Path::new("/a b/é.msg")).0, "file:///a%20b/%C3%A9.msg");
        assert_eq!(to_path(&Uri("file://localhost/a/./b/../c.msg".to_owned())), Some("/a/c.msg".into()));
        assert_eq!(to_path(&Uri("untitled:Untitled-1".to_owned())), None);
        assert_eq!(to_path(&Uri("file://".to_owned())), None);
    }
}
