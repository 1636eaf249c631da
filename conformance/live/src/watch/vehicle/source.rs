//! The sources of messages: live vehicles and captures.

use std::path::Path;
use std::time::Duration;

use globset::{Glob, GlobSet, GlobSetBuilder};
use uavspec_capture::input::Input;
use uavspec_check::{Checked, Summary, check_input};
use uavspec_model::text::plural;
use uavspec_rules::definitions::Library;

use super::TOPICS;
use super::playback::Watcher;
use crate::bus::{Bus, Event};
use crate::vehicle::{Options, observe};
use crate::watch::fleet::Link;

/// The pause before the next attempt to connect.
const PAUSE: Duration = Duration::from_secs(2);

/// The maximum duration of a connection. The display then reconnects.
const MAX_TIME: Duration = Duration::from_secs(365 * 24 * 60 * 60);

/// Receives the messages of a vehicle, and reconnects if the connection ends. Returns only if the first connection
/// fails, or if `is_stopped` returns true.
pub fn watch_live(
    connect: &dyn Fn() -> Result<Box<dyn Bus>, String>,
    is_stopped: fn() -> bool,
    library: &Library,
    mut watcher: Watcher<'_>,
) {
    let (playback, clock) = (watcher.playback, watcher.clock.clone());
    let on_event = |event: &Event| match event {
        Event::Lost { count, .. } => playback.lose(*count),
        Event::Unreadable(problem) | Event::Problem(problem) => playback.note(problem.clone()),
        Event::Endpoint(_) | Event::Ended(_) | Event::Message(_) | Event::Closed(_) => {}
    };
    let options = Options { topics: topics(), is_stopped: Box::new(is_stopped), ..Options::new(MAX_TIME) };
    let mut is_first = true;
    while !is_stopped() {
        let reason = match connect() {
            Ok(mut bus) => {
                playback.forget_channels();
                playback.set_link(Link::Connected);
                is_first = false;
                match observe(&mut *bus, library, &options, &mut watcher, &on_event) {
                    Ok(reason) => reason.unwrap_or_default(),
                    Err(error) => format!("can't write a temporary file: {error}"),
                }
            }
            Err(problem) => problem,
        };
        playback.set_link(Link::Lost { reason, again: clock.now() + PAUSE });
        if is_first {
            return;
        }
        clock.sleep(PAUSE);
    }
}

/// The patterns of the topics to receive. Newer releases append the message version to topic names.
fn topics() -> Option<GlobSet> {
    let mut set = GlobSetBuilder::new();
    for name in TOPICS {
        for pattern in [format!("**/{name}"), format!("**/{name}_v[0-9]*")] {
            set.add(Glob::new(&pattern).ok()?);
        }
    }
    set.build().ok()
}

/// Replays a capture. `watcher` waits until a message is due.
pub fn replay(path: &Path, library: &Library, mut watcher: Watcher<'_>) {
    let (input, playback) = (Input::Path(path.to_owned()), watcher.playback);
    let observed = check_input(&input, None, library, Some(&mut watcher), &|input| input);
    let ended = observed.map_err(|error| error.to_string()).and_then(|Checked { result, .. }| {
        if let Summary::Unknown(unknown) = result.summary {
            return Err(unknown.reason);
        }
        if !result.corruption.is_empty() {
            let count = plural(result.corruption.len() as u64 + result.more_corruption, "part");
            playback.note(format!("{count} of the capture can't be read"));
        }
        Ok(())
    });
    playback.end(ended);
}
