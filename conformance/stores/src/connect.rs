//! Connects to object stores, and lists their objects.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use futures_util::TryStreamExt as _;
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::azure::{AzureConfigKey, MicrosoftAzureBuilder};
use object_store::gcp::{GoogleCloudStorageBuilder, GoogleConfigKey};
use object_store::http::HttpBuilder;
use object_store::path::Path as Location;
use object_store::{
    ClientConfigKey, ClientOptions, ObjectMeta, ObjectStore, ObjectStoreExt as _, ObjectStoreScheme,
    RetryConfig,
};
use uavspec_capture::input::{Failure, Input, Listed, Object as _};
use uavspec_capture::names::is_capture;
use uavspec_model::text::{shown_url, thousands, utf8};
use url::{Position, Url};

use crate::client::{Budget, Connector};
use crate::limits::{MAX_LIST, MAX_SERVERS};
use crate::object::Object;
use crate::request::{attempts, runtime, text};

/// The time limits of a request. The other settings come from the environment.
const LIMITS: [(ClientConfigKey, &str); 3] = [
    (ClientConfigKey::ConnectTimeout, "10 seconds"),
    // The maximum time during which no data arrives.
    (ClientConfigKey::ReadTimeout, "20 seconds"),
    (ClientConfigKey::Timeout, "300 seconds"),
];

/// The maximum time for all attempts of a request.
const RETRIES: Duration = Duration::from_secs(120);

/// Lists the captures that a URL denotes: a capture, the objects in a folder, or the lines of a list on a web server.
///
/// # Errors
/// The text describes the problem, without credentials.
pub fn list(url: &str) -> Result<Listed, String> {
    let url = Url::parse(url).map_err(|error| format!("not a URL: {error}"))?;
    let (scheme, location) = ObjectStoreScheme::parse(&url).map_err(|error| text(&error.into()))?;
    let budget = Budget::of_list();
    let store = connect(&url, &scheme, &budget)?;
    let is_single = is_capture(Path::new(location.as_ref()));
    if matches!(scheme, ObjectStoreScheme::Http) {
        budget.end();
        let object = Object::new(&store, location, shown(&url), None);
        return if is_single { Ok(single(object)) } else { read_list(&url, &object) };
    }
    let runtime = runtime().map_err(|error| error.to_string())?;
    if is_single {
        let meta = runtime.block_on(store.head(&location)).map_err(|error| text(&error))?;
        budget.end();
        return Ok(single(Object::new(&store, location, shown(&url), Some(meta.into()))));
    }
    let read = || read_folder(&store, &url, &location, MAX_LIST);
    let mut listed = runtime.block_on(attempts(read)).map_err(|error| text(&error))??;
    budget.end();
    // The order differs between stores.
    listed.captures.sort_by_key(Input::name);
    listed.skipped.sort();
    Ok(listed)
}

/// Lists the objects in a folder. Fails if the URLs are longer than `limit` bytes.
async fn read_folder(
    store: &Arc<dyn ObjectStore>,
    url: &Url,
    folder: &Location,
    limit: u64,
) -> object_store::Result<Result<Listed, String>> {
    let (mut listed, mut length) = (Listed::default(), 0);
    let mut objects = store.list(Some(folder));
    while let Some(meta) = objects.try_next().await? {
        length += add(&mut listed, store, url, meta);
        if length > limit {
            let problem =
                format!("the URLs in the folder have more than {} bytes in total", thousands(limit));
            return Ok(Err(problem + ": specify a subfolder"));
        }
    }
    Ok(Ok(listed))
}

/// Adds an object in the store of a URL. Returns the length of its URL.
fn add(listed: &mut Listed, store: &Arc<dyn ObjectStore>, url: &Url, meta: ObjectMeta) -> u64 {
    let url = url_of(url, &meta.location);
    let length = url.len() as u64;
    if is_capture(Path::new(meta.location.as_ref())) {
        let object = Object::new(store, meta.location.clone(), url, Some(meta.into()));
        listed.captures.push(Input::Object(Arc::new(object)));
    } else {
        listed.skipped.push(url);
    }
    length
}

fn single(object: Object) -> Listed {
    Listed { captures: vec![Input::Object(Arc::new(object))], skipped: Vec::new() }
}

/// Reads the text of a list. Fails if it is longer than `limit` bytes.
fn read_text(reader: impl Read, limit: u64) -> Result<String, String> {
    let mut bytes = Vec::new();
    reader.take(limit + 1).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
    if bytes.len() as u64 > limit {
        return Err(format!("the list is longer than {} bytes", thousands(limit)));
    }
    utf8(&bytes).map(str::to_owned)
}

/// Reads a list with a URL in each line. URLs may be relative to the URL of the list.
fn read_list(url: &Url, object: &Object) -> Result<Listed, String> {
    let reader = object.open(&Failure::default()).map_err(|error| error.to_string())?;
    let list = read_text(reader, MAX_LIST)?;
    let mut listed = Listed::default();
    let mut stores: Vec<(Url, Arc<dyn ObjectStore>)> = Vec::new();
    for (number, line) in (1..).zip(list.lines()) {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let url =
            url.join(line).map_err(|error| format!("line {number} of the list is not a URL: {error}"))?;
        let failed = |error: String| format!("line {number} of the list: {error}");
        let (scheme, location) =
            ObjectStoreScheme::parse(&url).map_err(|error| failed(text(&error.into())))?;
        if !is_capture(Path::new(location.as_ref())) {
            listed.skipped.push(shown(&url));
            continue;
        }
        let same = |(other, _): &&(Url, _)| other[..Position::BeforePath] == url[..Position::BeforePath];
        let store = if let Some((_, store)) = stores.iter().find(same) {
            Arc::clone(store)
        } else {
            if stores.len() >= MAX_SERVERS {
                return Err(failed(format!("more than {MAX_SERVERS} servers and buckets")));
            }
            let budget = Budget::of_list();
            budget.end();
            let store = connect(&url, &scheme, &budget).map_err(failed)?;
            stores.push((url.clone(), Arc::clone(&store)));
            store
        };
        let object = Object::new(&store, location, shown(&url), None);
        listed.captures.push(Input::Object(Arc::new(object)));
    }
    Ok(listed)
}

/// Connects to the store of a URL. Credentials come from the environment or, on a cloud machine, from its metadata
/// service.
fn connect(url: &Url, scheme: &ObjectStoreScheme, budget: &Budget) -> Result<Arc<dyn ObjectStore>, String> {
    prepare_tls();
    let connector = Connector(budget.clone());
    let retry = RetryConfig { retry_timeout: RETRIES, ..RetryConfig::default() };
    /// Builds a store with the limits.
    macro_rules! build {
        ($builder:expr, $key:expr) => {
            LIMITS
                .into_iter()
                .fold($builder.with_url(url.as_str()), |builder, (key, time)| {
                    builder.with_config($key(key), time)
                })
                .with_retry(retry)
                .with_http_connector(connector)
                .build()
                .map(|store| Arc::new(store) as Arc<dyn ObjectStore>)
        };
    }
    let store = match scheme {
        ObjectStoreScheme::AmazonS3 => build!(AmazonS3Builder::from_env(), AmazonS3ConfigKey::Client),
        ObjectStoreScheme::GoogleCloudStorage => {
            build!(GoogleCloudStorageBuilder::from_env(), GoogleConfigKey::Client)
        }
        ObjectStoreScheme::MicrosoftAzure => {
            build!(MicrosoftAzureBuilder::from_env(), AzureConfigKey::Client)
        }
        ObjectStoreScheme::Http => {
            let options = ClientOptions::new().with_allow_http(true);
            let options =
                LIMITS.into_iter().fold(options, |options, (key, time)| options.with_config(key, time));
            let builder =
                HttpBuilder::new().with_url(root(url)).with_client_options(options).with_retry(retry);
            builder.with_http_connector(connector).build().map(|store| Arc::new(store) as _)
        }
        _ => return Err("expected s3://, gs://, az://, or https://".to_owned()),
    };
    store.map_err(|error| text(&error))
}

/// Selects the implementation of TLS.
fn prepare_tls() {
    // An implementation may be selected already.
    let _ = rustls::crypto::ring::default_provider().install_default();
}

/// The bucket or server of a URL, and the container of an Azure URL.
fn root(url: &Url) -> String {
    url[..Position::BeforePath].to_owned()
}

/// A URL without its query and its password.
fn shown(url: &Url) -> String {
    shown_url(url.as_str())
}

/// The URL by which [`list`] finds an object in the same store.
fn url_of(url: &Url, location: &Location) -> String {
    let mut url = url.clone();
    // In names, a percent sign doesn't start an escape sequence.
    url.set_path(&location.as_ref().replace('%', "%25"));
    shown(&url)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_have_a_maximum_length() {
        assert_eq!(read_text(&b"a.ulg\n"[..], 6).as_deref(), Ok("a.ulg\n"));
        let problem = read_text(&b"a.ulg\nb.ulg\n"[..], 6);
        assert_eq!(problem, Err("the list is longer than 6 bytes".to_owned()));
        assert_eq!(read_text(&b"\xff"[..], 6), Err("invalid UTF-8 at byte 0".to_owned()));
    }

    #[test]
    fn the_url_of_an_object_denotes_it() {
        for root in
            ["s3://logs/2026/", "https://host.example/list.txt", "abfss://logs@account.dfs.core.windows.net/"]
        {
            let root = Url::parse(root).expect("a URL");
            for name in ["a.ulg", "2026/a b.ulg", "ä #?%41+&.ulg", "%"] {
                let location = Location::parse(name).expect("a name");
                let url = Url::parse(&url_of(&root, &location)).expect("a URL");
                assert_eq!(ObjectStoreScheme::parse(&url).expect("a store").1, location);
                assert_eq!(url[..Position::BeforePath], root[..Position::BeforePath]);
            }
        }
    }
}
