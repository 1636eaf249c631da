//! Test results as `JUnit` XML, which GitLab, Jenkins and others display.
//!
//! ```
//! use uavspec_lint::report::junit::{Case, Suite, write};
//!
//! let case = Case::passed("check.PX-RANGE-01", "flight.ulg");
//! let text = write("uavspec", &[Suite { name: "flight.ulg".to_owned(), cases: vec![case] }]);
//! assert!(text.contains("check.PX-RANGE-01"));
//! ```

mod findings;
mod suite;

pub(super) use self::findings::write as of_findings;
pub use self::suite::{Case, Counts, Outcome, Reason, Suite, write};
