//! The one HTTP client: TLS by rustls, a deadline and a size for every answer, guarded names.

use std::io::ErrorKind;
use std::time::Duration;

use secrecy::ExposeSecret as _;
use ureq::http::{HeaderMap, HeaderValue};
use ureq::unversioned::resolver::{DefaultResolver, ResolvedSocketAddrs, Resolver};
use ureq::unversioned::transport::{DefaultConnector, NextTimeout};
use ureq::{Agent, Error, Timeout};

use super::address::is_public;
use crate::config::may_carry_keys;
use crate::transport::{Limits, Method, Reach, Request, Response, Transport, TransportError};

/// Longest wait for a connection.
pub const CONNECT: Duration = Duration::from_secs(10);

/// Sends requests for real, one connection each. Proxies are not used, so that the address that
/// was judged is the address that is spoken to; redirects come back as they are.
pub struct Http {
    anybody: Agent,
    public: Agent,
}

impl Default for Http {
    fn default() -> Self {
        let config = || {
            let builder = Agent::config_builder().http_status_as_error(false).max_redirects(0);
            let builder = builder.proxy(None).timeout_connect(Some(CONNECT));
            let agent = concat!("kinfold/", env!("CARGO_PKG_VERSION"));
            // A kept connection may die under a paid request, and nobody could say how far it got.
            builder.max_idle_connections(0).user_agent(agent)
        };
        let anybody = Agent::new_with_config(config().build());
        let guarded = config().https_only(true).build();
        let public =
            Agent::with_parts(guarded, DefaultConnector::default(), PublicNames::default());
        Self { anybody, public }
    }
}

impl Transport for Http {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        if !request.secrets.is_empty() && !may_carry_keys(&request.url) {
            return Err(TransportError::refused(request, PLAIN));
        }
        let agent = match request.limits.reach {
            Reach::Configured => &self.anybody,
            Reach::Public => &self.public,
        };
        exchange(agent, request).map_err(|error| explained(request, &error))
    }
}

fn exchange(agent: &Agent, request: &Request) -> Result<Response, Error> {
    let Limits { deadline, max_bytes, .. } = request.limits;
    let method = match request.method {
        Method::Get => "GET",
        Method::Post => "POST",
    };
    let mut outgoing = ureq::http::Request::builder().method(method).uri(&request.url);
    for (name, value) in &request.headers {
        outgoing = outgoing.header(name, value);
    }
    for (name, value) in &request.secrets {
        let mut value = HeaderValue::from_str(value.expose_secret()).map_err(unsendable)?;
        value.set_sensitive(true);
        outgoing = outgoing.header(name, value);
    }
    let response = if request.body.is_empty() && request.method == Method::Get {
        let outgoing = outgoing.body(()).map_err(Error::Http)?;
        agent.run(agent.configure_request(outgoing).timeout_global(Some(deadline)).build())?
    } else {
        let outgoing = outgoing.body(request.body.as_slice()).map_err(Error::Http)?;
        agent.run(agent.configure_request(outgoing).timeout_global(Some(deadline)).build())?
    };
    let (head, body) = response.into_parts();
    let body = body.into_with_config().limit(max_bytes).read_to_vec()?;
    Ok(Response { status: head.status.as_u16(), headers: plain(&head.headers), body })
}

/// The library's own words could quote the value.
fn unsendable(_: ureq::http::header::InvalidHeaderValue) -> Error {
    Error::Io(std::io::Error::new(ErrorKind::InvalidInput, UNSENDABLE))
}

const UNSENDABLE: &str = "a key holds characters that no header may carry";

fn plain(headers: &HeaderMap) -> Vec<(String, String)> {
    let text = |v: &HeaderValue| String::from_utf8_lossy(v.as_bytes()).into_owned();
    headers.iter().map(|(name, value)| (name.as_str().to_owned(), text(value))).collect()
}

/// The error in our own words: the library's may hold the address and so its query.
fn explained(request: &Request, error: &Error) -> TransportError {
    let mut told = TransportError::refused(request, "");
    let (found, transient, arrived) = match error {
        Error::HostNotFound => ("no such host".into(), true, false),
        Error::ConnectionFailed => ("nobody answers there".into(), true, false),
        Error::Timeout(phase @ (Timeout::Resolve | Timeout::Connect)) => {
            (format!("no answer in time ({phase})"), true, false)
        }
        Error::Timeout(_) => {
            (format!("no whole answer within {:?}", request.limits.deadline), true, true)
        }
        Error::BodyExceedsLimit(_) => {
            let most = request.limits.max_bytes;
            (format!("the answer is longer than {most} bytes and was cut"), false, true)
        }
        Error::Io(e) => broken(e),
        Error::Tls(_) | Error::Rustls(_) => ("the secure connection failed".into(), false, false),
        Error::BadUri(_) | Error::Http(_) => ("not an address".into(), false, false),
        Error::RequireHttpsOnly(_) => {
            ("an address from an answer must be https".into(), false, false)
        }
        Error::LargeResponseHeader(..) => ("the answer's headers are too long".into(), false, true),
        Error::Protocol(_) => ("the answer is not HTTP".into(), true, true),
        _ => ("the connection broke".into(), true, true),
    };
    (told.found, told.transient, told.may_have_arrived) = (found, transient, arrived);
    told
}

fn broken(error: &std::io::Error) -> (String, bool, bool) {
    match error.kind() {
        ErrorKind::ConnectionRefused => ("nobody answers there (refused)".into(), true, false),
        ErrorKind::PermissionDenied => (PRIVATE.into(), false, false),
        ErrorKind::InvalidInput => (UNSENDABLE.into(), false, false),
        ErrorKind::UnexpectedEof => ("the answer stopped before its end".into(), true, true),
        kind => (format!("the connection broke ({kind})"), true, true),
    }
}

const PLAIN: &str = "a key leaves over https or to this machine alone, found plain http";
const PRIVATE: &str = "an address from an answer must be public, found a private one";

/// Resolves names as usual and drops every address that is not public; what is left is what is
/// connected to.
#[derive(Debug, Default)]
struct PublicNames(DefaultResolver);

impl Resolver for PublicNames {
    fn resolve(
        &self,
        uri: &ureq::http::Uri,
        config: &ureq::config::Config,
        timeout: NextTimeout,
    ) -> Result<ResolvedSocketAddrs, Error> {
        let found = self.0.resolve(uri, config, timeout)?;
        let mut public = self.empty();
        for address in found.iter().filter(|a| is_public(a.ip())) {
            public.push(*address);
        }
        if public.is_empty() {
            let kind = ErrorKind::PermissionDenied;
            return Err(Error::Io(std::io::Error::new(kind, PRIVATE)));
        }
        Ok(public)
    }
}

#[cfg(test)]
mod tests {
    use secrecy::SecretString;

    use super::super::loopback::{Serve, serve};
    use super::*;

    fn get(url: &str) -> Request {
        Request::new("test", Method::Get, url).within(Duration::from_secs(5), 1000)
    }

    fn found(request: &Request) -> TransportError {
        Http::default().send(request).unwrap_err()
    }

    #[test]
    fn an_answer_comes_back_whole_whatever_its_status() {
        let server = serve(vec![Serve::text(
            "HTTP/1.1 404 Not Found\r\nContent-Type: text/html; charset=x\r\nContent-Length: 3\r\n\r\nno!",
        )]);
        let mut request = Request::post_json("test", server.url("/a?b=c"), &serde_json::json!({}));
        request = request.with_secret("x-api-key", Some(SecretString::from("k123".to_owned())));
        let response = Http::default().send(&request).unwrap();
        assert_eq!((response.status, response.media_type().as_str()), (404, "text/html"));
        assert_eq!(response.body, b"no!");
        let seen = server.requests().remove(0);
        assert!(seen.starts_with("POST /a?b=c HTTP/1.1"), "{seen}");
        assert!(seen.contains("x-api-key: k123") && seen.ends_with("\r\n\r\n{}"), "{seen}");
    }

    #[test]
    fn a_redirect_comes_back_as_it_is() {
        let head = "HTTP/1.1 302 Found\r\nLocation: http://10.0.0.1/\r\nContent-Length: 0\r\n\r\n";
        let server = serve(vec![Serve::text(head)]);
        let response = Http::default().send(&get(&server.url("/"))).unwrap();
        assert_eq!((response.status, response.header("location")), (302, Some("http://10.0.0.1/")));
    }

    #[test]
    fn an_answer_over_the_limit_is_cut_and_refused() {
        let long = format!("HTTP/1.1 200 OK\r\n\r\n{}", "x".repeat(5000));
        let error = found(&get(&serve(vec![Serve::text(&long)]).url("/")));
        assert!(error.found.contains("longer than 1000 bytes") && !error.transient, "{error}");
    }

    #[test]
    fn a_stopped_stream_and_a_silent_server_are_no_answers() {
        let torn = Serve::text("HTTP/1.1 200 OK\r\nContent-Length: 90\r\n\r\nhalf");
        let error = found(&get(&serve(vec![torn]).url("/")));
        assert!(error.transient && error.may_have_arrived, "{error}");
        let silent = serve(vec![Serve::Nothing(Duration::from_secs(3))]);
        let request = get(&silent.url("/")).within(Duration::from_millis(150), 1000);
        let error = found(&request);
        assert!(error.found.contains("150ms") && error.may_have_arrived, "{error}");
    }

    #[test]
    fn nobody_at_home_is_known_not_to_have_heard() {
        let address = serve(vec![]).url("/");
        let error = found(&get(&address));
        assert!(error.transient && !error.may_have_arrived, "{error}");
    }

    #[test]
    fn a_private_host_named_by_an_answer_is_not_spoken_to() {
        let server = serve(vec![Serve::text("HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n")]);
        for url in [server.url("/").replace("http://", "https://"), "https://localhost/".into()] {
            let mut request = get(&url);
            request.limits.reach = Reach::Public;
            assert!(found(&request).found.contains("private"), "{url}");
        }
        let mut plain = get(&server.url("/"));
        plain.limits.reach = Reach::Public;
        assert!(found(&plain).found.contains("https"));
        assert!(server.requests().is_empty());
    }

    #[test]
    fn a_key_does_not_leave_in_plain() {
        for url in ["http://192.0.2.1:1/v1", "http://gpu.example/v1", "ftp://127.0.0.1.example/"] {
            let key = Some(SecretString::from("canary-key".to_owned()));
            let error = found(&get(url).with_secret("authorization", key));
            assert!(error.found.contains("plain http") && !error.may_have_arrived, "{error}");
        }
    }

    #[test]
    fn a_key_that_cannot_be_sent_is_not_quoted() {
        let key = Some(SecretString::from("canary\nkey".to_owned()));
        let error = found(&get("http://127.0.0.1:9/?q=canary").with_secret("x-api-key", key));
        assert!(error.found.contains("no header may carry"), "{error}");
        assert!(!format!("{error} {error:?}").contains("canary"));
    }
}
