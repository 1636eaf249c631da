//! Identifies findings across runs, so that CI systems recognize findings that moved to another line.

use std::collections::HashMap;

use sha2::{Digest as _, Sha256};

use super::model::Entry;

/// The number of bytes of the hash in a fingerprint.
const LEN: usize = 16;

/// Creates the fingerprints of the findings in one report, which are all different.
#[derive(Debug, Default)]
pub(super) struct Fingerprints {
    /// The number of findings with each hash.
    seen: HashMap<[u8; LEN], u32>,
}

impl Fingerprints {
    /// The fingerprint of the next finding: a hash and a number, which distinguishes equal findings.
    pub(super) fn of(&mut self, entry: &Entry) -> String {
        let hash = hash(entry);
        let count = self.seen.entry(hash).and_modify(|count| *count += 1).or_insert(1);
        let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        format!("{hash}:{count}")
    }
}

/// The identity of a finding, independent of its line.
fn hash(entry: &Entry) -> [u8; LEN] {
    let mut hash = Sha256::new();
    for part in [&*entry.rule, entry.category.unwrap_or_default(), &entry.place.path, &entry.message] {
        // Include the lengths, so that different lists of parts never produce the same bytes.
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    let hash = hash.finalize();
    std::array::from_fn(|at| hash.get(at).copied().unwrap_or_default())
}
