//! The attachment of a message: its number, its time and its publisher.

/// The attachment of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Attachment {
    /// The sequence number that the publisher gave the message.
    pub sequence: i64,
    /// The time of publication, in ns since 1970.
    pub time: i64,
    /// The identifier of the publisher.
    pub publisher: [u8; 16],
}

impl Attachment {
    /// The names before the values, which only some versions of `rmw_zenoh` write.
    const LABELS: [&[u8]; 3] = [b"\x0fsequence_number", b"\x10source_timestamp", b"\x0asource_gid"];

    /// Parses an attachment, with or without labels. `None` if it has another form.
    pub(super) fn parse(bytes: &[u8]) -> Option<Self> {
        let is_labelled = bytes.starts_with(Self::LABELS[0]);
        let mut rest = bytes;
        let mut value = |label: &[u8]| {
            rest = if is_labelled { rest.strip_prefix(label)? } else { rest };
            let (value, tail) = rest.split_first_chunk::<8>()?;
            rest = tail;
            Some(i64::from_le_bytes(*value))
        };
        let (sequence, time) = (value(Self::LABELS[0])?, value(Self::LABELS[1])?);
        rest = if is_labelled { rest.strip_prefix(Self::LABELS[2])? } else { rest };
        let publisher = rest.strip_prefix(&[16])?.try_into().ok()?;
        Some(Self { sequence, time, publisher })
    }

    /// Formats the attachment without labels.
    pub(super) fn format(&self) -> Vec<u8> {
        [&self.sequence.to_le_bytes()[..], &self.time.to_le_bytes(), &[16], &self.publisher].concat()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parses_both_forms_and_nothing_shorter_or_longer() {
        let attachment = Attachment { sequence: 7, time: -1, publisher: [3; 16] };
        let short = attachment.format();
        let labels = Attachment::LABELS;
        let long = [labels[0], &short[..8], labels[1], &short[8..16], labels[2], &short[16..]].concat();
        for form in [&short, &long] {
            assert_eq!(Attachment::parse(form), Some(attachment));
            for length in 0..form.len() {
                assert_eq!(Attachment::parse(&form[..length]), None);
            }
            assert_eq!(Attachment::parse(&[form, &[0][..]].concat()), None);
        }
    }
}
