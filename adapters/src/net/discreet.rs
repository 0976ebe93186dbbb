//! Takes a request's own secrets out of its answer, so that a server that says them back finds no
//! ear that could pass them on.

use secrecy::SecretString;
use ureq::http::Uri;

use super::redact;
use crate::transport::{Request, Response, Transport, TransportError};

/// Answers without the secrets of what was asked: its keys, and what its address holds besides a
/// place.
pub struct Discreet<T>(pub T);

impl<T: Transport> Transport for Discreet<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let mut secrets = request.secrets.clone();
        secrets.extend(in_address(&request.url));
        let hide = |text: &str| redact::sentence(text, &secrets);
        match self.0.send(request) {
            Ok(Response { status, headers, body }) => {
                let headers = headers.into_iter().map(|(n, v)| (n, hide(&v))).collect();
                Ok(Response { status, headers, body: redact::without_secrets(body, &secrets) })
            }
            Err(error) => Err(TransportError { found: hide(&error.found), ..error }),
        }
    }
}

/// User and password of an address, and the values of its query.
fn in_address(url: &str) -> Vec<(String, SecretString)> {
    let Ok(uri) = url.parse::<Uri>() else { return vec![] };
    let user = uri.authority().and_then(|a| a.as_str().rsplit_once('@'));
    let user = user.into_iter().flat_map(|(user, _)| user.split(':').map(String::from));
    let values = uri.query().into_iter().flat_map(|q| q.split('&'));
    let values = values.filter_map(|pair| Some(pair.split_once('=')?.1.to_owned()));
    user.chain(values).map(|value| ("address".to_owned(), value.into())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Method;

    /// Says everything back that it was told.
    struct Echo;

    impl Transport for Echo {
        fn send(&self, request: &Request) -> Result<Response, TransportError> {
            use secrecy::ExposeSecret as _;
            let told = format!("{} {}", request.url, request.secrets[0].1.expose_secret());
            let headers = vec![("x-request-id".into(), told.clone())];
            Ok(Response { status: 401, headers, body: told.into_bytes() })
        }
    }

    #[test]
    fn an_echo_comes_back_without_keys_and_without_what_the_address_held() {
        let url = "https://me:canary-pass@h.example/a?token=canary-token";
        let key = SecretString::from("Bearer canary-key-1".to_owned());
        let request = Request::new("s", Method::Get, url).with_secret("authorization", Some(key));
        let response = Discreet(Echo).send(&request).unwrap();
        let told = format!("{response:?} {}", String::from_utf8_lossy(&response.body));
        assert!(!told.contains("canary") && told.contains("h.example/a"), "{told}");
    }
}
