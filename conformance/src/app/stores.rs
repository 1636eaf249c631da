//! Object stores, for a program without the feature `stores`: each use is an error.

use uavspec_capture::input::Listed;

/// Lists the captures that a URL denotes.
pub(super) fn list(_: &str) -> Result<Listed, String> {
    Err("this program was built without object stores: build it with `--features stores`".to_owned())
}
