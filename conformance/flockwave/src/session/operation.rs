//! Operations that continue after the response.

/// The stage of an operation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// In progress.
    #[default]
    Open,
    /// Waiting for the client.
    Suspended,
    /// The operation was suspended; then the client requested to resume or cancel it.
    Released,
    /// Ended.
    Ended,
    /// A message reported on the operation before a response issued the operation's receipt.
    Early,
}

/// An operation.
#[derive(Clone, Debug, Default)]
pub struct Operation {
    /// The type of the response that issued the operation's receipt, if known. Unknown for a receipt of several types.
    pub type_name: Option<String>,
    /// The stage.
    pub stage: Stage,
    /// True if the operation was, or may have been, reported as suspended.
    pub was_suspended: bool,
    /// True if a message reported its end, also before the receipt was issued.
    pub has_ended: bool,
    /// True if the server has refused to resume the operation.
    pub has_refused_resume: bool,
}

/// A receipt in a message.
#[derive(Clone, Debug)]
pub struct Named {
    /// The receipt.
    pub receipt: String,
    /// The previous state of the operation, if it was known.
    pub before: Option<Operation>,
    /// False if the session may have missed or forgotten an earlier operation with this receipt.
    pub is_known: bool,
}

impl Named {
    /// True if a message reported the end of the operation before the receipt was issued.
    pub fn has_ended_early(&self) -> bool {
        self.before.as_ref().is_some_and(|known| known.stage == Stage::Early && known.has_ended)
    }

    /// The previous stage of the operation.
    pub fn stage(&self) -> Option<Stage> {
        self.before.as_ref().map(|operation| operation.stage)
    }
}
