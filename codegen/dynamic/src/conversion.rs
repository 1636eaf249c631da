//! Conversions of messages between two packages, such as two releases of PX4.
//!
//! [`Conversions::between`] matches the messages of two packages like [`breaking`](mod@crate::breaking), and decides for
//! each field of the target how to get its value. A [`Conversion`] is plain data: it refers to fields by index, and
//! contains no offsets. Code generators and programs that convert data at run time use the same conversions.
//!
//! Only the definitions and the [`Hints`] determine a conversion. Parts that they leave open are [`Undecided`].
//!
//! ```
//! use uavspec_dynamic::conversion::{Conversions, Hints, Step};
//! use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//!
//! let mut sources = SourceMap::default();
//! let packages = [("old", "uint8 count\n"), ("new", "bool is_full\nuint8 count\n")].map(|(name, text)| {
//!     let id = sources.add(format!("{name}/Tank.msg"), text.into()).unwrap();
//!     PackageInput::new(name, Form::Msg(Dialect::Px4), vec![id])
//! });
//! let (schema, _) = read(&sources, &packages);
//! let conversions = Conversions::within(&schema, "old", "new", &Hints::default()).unwrap();
//! let conversion = &conversions.forward[0];
//! assert!(conversion.is_decided());
//! assert!(matches!(conversion.steps[1], Step::Copy(_)));
//! assert_eq!(conversions.backward[0].losses[0].text, "`is_full` is dropped");
//! ```

mod build;
mod expression;
mod hints;
mod memory;
mod plan;
mod request;

pub use self::build::{Applied, Conversions, Version};
pub use self::expression::{Binary, Computed, Expression, Unary, ValueKind};
pub use self::hints::{Hints, Mistake, read as read_hints};
pub use self::memory::{Converter, TooLarge};
pub use self::plan::{
    Conversion, Copy, CountLimit, Elements, Loss, LossKind, Narrowing, Neutral, Step, Undecided,
};
pub use self::request::{Answer, Request, answer};
