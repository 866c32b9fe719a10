//! Access control of the page server. A request must name this host and contain the token. Both are checked before the
//! body is read.

use super::page;
use constant_time_eq::constant_time_eq;
use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{self, HeaderName, HeaderValue};
use hyper::http::request::Parts;
use hyper::http::uri::Authority;
use hyper::{Request, Response, StatusCode};
use rustix::rand::{GetRandomFlags, getrandom};
use std::net::IpAddr;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;
use tokio::time::timeout;

/// Longest time to receive a request, and longest time without progress in sending an answer. Then the connection closes.
pub const IO_TIMEOUT: Duration = Duration::from_secs(5);
/// Greatest length of a body [bytes].
const MAX_BODY_BYTES: usize = 4 << 10;

/// An answer whose body is in memory.
pub type Answer = Response<Full<Bytes>>;

/// Address, token and content security policy of a server.
pub struct AccessControl {
    listening: IpAddr,
    /// A request with this token is authorised.
    pub token: String,
    /// Content security policy.
    policy: String,
}

impl AccessControl {
    /// Creates a random token.
    ///
    /// # Errors
    /// If the system provides no random numbers.
    pub fn new(listening: IpAddr) -> std::io::Result<AccessControl> {
        let mut token = [0; 16];
        getrandom(&mut token, GetRandomFlags::empty())?;
        let token = format!("{:032x}", u128::from_ne_bytes(token));
        Ok(AccessControl { listening, token, policy: format!("{}; frame-ancestors 'none'", page::policy()) })
    }

    /// Checks a request and reads its body.
    ///
    /// # Errors
    /// The answer to a request that is refused.
    pub async fn authorize(
        &self,
        request: Request<Incoming>,
        is_authorized: &AtomicBool,
    ) -> Result<(Parts, String), Answer> {
        let (head, body) = request.into_parts();
        let header_text = |name| head.headers.get(name).and_then(|value| value.to_str().ok());
        if !header_text(header::HOST).is_some_and(|host| self.is_this_host(host)) {
            return Err(text(421, WRONG_HOST));
        }
        if head.uri.path() == "/favicon.ico" {
            return Err(text(204, ""));
        }
        let bearer = || header_text(header::AUTHORIZATION)?.strip_prefix("Bearer ");
        let token = Query(head.uri.query().unwrap_or("")).value("token").or_else(bearer).unwrap_or("");
        if !constant_time_eq(token.as_bytes(), self.token.as_bytes()) {
            return Err(match head.uri.path() {
                "/" => with(text(403, &page::refusal(STALE_ADDRESS)), header::CONTENT_TYPE, HTML),
                _ => text(403, STALE_ADDRESS),
            });
        }
        is_authorized.store(true, Relaxed);
        match timeout(IO_TIMEOUT, Limited::new(body, MAX_BODY_BYTES).collect()).await {
            Err(_) => Err(text(408, "This request was not complete in time.\n")),
            Ok(Err(_)) => Err(text(413, "This request is too long or incomplete.\n")),
            Ok(Ok(body)) => Ok((head, String::from_utf8_lossy(&body.to_bytes()).into())),
        }
    }

    /// True if the host header names this server. A foreign domain name that resolves to our address is refused, which
    /// prevents DNS rebinding. The port is not compared, because containers and tunnels change it.
    fn is_this_host(&self, host: &str) -> bool {
        let Ok(authority) = host.parse::<Authority>() else { return false };
        let (name, any) = (authority.host().trim_matches(['[', ']']), self.listening.is_unspecified());
        match name.parse::<IpAddr>() {
            Ok(address) => any || address == self.listening || address.is_loopback() && self.listening.is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost") && (any || self.listening.is_loopback()),
        }
    }

    /// Adds the headers of every answer: no caching, no referrer, no content sniffing, and only the page's own scripts.
    pub fn add_headers(&self, answer: Answer) -> Answer {
        let answer = with(answer, header::CONTENT_SECURITY_POLICY, &self.policy);
        let headers = [
            (header::CACHE_CONTROL, "no-store"),
            (header::REFERRER_POLICY, "no-referrer"),
            (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        ];
        headers.into_iter().fold(answer, |answer, (name, value)| with(answer, name, value))
    }
}

const STALE_ADDRESS: &str =
    "The token in this address is not valid: open the address that `biped view` printed last.\n";
const WRONG_HOST: &str =
    "This server does not have the requested host name: open the address that `biped view` printed.\n";
const HTML: &str = "text/html; charset=utf-8";

/// The query part of a URL.
#[derive(Clone, Copy)]
pub struct Query<'a>(pub &'a str);

impl<'a> Query<'a> {
    /// The value of a parameter.
    pub fn value(self, key: &str) -> Option<&'a str> {
        self.0.split('&').find_map(|part| part.strip_prefix(key)?.strip_prefix('='))
    }
}

/// An HTML answer.
pub fn html(page: &Bytes) -> Answer {
    with(Response::new(Full::new(page.clone())), header::CONTENT_TYPE, HTML)
}

/// The answer to an unknown path.
pub fn not_found() -> Answer {
    text(404, "Not found.\n")
}

/// A plain text answer.
pub fn text(status: u16, message: &str) -> Answer {
    let mut answer = Response::new(Full::from(message.to_string()));
    *answer.status_mut() = StatusCode::from_u16(status).unwrap_or_default();
    match message.is_empty() {
        true => answer,
        false => with(answer, header::CONTENT_TYPE, "text/plain; charset=utf-8"),
    }
}

/// A binary answer.
pub fn data(bytes: Vec<u8>) -> Answer {
    with(Response::new(Full::from(bytes)), header::CONTENT_TYPE, "application/octet-stream")
}

/// Adds a header. A value that is not ASCII is ignored.
pub fn with(mut answer: Answer, name: HeaderName, value: &str) -> Answer {
    if let Ok(value) = HeaderValue::from_str(value) {
        answer.headers_mut().insert(name, value);
    }
    answer
}
