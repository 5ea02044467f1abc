//! Which requests are answered: those of the page that the person opened.

use std::net::{IpAddr, SocketAddr};
use std::sync::Mutex;

use hyper::header::{HOST, HeaderMap, HeaderName, ORIGIN};
use hyper::http::uri::Authority;
use hyper::{Request, StatusCode};

use super::rate::Rate;
use super::token::Token;

/// Requests of the page that are answered in a second.
const PAGE: f64 = 400.0;
/// Requests of anyone else that are looked at in a second.
const OTHERS: f64 = 20.0;

/// Decides which requests are answered.
#[derive(Debug)]
pub(crate) struct Guard {
    token: Token,
    address: SocketAddr,
    page: Mutex<Rate>,
    others: Mutex<Rate>,
}

impl Guard {
    /// For a server at an address.
    pub(super) fn new(token: Token, address: SocketAddr) -> Self {
        let (page, others) = (Mutex::new(Rate::new(PAGE)), Mutex::new(Rate::new(OTHERS)));
        Self { token, address, page, others }
    }

    /// For a server that nobody connects to, with its token.
    pub(crate) fn apart() -> Option<(Self, String)> {
        let token = Token::random().ok()?;
        let text = token.text().to_owned();
        Some((Self::new(token, SocketAddr::from(([127, 0, 0, 1], 8000))), text))
    }

    /// Returns what a request asks for, behind the token.
    ///
    /// # Errors
    /// How it is refused. Whoever does not know the token learns nothing else.
    pub(crate) fn admit<'r, B>(&self, request: &'r Request<B>) -> Result<&'r str, StatusCode> {
        let (token, path) = split(request.uri().path());
        if !self.token.is(token) || !self.is_ours(request.headers()) {
            let looked_at = allows(&self.others);
            return Err(if looked_at {
                StatusCode::NOT_FOUND
            } else {
                StatusCode::TOO_MANY_REQUESTS
            });
        }
        if !allows(&self.page) {
            return Err(StatusCode::TOO_MANY_REQUESTS);
        }
        Ok(path)
    }

    /// Whether a request is meant for this server, and comes from its own page or from nowhere.
    fn is_ours(&self, headers: &HeaderMap) -> bool {
        let mut hosts = headers.get_all(HOST).iter();
        let (Some(host), None) = (hosts.next().and_then(|host| host.to_str().ok()), hosts.next())
        else {
            return false;
        };
        let is_same_origin = headers.get_all(ORIGIN).iter().all(|origin| {
            let origin = origin.to_str().ok().and_then(|origin| origin.strip_prefix("http://"));
            origin.is_some_and(|origin| origin.eq_ignore_ascii_case(host))
        });
        let site = headers.get(HeaderName::from_static("sec-fetch-site"));
        let is_same_site = site.is_none_or(|site| site == "same-origin" || site == "none");
        self.knows(host) && is_same_origin && is_same_site
    }

    /// Whether a host is this server. A name that somebody else made to lead here is none: only
    /// `localhost` and addresses are. The port may be another one at the other end of a tunnel.
    fn knows(&self, host: &str) -> bool {
        let Ok(host) = host.parse::<Authority>() else { return false };
        let name = host.host().trim_start_matches('[').trim_end_matches(']');
        if host.as_str().contains('@') {
            return false;
        }
        match name.parse::<IpAddr>() {
            Ok(ip) => ip.is_loopback() || !self.address.ip().is_loopback(),
            Err(_) => name.eq_ignore_ascii_case("localhost"),
        }
    }
}

fn allows(rate: &Mutex<Rate>) -> bool {
    rate.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).allows()
}

/// The first part of a path, and what is behind it.
fn split(path: &str) -> (&str, &str) {
    let path = path.strip_prefix('/').unwrap_or(path);
    path.split_once('/').unwrap_or((path, "/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn guard(listen: &str) -> Guard {
        Guard::new(Token::random().unwrap(), listen.parse().unwrap())
    }

    /// What a request with these headers gets.
    fn check(guard: &Guard, headers: &[(&str, &str)], is_admitted: bool) {
        let path = format!("/{}/picture", guard.token.text());
        let request =
            headers.iter().fold(Request::builder().uri(path), |request, (name, value)| {
                request.header(*name, *value)
            });
        let request = request.body(()).unwrap();
        let expected = if is_admitted { Ok("picture") } else { Err(StatusCode::NOT_FOUND) };
        assert_eq!(guard.admit(&request), expected, "{headers:?}");
    }

    #[test]
    fn hosts_that_are_names_are_refused() {
        let guard = guard("127.0.0.1:8000");
        for host in ["localhost", "localhost:8000", "LOCALHOST:9", "127.0.0.1:8000", "[::1]:8000"] {
            check(&guard, &[("host", host)], true);
        }
        for host in
            ["evil.example", "localhost.evil.example:8000", "192.168.0.1", "a@localhost", ""]
        {
            check(&guard, &[("host", host)], false);
        }
        check(&guard, &[], false);
        check(&guard, &[("host", "localhost"), ("host", "localhost")], false);
    }

    #[test]
    fn a_server_for_others_knows_addresses() {
        let guard = guard("0.0.0.0:8000");
        check(&guard, &[("host", "192.168.0.1:8000")], true);
        check(&guard, &[("host", "evil.example:8000")], false);
    }

    #[test]
    fn other_pages_are_refused() {
        let guard = guard("127.0.0.1:8000");
        let host = ("host", "localhost:8000");
        check(&guard, &[host, ("origin", "http://localhost:8000")], true);
        check(&guard, &[host, ("sec-fetch-site", "same-origin")], true);
        check(&guard, &[host, ("sec-fetch-site", "none")], true);
        for origin in
            ["http://localhost:8001", "https://localhost:8000", "http://evil.example", "null"]
        {
            check(&guard, &[host, ("origin", origin)], false);
        }
        for site in ["cross-site", "same-site"] {
            check(&guard, &[host, ("sec-fetch-site", site)], false);
        }
    }

    #[test]
    fn strangers_are_cut_off_and_the_page_is_not() {
        let guard = guard("127.0.0.1:8000");
        let of = |path: &str| {
            let request =
                Request::builder().uri(path).header("host", "localhost").body(()).unwrap();
            guard.admit(&request).map(str::to_owned)
        };
        for path in ["/", "/x/picture", "//", "/picture"] {
            assert_eq!(of(path), Err(StatusCode::NOT_FOUND), "{path}");
        }
        let refused =
            (0..100).map(|_| of("/guess/")).filter(|of| *of == Err(StatusCode::TOO_MANY_REQUESTS));
        assert!(refused.count() >= 70);
        let own = format!("/{}/", guard.token.text());
        assert_eq!(of(&own), Ok(String::new()));
        let answered = (0..2000).filter(|_| of(&own).is_ok()).count();
        assert!((300..1900).contains(&answered), "{answered}");
    }
}
