//! Takes our secrets out of every answer, so that a server that says them back finds no ear that
//! could pass them on.

use secrecy::{ExposeSecret as _, SecretString};

use super::redactor::{Redactor, in_address};
use crate::transport::{Request, Response, Transport, TransportError};

/// Answers without our secrets: those known beforehand, the keys of what was asked, and what its
/// address holds besides a place.
pub struct Discreet<T> {
    /// Who is asked.
    pub inner: T,
    /// Takes out what is known beforehand: a file's host may know what another was told.
    pub known: Redactor,
}

impl<T: Transport> Transport for Discreet<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        let own = self.own(request);
        let text = |text: String| {
            let text = self.known.text(&text).into_owned();
            own.text(&text).into_owned()
        };
        match self.inner.send(request) {
            Ok(Response { status, headers, body }) => {
                let headers = headers.into_iter().map(|(n, v)| (text(n), text(v))).collect();
                Ok(Response { status, headers, body: own.body(self.known.body(body)) })
            }
            Err(error) => {
                Err(TransportError { host: text(error.host), found: text(error.found), ..error })
            }
        }
    }
}

impl<T> Discreet<T> {
    /// Takes out what this request holds and nobody knew beforehand, such as a signature.
    fn own(&self, request: &Request) -> Redactor {
        let told = in_address(&request.url);
        let told = request.secrets.iter().map(|(_, secret)| secret).chain(&told);
        let unknown = |s: &&SecretString| !self.known.hides(s.expose_secret());
        Redactor::new(told.filter(unknown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::Method;

    /// Says everything back that it was told, and a key of another time.
    struct Echo;

    impl Transport for Echo {
        fn send(&self, request: &Request) -> Result<Response, TransportError> {
            let told = format!("{} {}", request.url, request.secrets[0].1.expose_secret());
            let headers = vec![("x-request-id".into(), told.clone())];
            let body = format!("{told} and canary-of-another-time").into_bytes();
            Ok(Response { status: 401, headers, body })
        }
    }

    #[test]
    fn an_echo_comes_back_without_keys_and_without_what_the_address_held() {
        let url = "https://me:canary-pass@h.example/a?token=canary-token";
        let key = SecretString::from("Bearer canary-key-1".to_owned());
        let request = Request::new("s", Method::Get, url).with_secret("authorization", Some(key));
        let known = SecretString::from("canary-of-another-time".to_owned());
        let discreet = Discreet { inner: Echo, known: Redactor::new([&known]) };
        let response = discreet.send(&request).unwrap();
        let told = format!("{response:?} {}", String::from_utf8_lossy(&response.body));
        assert!(!told.contains("canary") && told.contains("h.example/a"), "{told}");
    }
}
