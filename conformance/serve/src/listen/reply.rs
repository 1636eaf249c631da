//! Replies to HTTP requests.

use uavspec_flockwave::transport::http::Response;

use super::Shared;

/// The reply to a request.
pub(super) enum Reply {
    /// The response.
    Now(Response),
    /// The response follows later.
    Later(Box<dyn Pending>),
}

/// A request that waits for its response.
pub(super) trait Pending {
    /// True if the response may be available.
    fn is_due(&self) -> bool;

    /// The response, if it is available.
    fn response(&mut self, shared: &mut Shared) -> Option<Response>;

    /// Ends the request, because its client has disconnected.
    fn end(&mut self, _shared: &mut Shared) {}
}
