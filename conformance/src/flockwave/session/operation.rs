//! Operations that go on after the response.

/// How an operation stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Stage {
    /// It goes on.
    #[default]
    Open,
    /// It waits for the client.
    Suspended,
    /// It waited, and the client has asked to resume or cancel it.
    Released,
    /// Its end was told.
    Ended,
    /// Something was said of it, but no reply has had its receipt.
    Early,
}

/// An operation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Operation {
    /// The type of the reply that had its receipt, where that is known.
    pub type_name: Option<String>,
    /// How it stands.
    pub stage: Stage,
    /// Whether it was said to be suspended, or that may have been said.
    pub was_suspended: bool,
}

/// A receipt that a message names.
#[derive(Clone, Debug)]
pub(crate) struct Named {
    /// The receipt.
    pub receipt: String,
    /// How the operation stood before, where one was known.
    pub before: Option<Operation>,
    /// Whether one would be known if there were one.
    pub is_known: bool,
}

impl Named {
    /// How the operation stood before.
    pub(crate) fn stage(&self) -> Option<Stage> {
        self.before.as_ref().map(|operation| operation.stage)
    }
}
