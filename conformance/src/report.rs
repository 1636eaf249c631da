//! What came of judging, for people and for programs.

mod json;
mod text;

pub(crate) use json::excuse as excuse_to_json;
pub use json::write as to_json;
pub use text::write as to_text;

use crate::judge::Judgement;

/// A source that was judged.
#[derive(Debug)]
pub struct Judged {
    /// Its path, as it was given.
    pub path: String,
    /// What came of it.
    pub judgement: Judgement,
    /// How long that took, in milliseconds.
    pub elapsed: u128,
}
