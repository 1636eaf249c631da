//! Converts the arguments of functions.

use std::path::PathBuf;

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use uavspec_tables::{Capture, Options};

/// The name of bytes that are passed without a name.
const UNNAMED: &str = "bytes";

/// The capture that an argument denotes: a path, a URL, or the content of a file.
pub(crate) fn capture(argument: &Bound<'_, PyAny>, name: Option<String>) -> PyResult<Capture> {
    if let Ok(path) = argument.extract::<PathBuf>() {
        if name.is_some() {
            return Err(PyTypeError::new_err("a name is allowed only for bytes"));
        }
        // A path that isn't UTF-8 can't be a name.
        let path = path.into_os_string().into_string();
        return path.map(Capture::Named).map_err(|_| PyTypeError::new_err("the path isn't UTF-8"));
    }
    let bytes = PyBuffer::<u8>::get(argument)
        .map_err(|_| PyTypeError::new_err("expected a path, a URL or bytes"))?
        .to_vec(argument.py())?;
    Ok(Capture::Bytes { name: name.unwrap_or_else(|| UNNAMED.to_owned()), bytes: bytes.into() })
}

/// Like [`capture`], but also accepts a pair of a name and bytes.
pub(crate) fn item(argument: &Bound<'_, PyAny>) -> PyResult<Capture> {
    match argument.extract::<(String, Bound<'_, PyAny>)>() {
        Ok((name, bytes)) => capture(&bytes, Some(name)),
        Err(_) => capture(argument, None),
    }
}

pub(crate) fn options(
    definitions: Option<PathBuf>,
    events: Option<PathBuf>,
    schemas: Vec<PathBuf>,
    has_timeline: bool,
    are_formats_strict: bool,
    are_warnings_denied: bool,
) -> Options {
    Options { definitions, events, schemas, are_formats_strict, are_warnings_denied, has_timeline }
}
