//! Passes the records of a capture to code other than rules.

use std::sync::Arc;

use uavspec_flockwave::record::SessionRecord;
use uavspec_model::{Channel, Message};
use uavspec_px4::event::EventMetadata;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::px4::Interest;

/// Receives the records of a capture in addition to the rules. Times are in µs, by the clock of the capture.
pub trait Observer {
    /// Handles a new channel, and returns the observer's interest in it.
    fn opened(&mut self, channel: &Channel<'_>, definitions: &Definitions) -> Interest;

    /// Handles a channel whose release is unknown. The observer doesn't receive its messages.
    fn undecided(&mut self, _channel: &Channel<'_>, _definitions: &Definitions) {}

    /// Receives the event metadata, before the messages that it applies to.
    fn metadata(&mut self, _metadata: &Arc<EventMetadata>) {}

    /// Receives a message of any channel.
    fn message(
        &mut self,
        channel: &Channel<'_>,
        message: &Message<'_>,
        time: Option<u64>,
        definitions: &Definitions,
    );

    /// Receives a line of text in a log. `level` is a syslog level, from 0 to 7.
    fn text(&mut self, _level: u8, _text: &str, _time: u64) {}

    /// Receives a record of a session.
    fn session_record(&mut self, record: &SessionRecord<'_>, time: Option<u64>, definitions: &Definitions);
}
