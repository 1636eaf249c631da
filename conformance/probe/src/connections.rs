//! Opens and closes the connections of a probe, and finds out whether the server still serves them.

use std::io;
use std::time::Duration;

use serde_json::json;
use uavspec_flockwave::record::Trial;
use uavspec_flockwave::transport::client::is_temporary;
use uavspec_flockwave::transport::endpoint::Endpoint;
use uavspec_rules::flockwave::env_27;

use super::on_crash::OnCrash;
use super::session::{self, Path, Session};
use super::{CONNECT_TIMEOUT, PACE, Probe};

/// The delay between attempts to connect.
pub(super) const PAUSE: Duration = Duration::from_millis(250);

/// The maximum time to wait until a server that stopped serving serves again, as a multiple of the timeout.
const RESTART_TIMEOUTS: u32 = 2;

/// The number of times that a server may stop serving before the probe ends.
const MAX_STOPS: u32 = 3;

/// The maximum number of times that a server may stop serving, if a command restarts it.
const MAX_RESTARTS: u32 = 200;

/// The minimum waiting time for a command to restart the server.
const RESTART_LIMIT: Duration = Duration::from_secs(30);

/// The maximum number of reconnections to a server that closes its connections.
const MAX_RECONNECTS: u32 = 20;

/// The cause in reports if the service ended without a message that caused it.
const BY_ITSELF: &str = "by itself";

/// The maximum number of connections that wait for late answers.
const MAX_LINGERING: usize = 16;

impl Probe<'_, '_> {
    /// Opens a new connection. Retries if the server may be starting.
    pub(super) fn connect(&mut self, endpoint: Option<&Endpoint>) -> io::Result<Session> {
        let endpoint = endpoint.unwrap_or(self.endpoint);
        let until = self.clock.now() + CONNECT_TIMEOUT;
        let timeout = self.options.timeout;
        // Over HTTP, the time limit applies to each request.
        let limit = if matches!(endpoint, Endpoint::Http { .. }) { timeout } else { CONNECT_TIMEOUT };
        self.connections += 1;
        loop {
            let path = Path {
                endpoint,
                access: &self.access,
                network: self.network,
                limit,
                patience: timeout,
                stop: &self.stop,
                clock: &self.clock,
            };
            match Session::open(&path, self.connections, &mut self.tape) {
                Err(error)
                    if is_temporary(&error) && self.clock.now() + PAUSE < until && !self.stop.is_due() =>
                {
                    self.sleep(PAUSE);
                }
                opened => return opened,
            }
        }
    }

    /// Records that a connection was refused.
    pub(super) fn refused(
        &mut self,
        endpoint: Option<&Endpoint>,
        error: &io::Error,
        trial: Option<Trial<'_>>,
    ) {
        // An interrupted attempt proves nothing.
        if self.stop.is_due() {
            return;
        }
        let name = session::name(endpoint.unwrap_or(self.endpoint), self.connections);
        self.tape.event(&name, "refused", &error.to_string(), trial);
    }

    /// Ensures that the survey has an open connection. Reconnects if the connection has ended. Returns false if this
    /// fails.
    pub(super) fn ensure_connected(&mut self) -> bool {
        if self.session.as_ref().is_some_and(|session| !session.is_over()) {
            return true;
        }
        if self.failure.is_some() || self.cut_short.is_some() {
            return false;
        }
        if self.reconnects >= MAX_RECONNECTS {
            self.leave();
            self.cut_short(format!("the server closed {MAX_RECONNECTS} connections"));
            return false;
        }
        self.reconnects += 1;
        if let Err(why) = self.reconnect() {
            self.cut_short(why);
            return false;
        }
        // A server that is being shut down may still accept connections. The next request isn't the reason why it
        // stops.
        let is_safe = self.stop.commanded().is_safe();
        if is_safe
            && self.post(&json!({ "type": "SYS-VER" }), None, self.pace()).is_none()
            && !self.stop.is_due()
        {
            return self.recover(BY_ITSELF) && self.ensure_connected();
        }
        true
    }

    /// Replaces the survey's connection, and logs in.
    pub(super) fn reconnect(&mut self) -> Result<(), String> {
        let why = self.session.as_ref().map(Session::why_over);
        self.leave();
        match self.connect(None) {
            Ok(session) => self.session = Some(session),
            Err(error) => {
                self.refused(None, &error, None);
                return Err(format!("can't reconnect: {error}"));
            }
        }
        if let Some(why) = why {
            self.note(format!("{why}; the probe connected again"));
        }
        self.log_in();
        Ok(())
    }

    /// Ends the survey's connection.
    pub(super) fn leave(&mut self) {
        let Some(session) = self.session.take() else { return };
        if session.bare > 0 && !std::mem::replace(&mut self.is_bare, true) {
            self.note("HTTP responses have no envelope; uavspec adds one before checking them".to_owned());
        }
        self.close(session);
    }

    /// Closes a connection. If answers may still arrive, keeps it open until then.
    pub(super) fn close(&mut self, session: Session) {
        self.is_ending |= session.is_announced;
        if !session.is_pending() || self.stop.is_due() {
            return session.close(&mut self.tape);
        }
        self.lingering.push(session);
        let max = if self.is_exclusive { 0 } else { MAX_LINGERING };
        while self.lingering.len() > max {
            self.catch_up();
        }
    }

    /// Reads late answers, and closes the connections on which no more answers can arrive.
    pub(super) fn catch_up(&mut self) {
        if let Some(witness) = &mut self.witness {
            witness.catch_up(&mut self.tape);
        }
        for mut session in std::mem::take(&mut self.lingering) {
            session.catch_up(&mut self.tape);
            if session.is_pending() {
                self.lingering.push(session);
            } else {
                session.close(&mut self.tape);
            }
        }
    }

    /// Waits until the server serves a new connection. If it doesn't, a rule is violated, because a message from one
    /// client must not affect others. Returns false if the probe can't continue.
    pub(super) fn recover(&mut self, after: &str) -> bool {
        self.is_refused = false;
        // A server that has announced its end may be restarting.
        let is_ending = std::mem::take(&mut self.is_ending);
        let trial = (!is_ending).then_some(Trial { rule: &env_27::RULE.rule, how: after });
        let is_reported = trial.is_some_and(|trial| !self.serves_witness(trial));
        if self.serves(trial.filter(|_| !is_reported), self.patience()) {
            if is_reported {
                self.note(format!("the server stopped serving other connections {after}"));
            }
            return true;
        }
        self.stops += 1;
        // The unanswered request has shown whether connections are refused.
        let is_shown = self.is_refused;
        let is_back = self.wait_for_restart(after);
        // Over UDP, a few lost datagrams prove nothing. Many lost datagrams do, and so does an error from the operating
        // system.
        let is_certain = !is_shown && (self.is_refused || !is_back) && !self.is_exclusive;
        if is_certain && matches!(self.endpoint, Endpoint::Udp(_)) {
            let why =
                if self.is_refused { "no server listens on the port" } else { "no answer to many requests" };
            self.refused(None, &io::Error::other(why), trial);
        }
        if !is_back {
            self.cut_short(format!("the server stopped serving {after}"));
        }
        is_back
    }

    /// Waits until a server that stopped serving serves again. Returns false if it doesn't do so in time.
    fn wait_for_restart(&mut self, after: &str) -> bool {
        let stopped_at = self.clock.now();
        let (max, limit) = match &self.options.on_crash {
            Some(_) => (MAX_RESTARTS, RESTART_LIMIT.max(self.patience() * RESTART_TIMEOUTS)),
            None => (MAX_STOPS, self.patience() * RESTART_TIMEOUTS),
        };
        if self.stops >= max || self.stop.is_due() {
            return false;
        }
        let mut command = self.options.on_crash.as_deref().map(OnCrash::start);
        let until = (self.clock.now() + limit).min(self.end);
        while self.clock.now() < until && !self.stop.is_due() {
            self.sleep(PAUSE);
            if let Some(problem) = command.as_mut().and_then(OnCrash::problem) {
                self.note(problem);
                command = None;
            }
            if self.serves(None, PACE) {
                let seconds = ((self.clock.now() - stopped_at) + self.patience()).as_secs();
                self.note(format!("the server stopped serving {after}; it resumed after {seconds} s"));
                return true;
            }
        }
        false
    }

    /// Ensures that the witness is connected and served. Servers may close idle connections.
    pub(super) fn ensure_witness(&mut self) {
        if self.is_exclusive {
            return;
        }
        if let Some(witness) = self.witness.take_if(|witness| witness.is_idle()) {
            self.ask_witness(witness, None);
        }
        // Over UDP and HTTP, a missing answer proves nothing.
        let has_connections = matches!(self.endpoint, Endpoint::Tcp(_) | Endpoint::SocketIo { .. });
        if has_connections
            && self.witness.as_ref().is_none_or(Session::is_over)
            && let Ok(witness) = self.connect(None)
        {
            let session = self.session.replace(witness);
            self.log_in();
            self.witness = std::mem::replace(&mut self.session, session);
        }
    }

    /// Tests whether the server serves a second connection while the witness is open. If it doesn't, no witness is
    /// used.
    pub(super) fn test_witness(&mut self) {
        self.ensure_witness();
        if matches!(self.endpoint, Endpoint::Udp(_)) && !self.serves(None, self.patience()) {
            return self.is_exclusive = true;
        }
        if self.witness.is_none() {
            return;
        }
        // The end of the second connection must not affect the result.
        let is_served = self.serves_while(None, self.patience(), |probe| {
            if let Some(witness) = &mut probe.witness {
                witness.catch_up(&mut probe.tape);
            }
        });
        // A server may also close the older connection.
        let is_lost = self.witness.as_ref().is_some_and(|known| known.is_over() && !known.is_announced);
        if !is_served || is_lost {
            self.is_exclusive = true;
            self.note("the server serves only one connection".to_owned());
            if let Some(witness) = self.witness.take() {
                self.close(witness);
            }
        }
    }

    /// True if the server answers on the connection of the witness, or if there is no witness.
    pub(super) fn serves_witness(&mut self, trial: Trial<'_>) -> bool {
        let Some(mut witness) = self.witness.take() else { return true };
        witness.catch_up(&mut self.tape);
        if witness.is_over() {
            // An interrupted control proves nothing.
            let is_lost =
                !witness.is_announced && !self.closes_connections(witness.idle_time()) && !self.stop.is_due();
            if is_lost {
                let why = "the server closed the connection of another client";
                self.tape.event(&witness.name, "refused", why, Some(trial));
            }
            return !is_lost;
        }
        self.ask_witness(witness, Some(trial))
    }

    /// True if the server closes a connection that is idle for this time, even without a trial. Servers may close idle
    /// connections, and older connections of the same client.
    fn closes_connections(&mut self, time: Duration) -> bool {
        let Ok(control) = self.connect(None) else { return false };
        let session = self.session.replace(control);
        self.log_in();
        let is_served = self.post(&json!({ "type": "SYS-VER" }), None, self.patience()).is_some();
        let control = std::mem::replace(&mut self.session, session);
        let Some(mut control) = control else { return false };
        if is_served {
            // A trial also opens a connection. This connection stays open, because its end must not affect the control.
            self.serves_while(None, self.patience(), |probe| {
                probe.sleep(time + PAUSE);
                control.catch_up(&mut probe.tape);
            });
        }
        let is_closed = is_served && control.is_over();
        self.close(control);
        is_closed
    }

    /// Sends a request on the connection of the witness. If there is no answer, the connection stops being the witness.
    /// Returns true if there is an answer.
    fn ask_witness(&mut self, witness: Session, trial: Option<Trial<'_>>) -> bool {
        let session = self.session.replace(witness);
        let is_served = self.post(&json!({ "type": "SYS-VER" }), trial, self.patience()).is_some();
        match std::mem::replace(&mut self.session, session) {
            Some(witness) if !is_served => self.close(witness),
            witness => self.witness = witness,
        }
        is_served
    }

    /// True if the server answers on a new connection.
    pub(super) fn serves(&mut self, trial: Option<Trial<'_>>, patience: Duration) -> bool {
        self.serves_while(trial, patience, |_| {})
    }

    /// Like [`serves`](Self::serves), but calls `while_open` before the new connection is closed.
    fn serves_while(
        &mut self,
        trial: Option<Trial<'_>>,
        patience: Duration,
        while_open: impl FnOnce(&mut Self),
    ) -> bool {
        let survey = self.session.take();
        let is_served = match self.connect(None) {
            Ok(session) => {
                self.session = Some(session);
                self.log_in();
                let is_served = self.post(&json!({ "type": "SYS-VER" }), trial, patience).is_some();
                // If no server uses a UDP port, the operating system reports this.
                self.is_refused |= !is_served && self.session.as_ref().is_some_and(Session::is_over);
                is_served
            }
            Err(error) => {
                self.refused(None, &error, trial);
                false
            }
        };
        while_open(self);
        self.leave();
        self.session = survey;
        is_served
    }
}
