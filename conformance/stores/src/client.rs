//! The HTTP client of object stores. It follows redirects on the same host only, and limits what servers send.

use std::error::Error;
use std::fmt;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use http_body_util::{BodyExt as _, Limited};
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpResponse, HttpResponseBody,
    HttpService,
};
use object_store::{ClientConfigKey, ClientOptions};
use reqwest::redirect::{Action, Attempt, Policy};
use reqwest::{Certificate, Client, NoProxy, Proxy};
use uavspec_model::text::{shown_url, thousands};

use crate::limits::{MAX_ANSWER, MAX_REDIRECTS, MAX_REQUESTS};

/// An error after which a request isn't repeated: the server exceeds a limit, or redirects to another host. Another
/// attempt would fail in the same way.
#[derive(Debug)]
pub(super) struct Refused(String);

impl fmt::Display for Refused {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

impl Error for Refused {}

impl Refused {
    /// The refusal that caused an error, if any.
    pub(super) fn cause_of<'e>(error: &'e (dyn Error + 'static)) -> Option<&'e Self> {
        let next = |error: &&'e (dyn Error + 'static)| (*error).source();
        std::iter::successors(Some(error), next).find_map(|error| error.downcast_ref())
    }

    fn error(text: String) -> HttpError {
        HttpError::new(HttpErrorKind::Unknown, Self(text))
    }
}

/// The number of further requests that the clients of a store may send. A server can divide a list into any number of
/// parts.
#[derive(Clone, Debug)]
pub(super) struct Budget(Arc<AtomicU64>);

impl Budget {
    /// The budget for reading a list.
    pub(super) fn of_list() -> Self {
        Self(Arc::new(AtomicU64::new(MAX_REQUESTS)))
    }

    /// Removes the limit after the list is complete, because the size of an object already limits the requests for it.
    pub(super) fn end(&self) {
        self.0.store(u64::MAX, Ordering::Relaxed);
    }

    fn take(&self) -> Result<(), HttpError> {
        let left = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        let excess = || {
            format!(
                "listing the folder takes more than {} requests: specify a subfolder",
                thousands(MAX_REQUESTS)
            )
        };
        left.map(drop).map_err(|_| Refused::error(excess()))
    }
}

/// Creates the clients of a store.
#[derive(Debug)]
pub(super) struct Connector(pub(super) Budget);

impl HttpConnector for Connector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let client = client(options)
            .map_err(|error| object_store::Error::Generic { store: "HTTP", source: Box::new(error) })?;
        Ok(HttpClient::new(Bounded { client: HttpClient::new(client), budget: self.0.clone() }))
    }
}

/// A client that limits the number of requests and the size of answers.
#[derive(Debug)]
struct Bounded {
    client: HttpClient,
    budget: Budget,
}

impl Bounded {
    async fn execute(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        self.budget.take()?;
        let (head, body) = self.client.execute(request).await?.into_parts();
        if head.status.is_redirection()
            && let Some(location) = head.headers.get("location")
        {
            let location = shown_url(&String::from_utf8_lossy(location.as_bytes()));
            return Err(Refused::error(format!("the server redirects to {location}: use that URL instead")));
        }
        Ok(HttpResponse::from_parts(head, limited(body, MAX_ANSWER)))
    }
}

impl HttpService for Bounded {
    fn call<'s, 'f>(
        &'s self,
        request: HttpRequest,
    ) -> Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'f>>
    where
        's: 'f,
    {
        Box::pin(self.execute(request))
    }
}

/// The body of an answer. Reading fails if it is too long.
fn limited(body: HttpResponseBody, limit: usize) -> HttpResponseBody {
    let excess = move || format!("the server's answer is longer than {} bytes", thousands(limit));
    HttpResponseBody::new(Limited::new(body, limit).map_err(move |error| match error.downcast() {
        Ok(error) => *error,
        Err(_) => Refused::error(excess()),
    }))
}

/// Creates a client with these options. The store's own client would follow redirects to other hosts, and reveal the
/// URL to them.
fn client(options: &ClientOptions) -> reqwest::Result<Client> {
    use ClientConfigKey as Key;

    let value = |key: Key| options.get_config_value(&key);
    let is_on = |key: Key| value(key).is_some_and(|text| text == "true");
    let mut builder = Client::builder()
        .redirect(Policy::custom(redirected))
        .referer(false)
        .https_only(!is_on(Key::AllowHttp))
        .user_agent(
            value(Key::UserAgent).unwrap_or_else(|| concat!("uavspec/", env!("CARGO_PKG_VERSION")).into()),
        );
    if let Some(url) = value(Key::ProxyUrl) {
        let excluded = value(Key::ProxyExcludes).and_then(|hosts| NoProxy::from_string(&hosts));
        builder = builder.proxy(Proxy::all(url)?.no_proxy(excluded));
        if let Some(certificate) = value(Key::ProxyCaCertificate) {
            builder = builder.tls_certs_merge([Certificate::from_pem(certificate.as_bytes())?]);
        }
    }
    if let Some(time) = value(Key::ConnectTimeout).and_then(|text| seconds(&text)) {
        builder = builder.connect_timeout(time);
    }
    if let Some(time) = value(Key::ReadTimeout).and_then(|text| seconds(&text)) {
        builder = builder.read_timeout(time);
    }
    if let Some(time) = value(Key::Timeout).and_then(|text| seconds(&text)) {
        builder = builder.timeout(time);
    }
    builder.tls_danger_accept_invalid_certs(is_on(Key::AllowInvalidCertificates)).build()
}

/// Decides about a redirect. Requests contain credentials, so only the host that the user named may receive them.
fn redirected(attempt: Attempt<'_>) -> Action {
    let (url, previous) = (attempt.url(), attempt.previous());
    let is_same = previous.last().is_some_and(|from| {
        from.host_str() == url.host_str() && (from.scheme() != "https" || url.scheme() == "https")
    });
    if is_same && previous.len() <= MAX_REDIRECTS { attempt.follow() } else { attempt.stop() }
}

/// A time such as `10 seconds` or `1s`.
fn seconds(text: &str) -> Option<Duration> {
    let (number, unit) = text.split_at(text.find(|character: char| !character.is_ascii_digit())?);
    unit.trim_start().starts_with('s').then(|| number.parse().ok().map(Duration::from_secs))?
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead as _, BufReader, Read as _, Write as _};
    use std::net::TcpListener;
    use std::sync::mpsc::{Receiver, channel};
    use std::thread;

    use futures_util::TryStreamExt as _;
    use object_store::aws::AmazonS3Builder;
    use object_store::{ObjectMeta, ObjectStore as _};
    use uavspec_capture::input::{Failure, Input};

    use super::*;
    use crate::list;

    fn runtime() -> &'static tokio::runtime::Runtime {
        crate::request::runtime().expect("a runtime")
    }

    /// Answers each request with a part of a list. Each part names the next part.
    #[derive(Clone, Debug, Default)]
    struct Endless(Arc<AtomicU64>);

    impl HttpService for Endless {
        fn call<'s, 'f>(
            &'s self,
            _: HttpRequest,
        ) -> Pin<Box<dyn Future<Output = Result<HttpResponse, HttpError>> + Send + 'f>>
        where
            's: 'f,
        {
            let number = self.0.fetch_add(1, Ordering::Relaxed);
            let text = format!(
                "<ListBucketResult><IsTruncated>true</IsTruncated>\
                 <NextContinuationToken>{number}</NextContinuationToken></ListBucketResult>"
            );
            Box::pin(async move { Ok(HttpResponse::new(text.into())) })
        }
    }

    /// A connector whose requests and answers are limited.
    #[derive(Debug)]
    struct Fake(Endless, Budget);

    impl HttpConnector for Fake {
        fn connect(&self, _: &ClientOptions) -> object_store::Result<HttpClient> {
            let client = HttpClient::new(self.0.clone());
            Ok(HttpClient::new(Bounded { client, budget: self.1.clone() }))
        }
    }

    #[test]
    fn lists_end_even_if_their_parts_do_not() {
        let (service, budget) = (Endless::default(), Budget(Arc::new(AtomicU64::new(7))));
        let builder = AmazonS3Builder::new().with_bucket_name("logs").with_region("hill");
        let connector = Fake(service.clone(), budget);
        let store =
            builder.with_skip_signature(true).with_http_connector(connector).build().expect("a store");
        let listed: Result<Vec<ObjectMeta>, _> = runtime().block_on(store.list(None).try_collect());
        let error = listed.expect_err("a list without end");
        let refused = Refused::cause_of(&error).expect("a refusal").to_string();
        assert_eq!(refused, "listing the folder takes more than 10,000 requests: specify a subfolder");
        assert_eq!(service.0.load(Ordering::Relaxed), 7);
    }

    #[test]
    fn answers_have_a_maximum_length() {
        let read = |limit| runtime().block_on(limited(vec![0; 9].into(), limit).bytes());
        assert_eq!(read(9).expect("the bytes").len(), 9);
        let error = read(8).expect_err("a limit");
        let refused = Refused::cause_of(&error).expect("a refusal").to_string();
        assert_eq!(refused, "the server's answer is longer than 8 bytes");
    }

    /// Answers each request with a redirect, or with an object at `/b.ulg`. Returns the URL, and the heads of the requests.
    fn redirecting(location: String) -> (String, Receiver<String>) {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let url = format!("http://{}", listener.local_addr().expect("an address"));
        let (sender, heads) = channel();
        thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let mut head = String::new();
                for line in BufReader::new(&stream).lines().map_while(Result::ok) {
                    if line.is_empty() {
                        break;
                    }
                    head += &(line.to_lowercase() + "\n");
                }
                let answer = if head.contains(" /b.ulg ") {
                    "206 Partial Content\r\nContent-Range: bytes 0-2/3\r\nContent-Length: 3\r\n".to_owned()
                } else {
                    format!("302 Found\r\nLocation: {location}\r\nContent-Length: 0\r\n")
                };
                let body = if head.starts_with("get") && head.contains(" /b.ulg ") { "abc" } else { "" };
                let last_modified = "Last-Modified: Tue, 01 Sep 2026 00:00:00 GMT\r\nConnection: close";
                // The client may have left, and the test may have ended.
                let _ = write!(&stream, "HTTP/1.1 {answer}{last_modified}\r\n\r\n{body}");
                let _ = sender.send(head);
            }
        });
        (url, heads)
    }

    /// Reads the object at `/a.ulg`.
    fn read(root: &str) -> std::io::Result<String> {
        let listed = list(&format!("{root}/a.ulg?token=secret")).expect("an object");
        let [Input::Object(object)] = &listed.captures[..] else { panic!("one object") };
        let mut text = String::new();
        object.open(&Failure::default())?.read_to_string(&mut text)?;
        Ok(text)
    }

    #[test]
    fn redirects_lead_to_the_same_host_only_and_name_no_referer() {
        let (url, heads) = redirecting("/b.ulg".to_owned());
        assert_eq!(read(&url).expect("the object"), "abc");
        let heads: Vec<String> = heads.try_iter().collect();
        assert!(heads.len() == 4 && !heads.concat().contains("referer"), "{heads:?}");

        let other = TcpListener::bind("127.0.0.1:0").expect("a port");
        other.set_nonblocking(true).expect("no waiting");
        let other_url = format!("http://localhost:{}/b.ulg", other.local_addr().expect("an address").port());
        let (url, _heads) = redirecting(format!("{other_url}?sig=secret"));
        let error = read(&url).expect_err("another host");
        assert_eq!(error.to_string(), format!("the server redirects to {other_url}: use that URL instead"));
        assert!(other.accept().is_err(), "nothing connects to the other host");
    }

    #[test]
    fn redirects_end() {
        let (url, heads) = redirecting("/a.ulg".to_owned());
        assert!(read(&url).is_err());
        assert_eq!(heads.try_iter().count(), MAX_REDIRECTS + 1);
    }

    #[test]
    fn reads_times_of_settings() {
        assert_eq!(seconds("10 seconds"), Some(Duration::from_secs(10)));
        assert_eq!(seconds("1s"), Some(Duration::from_secs(1)));
        assert_eq!(seconds("5m"), None);
        assert_eq!(seconds("soon"), None);
    }
}
