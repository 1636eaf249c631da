//! The Python package of uavspec: checks, reads and explains captures.
//!
//! ```text
//!  Python ──capture, options──▶ functions ──▶ uavspec_tables ──▶ Report, Table ──▶ Python
//! ```
//!
//! The work runs in separate threads, without Python's lock. The functions for users, and their documentation, are in
//! `__init__.py`.

#![cfg(feature = "module")]

mod arguments;
mod results;
mod table;
mod work;

use std::num::NonZeroUsize;

use pyo3::prelude::*;
use uavspec_tables::{self as tables, Capture, Options};

use self::arguments::{capture, options};
use self::results::{Report, Results, Timeline};
use self::table::Table;
use self::work::{checker, run};

pyo3::create_exception!(uavspec, Error, pyo3::exceptions::PyException, "The one exception of this package.");

#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the function in Python names them")]
fn check(
    py: Python<'_>,
    capture: &Bound<'_, PyAny>,
    name: Option<String>,
    definitions: Option<std::path::PathBuf>,
    events: Option<std::path::PathBuf>,
    schemas: Vec<std::path::PathBuf>,
    timeline: bool,
    strict_formats: bool,
    deny_warnings: bool,
) -> PyResult<Py<Report>> {
    let capture = self::capture(capture, name)?;
    let options = options(definitions, events, schemas, timeline, strict_formats, deny_warnings);
    let checked = run(py, move || checker(&options)?.check(&capture))?;
    Py::new(py, Report::of(checked))
}

#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the function in Python names them")]
fn check_files(
    py: Python<'_>,
    captures: &Bound<'_, PyAny>,
    definitions: Option<std::path::PathBuf>,
    events: Option<std::path::PathBuf>,
    schemas: Vec<std::path::PathBuf>,
    timeline: bool,
    strict_formats: bool,
    deny_warnings: bool,
    jobs: Option<NonZeroUsize>,
) -> PyResult<Results> {
    let captures: Vec<Capture> =
        captures.try_iter()?.map(|item| arguments::item(&item?)).collect::<PyResult<_>>()?;
    let options = options(definitions, events, schemas, timeline, strict_formats, deny_warnings);
    run(py, move || checker(&options)?.check_all(&captures, jobs)).map(Results::from)
}

#[pyfunction]
fn find(py: Python<'_>, inputs: Vec<std::path::PathBuf>) -> PyResult<Table> {
    run(py, move || tables::find(&inputs)).map(Table::from)
}

#[pyfunction]
fn read(
    py: Python<'_>,
    capture: &Bound<'_, PyAny>,
    topic: String,
    instance: u8,
    definitions: Option<std::path::PathBuf>,
) -> PyResult<Table> {
    let capture = self::capture(capture, None)?;
    let options = Options { definitions, ..Options::default() };
    let messages = run(py, move || checker(&options)?.read(&capture, &topic, instance))?;
    Ok(Table::new(messages.schema, messages.batches))
}

#[pyfunction]
fn explain(
    py: Python<'_>,
    capture: &Bound<'_, PyAny>,
    definitions: Option<std::path::PathBuf>,
    events: Option<std::path::PathBuf>,
) -> PyResult<Timeline> {
    let capture = self::capture(capture, None)?;
    let options = Options { definitions, events, has_timeline: true, ..Options::default() };
    run(py, move || checker(&options)?.explain(&capture)).map(Timeline::from)
}

/// The functions and types of the package.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Error", module.py().get_type::<Error>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<Table>()?;
    module.add_class::<Report>()?;
    module.add_class::<Results>()?;
    module.add_class::<Timeline>()?;
    module.add_function(wrap_pyfunction!(check, module)?)?;
    module.add_function(wrap_pyfunction!(check_files, module)?)?;
    module.add_function(wrap_pyfunction!(find, module)?)?;
    module.add_function(wrap_pyfunction!(read, module)?)?;
    module.add_function(wrap_pyfunction!(explain, module)?)?;
    Ok(())
}
