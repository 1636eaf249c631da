//! Skips the padding after compressed data.

use std::io::{self, BufRead};

/// Skips zeros, which some storage adds after the end of compressed data. Returns false at the end of the input.
pub(super) fn skip_zeros(input: &mut impl BufRead) -> io::Result<bool> {
    loop {
        let ahead = input.fill_buf()?;
        let zeros = ahead.iter().take_while(|byte| **byte == 0).count();
        let (is_end, is_all) = (ahead.is_empty(), zeros == ahead.len());
        input.consume(zeros);
        if is_end || !is_all {
            return Ok(!is_end);
        }
    }
}
