//! Operations that continue after the response.

use std::collections::BTreeSet;

use uavspec_model::json::Tree;

use super::remembered::ById;
use super::request::strings;
use super::{Exchange, MAX_ID, SentRequest};
use crate::limits::MAX_RECEIPTS;

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
    /// The type of the response that issued the operation's receipt. `None` if it is unknown, or if responses of
    /// several types issued the receipt.
    pub type_name: Option<String>,
    /// The stage.
    pub stage: Stage,
    /// True if the operation was, or may have been, reported as suspended.
    pub was_suspended: bool,
    /// True if a message reported the operation's end, even before the receipt was issued.
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

/// The operations of all connections, by connection and receipt.
#[derive(Debug)]
pub(super) struct Operations(ById<Operation>);

impl Operations {
    /// Creates an empty list with a size limit in bytes.
    pub(super) fn new(limit: usize) -> Self {
        Self(ById::new(limit))
    }

    /// Forgets all operations.
    pub(super) fn clear(&mut self) {
        self.0.clear();
    }

    /// Marks operations as released if a client resumes or cancels them.
    pub(super) fn release(&mut self, serial: u64, request: &SentRequest) {
        if !matches!(request.type_name.as_deref(), Some("ASYNC-RESUME" | "ASYNC-CANCEL")) {
            return;
        }
        for receipt in request.objects.iter().flatten() {
            if let Some(operation) = self.0.get_mut(&(serial, receipt.clone()))
                && operation.stage == Stage::Suspended
            {
                operation.stage = Stage::Released;
            }
        }
    }

    /// Handles a response of the server.
    pub(super) fn answer(&mut self, exchange: &mut Exchange<'_>, serial: u64) {
        self.resume(exchange, serial);
        self.start(exchange, serial);
    }

    /// Updates the operations that a client resumed or cancelled.
    fn resume(&mut self, exchange: &mut Exchange<'_>, serial: u64) {
        if !matches!(exchange.type_name, Some("ASYNC-CANCEL" | "ASYNC-RESUME")) {
            return;
        }
        if let Some(Tree::Object(refused)) = exchange.field("error")
            && exchange.type_name == Some("ASYNC-RESUME")
        {
            for (receipt, _) in refused {
                if let Some(operation) = self.0.get_mut(&(serial, receipt.to_string())) {
                    operation.has_refused_resume = true;
                }
            }
        }
        for receipt in strings(exchange.field("success")).unwrap_or_default() {
            let operation = self.0.get_mut(&(serial, receipt.clone()));
            let before = operation.as_deref().cloned();
            // The operation may have been suspended after the request.
            if let Some(operation) = operation.filter(|known| known.stage == Stage::Suspended) {
                operation.stage = Stage::Released;
            }
            exchange.operations.push(Named {
                receipt,
                before,
                is_known: exchange.record.connection.is_ordered,
            });
        }
    }

    /// Records the operations that a response starts.
    fn start(&mut self, exchange: &mut Exchange<'_>, serial: u64) {
        let receipts: Vec<String> = match exchange.field("receipt") {
            Some(Tree::Text(receipt)) => vec![receipt.to_string()],
            Some(Tree::Object(members)) => {
                members.iter().filter_map(|(_, receipt)| Some(receipt.as_str()?.to_owned())).collect()
            }
            _ => return,
        };
        for receipt in receipts.into_iter().take(MAX_RECEIPTS).filter(|receipt| receipt.len() <= MAX_ID) {
            let before = self.0.remove(&(serial, receipt.clone()));
            // If operations of several types had this receipt, a notification doesn't say which one it is about. Other
            // operations may be pending even after one has ended.
            let is_shared = before.as_ref().is_some_and(|operation| {
                operation.stage != Stage::Early && operation.type_name.as_deref() != exchange.type_name
            });
            let type_name = exchange.type_name.filter(|_| !is_shared).map(str::to_owned);
            let size = receipt.len() + type_name.as_ref().map_or(0, String::len);
            // A notification may overtake the response.
            let early = before.as_ref().filter(|operation| operation.stage == Stage::Early);
            let (stage, was_suspended) = match early {
                Some(early) if early.has_ended => (Stage::Ended, early.was_suspended),
                Some(Operation { was_suspended: true, .. }) => (Stage::Suspended, true),
                _ => (Stage::Open, false),
            };
            let operation = Operation { type_name, stage, was_suspended, ..Operation::default() };
            self.0.insert((serial, receipt.clone()), operation, size);
            exchange.opened.push(Named { receipt, before, is_known: exchange.record.connection.is_ordered });
        }
    }

    /// Handles a notification. `is_whole` is true if all records of the connection are known.
    pub(super) fn notification(&mut self, exchange: &mut Exchange<'_>, serial: u64, is_whole: bool) {
        let receipts: Vec<String> = match (exchange.type_name, exchange.body) {
            (Some("ASYNC-RESP" | "ASYNC-ST"), Some(body)) => {
                body.get("id").and_then(Tree::as_str).map(str::to_owned).into_iter().collect()
            }
            (Some("ASYNC-TIMEOUT"), Some(body)) => strings(body.get("ids")).unwrap_or_default(),
            _ => return,
        };
        let is_suspended = exchange.field("suspended") == Some(&Tree::Bool(true));
        let is_final = exchange.type_name != Some("ASYNC-ST");
        let is_known = is_whole && !self.0.has_forgotten();
        let mut seen = BTreeSet::new();
        // A separate rule covers receipts that a message names twice.
        let receipts = receipts.into_iter().filter(|receipt| seen.insert(receipt.clone()));
        for receipt in receipts.take(MAX_RECEIPTS).filter(|receipt| receipt.len() <= MAX_ID) {
            let before = self.0.remove(&(serial, receipt.clone()));
            let stage = match &before {
                None if is_known => Stage::Early,
                Some(Operation { stage: Stage::Early, .. }) => Stage::Early,
                _ if is_final => Stage::Ended,
                _ if is_suspended => Stage::Suspended,
                None => Stage::Open,
                // A progress report on a suspended operation may omit `suspended`, so the operation may still be
                // suspended.
                Some(operation) => operation.stage,
            };
            let known = before.clone().unwrap_or_default();
            let was_suspended = known.was_suspended || is_suspended || !is_known;
            let size = receipt.len() + known.type_name.as_ref().map_or(0, String::len);
            let has_ended = known.has_ended || is_final;
            let operation = Operation { stage, was_suspended, has_ended, ..known };
            self.0.insert((serial, receipt.clone()), operation, size);
            exchange.operations.push(Named { receipt, before, is_known });
        }
    }
}
