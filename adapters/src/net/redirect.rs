//! Follows the redirects of a download, as far as every hop is public.

use std::net::IpAddr;

use ureq::http::Uri;

use crate::transport::{Method, Reach, Request, Response, Transport, TransportError};

/// Most redirects of one download.
pub const MAX_HOPS: usize = 3;

/// Follows redirects of requests that may reach public hosts alone; all others come back as they
/// are, for a configured service that redirects is not the one that was configured.
#[derive(Clone, Debug)]
pub struct Following<T>(pub T);

impl<T: Transport> Transport for Following<T> {
    fn send(&self, request: &Request) -> Result<Response, TransportError> {
        if request.limits.reach == Reach::Configured {
            return self.0.send(request);
        }
        let mut hop = request.clone();
        for _ in 0..=MAX_HOPS {
            check_public(&hop)?;
            let response = self.0.send(&hop)?;
            let Some(next) = redirected(&hop, &response)? else { return Ok(response) };
            // Whoever we are sent on to has no business with our keys.
            hop.secrets.clear();
            hop.url = next;
        }
        Err(TransportError::refused(request, format!("redirected more than {MAX_HOPS} times")))
    }
}

/// Refuses what the text of an address already shows not to be public; names are judged where they
/// are resolved.
fn check_public(request: &Request) -> Result<(), TransportError> {
    let refuse = |found: &str| Err(TransportError::refused(request, found));
    let Ok(uri) = request.url.parse::<Uri>() else { return refuse("not an address") };
    if uri.scheme_str() != Some("https") {
        return refuse("an address from an answer must be https");
    }
    let host = uri.host().unwrap_or_default().trim_matches(['[', ']']);
    let literal = host.parse::<IpAddr>().ok();
    if host.is_empty() || literal.is_some_and(|ip| !super::address::is_public(ip)) {
        return refuse("an address from an answer must be public, found a private one");
    }
    if request.method != Method::Get {
        return refuse("only downloads may go to an address from an answer");
    }
    Ok(())
}

fn redirected(request: &Request, response: &Response) -> Result<Option<String>, TransportError> {
    if !matches!(response.status, 301 | 302 | 303 | 307 | 308) {
        return Ok(None);
    }
    let target = response.header("location");
    let target = target.ok_or_else(|| TransportError::refused(request, "redirected to nowhere"))?;
    let relative = target.starts_with('/') && !target.starts_with("//");
    if !relative {
        return Ok(Some(target.to_owned()));
    }
    let base = request.url.parse::<Uri>().ok().and_then(|u| u.into_parts().authority);
    let base = base.ok_or_else(|| TransportError::refused(request, "not an address"))?;
    Ok(Some(format!("https://{base}{target}")))
}

#[cfg(test)]
mod tests {
    use secrecy::SecretString;

    use super::*;

    /// Sends everybody on to one address, and gives a file to who asks for it there.
    struct Onward(&'static str);

    impl Transport for Onward {
        fn send(&self, request: &Request) -> Result<Response, TransportError> {
            if request.url.ends_with("/file") {
                assert!(request.secrets.is_empty(), "no key goes to another host");
                return Ok(Response { status: 200, headers: vec![], body: b"file".to_vec() });
            }
            let headers = vec![("location".to_owned(), self.0.to_owned())];
            Ok(Response { status: 302, headers, body: vec![] })
        }
    }

    fn download(target: &'static str) -> Result<Response, TransportError> {
        let mut request = Request::new("download", Method::Get, "https://cdn.example/x?sig=1");
        request.limits.reach = Reach::Public;
        let key = SecretString::from("a key of ours".to_owned());
        Following(Onward(target)).send(&request.with_secret("authorization", Some(key)))
    }

    #[test]
    fn a_download_follows_public_redirects_without_its_keys() {
        assert_eq!(download("https://other.example/file").unwrap().body, b"file");
        assert_eq!(download("/file").unwrap().body, b"file");
    }

    #[test]
    fn a_redirect_into_the_house_is_refused() {
        let inside = [
            "https://127.0.0.1/file",
            "https://169.254.169.254/file",
            "https://[::1]/file",
            "https://[fd00::1]:443/file",
            "http://cdn.example/file",
            "//cdn.example/file",
            "file:///etc/passwd",
        ];
        for target in inside {
            let error = download(target).unwrap_err();
            assert!(!error.transient && !error.to_string().contains("sig"), "{target}: {error}");
        }
        let error = download("https://cdn.example/round").unwrap_err();
        assert!(error.found.contains("more than 3 times"), "{error}");
    }

    #[test]
    fn a_configured_service_is_not_followed_elsewhere() {
        let request = Request::new("submit", Method::Post, "http://localhost/x");
        let response = Following(Onward("http://10.0.0.1/file")).send(&request).unwrap();
        assert_eq!(response.status, 302);
    }
}
