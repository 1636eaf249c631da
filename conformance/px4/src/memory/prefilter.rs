//! A fast check of a whole payload. Nearly all payloads pass it, and only the others are examined value by value.

use std::ops::Range;

use super::accepted::Accepted;
use super::{Content, Step};

/// The values at fixed positions, in a compact form.
#[derive(Debug, Default)]
pub(super) struct Prefilter {
    /// The end of the last value, in bytes.
    end: usize,
    /// The ranges of `bool`s.
    bools: Vec<(usize, usize)>,
    others: Vec<Series>,
}

/// Values with the same constraint.
#[derive(Debug)]
struct Series {
    /// The range of the offsets of values.
    starts: Range<usize>,
    stride: usize,
    width: usize,
    accepted: Accepted,
}

impl Prefilter {
    /// Collects the values of steps with fixed positions.
    pub(super) fn new(steps: &[Step]) -> Self {
        let mut prefilter = Self::default();
        for step in steps {
            let Content::Values(values) = &step.content else { continue };
            let (start, stride, width, accepted) =
                (step.offset, step.stride.max(1), values.width, values.accepted);
            let Some(others) = step.count.checked_sub(1) else { continue };
            let last = start + others * stride;
            let end = last + width;
            prefilter.end = prefilter.end.max(end);
            if matches!(accepted, Accepted::Bool) && stride == 1 {
                match prefilter.bools.last_mut() {
                    Some(before) if before.1 == start => before.1 = end,
                    _ => prefilter.bools.push((start, end)),
                }
            } else {
                prefilter.others.push(Series { starts: start..last + 1, stride, width, accepted });
            }
        }
        prefilter
    }

    /// True if all values are guaranteed to produce no findings.
    #[inline]
    pub(super) fn accepts(&self, payload: &[u8]) -> bool {
        let Some(payload) = payload.get(..self.end) else { return false };
        let has_other = |bytes: &[u8]| bytes.iter().fold(0, |all, byte| all | byte) > 1;
        if self.bools.iter().any(|(start, end)| has_other(&payload[*start..*end])) {
            return false;
        }
        self.others.iter().all(|series| {
            let mut starts = series.starts.clone().step_by(series.stride);
            starts.all(|start| series.accepted.accepts(&payload[start..start + series.width]))
        })
    }
}
