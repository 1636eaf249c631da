//! The results of the functions.

use pyo3::prelude::*;
use uavspec_report::Kind;
use uavspec_tables::{self as tables, Checked, Tables};

use crate::Error;
use crate::table::Table;

/// The table with this name. Python keeps it alive as long as it is used.
fn table(tables: &Tables, name: &str) -> PyResult<Table> {
    let missing = || Error::new_err(format!("there is no table `{name}`: pass timeline=True"));
    tables.get(name).cloned().map(Table::from).ok_or_else(missing)
}

/// The tables of several captures.
#[pyclass(frozen, subclass, module = "uavspec")]
pub(crate) struct Results(Tables);

impl From<Tables> for Results {
    fn from(tables: Tables) -> Self {
        Self(tables)
    }
}

#[pymethods]
impl Results {
    #[getter]
    fn captures(&self) -> PyResult<Table> {
        table(&self.0, "captures")
    }

    #[getter]
    fn failures(&self) -> PyResult<Table> {
        table(&self.0, "failures")
    }

    #[getter]
    fn topics(&self) -> PyResult<Table> {
        table(&self.0, "topics")
    }

    #[getter]
    fn findings(&self) -> PyResult<Table> {
        table(&self.0, "findings")
    }

    #[getter]
    fn rules(&self) -> PyResult<Table> {
        table(&self.0, "rules")
    }

    #[getter]
    fn timeline(&self) -> PyResult<Table> {
        table(&self.0, "timeline")
    }

    #[getter]
    fn events(&self) -> PyResult<Table> {
        table(&self.0, "events")
    }

    fn __repr__(&self) -> String {
        let rows = |name| self.0.get(name).map_or(0, arrow_array::RecordBatch::num_rows);
        format!("<uavspec.Results: {} captures, {} failures>", rows("captures"), rows("failures"))
    }
}

/// The report of a capture, with its tables.
#[pyclass(frozen, extends = Results, module = "uavspec")]
pub(crate) struct Report(uavspec_report::Report);

impl Report {
    pub(crate) fn of(checked: Checked) -> PyClassInitializer<Self> {
        PyClassInitializer::from(Results(checked.tables)).add_subclass(Self(checked.report))
    }
}

#[pymethods]
impl Report {
    #[getter]
    fn outcome(&self) -> &'static str {
        self.0.outcome.kind.name()
    }

    #[getter]
    fn text(&self) -> &str {
        &self.0.outcome.text
    }

    fn to_json(&self) -> String {
        self.0.to_text(Kind::Json)
    }

    fn __str__(&self) -> String {
        self.0.to_plain_text()
    }

    fn __repr__(&self) -> String {
        format!("<uavspec.Report: {}>", self.0.outcome.text)
    }
}

/// The timeline of a capture.
#[pyclass(frozen, module = "uavspec")]
pub(crate) struct Timeline(tables::Timeline);

impl From<tables::Timeline> for Timeline {
    fn from(timeline: tables::Timeline) -> Self {
        Self(timeline)
    }
}

#[pymethods]
impl Timeline {
    #[getter]
    fn timeline(&self) -> Table {
        self.0.timeline.clone().into()
    }

    #[getter]
    fn events(&self) -> Table {
        self.0.events.clone().into()
    }

    fn to_json(&self) -> &str {
        &self.0.json
    }

    fn __str__(&self) -> &str {
        &self.0.text
    }
}
