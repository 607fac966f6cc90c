//! Who may ask: the checks before any route, in the order in which an attack would try them.
//!
//! A page in the operator's own browser is the attacker that this is about: it can send requests to the loopback
//! interface, and by DNS rebinding under a name of its own. So: Host first, then Origin, then what the browser says of
//! the site that asks, then the cookie, which was exchanged for a code that works once.

use std::net::{IpAddr, SocketAddr};
use std::sync::{Mutex, PoisonError};

use axum::http::header::{CONTENT_TYPE, COOKIE, HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode};
use isolux_app::Failure;
use subtle::ConstantTimeEq as _;

/// Why a request was refused: what goes over the wire, and a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The status.
    pub status: StatusCode,
    /// The sentence.
    pub sentence: &'static str,
}

const fn refusal(status: StatusCode, sentence: &'static str) -> Refusal {
    Refusal { status, sentence }
}

/// Secrets of one server, and the address at which it listens.
#[derive(Debug)]
pub struct Guard {
    address: SocketAddr,
    /// What the cookie must hold.
    token: String,
    /// What the next launch address must hold.
    code: Mutex<String>,
}

/// 24 random bytes as hexadecimal digits.
fn secret() -> Result<String, Failure> {
    let mut bytes = [0_u8; 24];
    getrandom::fill(&mut bytes)
        .map_err(|error| Failure::instrument(format!("the system gives no random numbers: {error}")))?;
    Ok(hex::encode(bytes))
}

fn equal(given: &str, expected: &str) -> bool {
    given.as_bytes().ct_eq(expected.as_bytes()).into()
}

impl Guard {
    /// Fresh secrets for a server at `address`.
    ///
    /// # Errors
    /// Exit 3 when the system gives no random numbers.
    pub fn new(address: SocketAddr) -> Result<Self, Failure> {
        Ok(Self {
            address,
            token: secret()?,
            code: Mutex::new(secret()?),
        })
    }

    /// The address that opens the page once.
    pub fn launch_url(&self) -> String {
        let host = match self.address.ip() {
            ip if ip.is_unspecified() => "127.0.0.1".to_owned(),
            IpAddr::V6(ip) => format!("[{ip}]"),
            IpAddr::V4(ip) => ip.to_string(),
        };
        let code = self.code.lock().unwrap_or_else(PoisonError::into_inner);
        format!("http://{host}:{}/?code={}", self.address.port(), *code)
    }

    /// The name of the cookie: with the port, so that two servers do not take each other's.
    fn cookie_name(&self) -> String {
        format!("isolux-{}", self.address.port())
    }

    /// The cookie that a right code is exchanged for; the code works no second time.
    ///
    /// # Errors
    /// 403 for a code that is wrong or was used.
    pub fn exchange(&self, code: &str) -> Result<String, Refusal> {
        let used = refusal(
            StatusCode::FORBIDDEN,
            "this address was used already, or is of another start: the terminal shows the next one",
        );
        let mut expected = self.code.lock().unwrap_or_else(PoisonError::into_inner);
        if !equal(code, &expected) {
            return Err(used);
        }
        *expected = secret().map_err(|_| used)?;
        Ok(format!(
            "{}={}; HttpOnly; SameSite=Strict; Path=/",
            self.cookie_name(),
            self.token
        ))
    }

    /// Checks 2 to 4: who is asked, who asks, and from which site. For every request, before any route.
    ///
    /// # Errors
    /// 403, or 415 for a command that is not JSON.
    pub fn outside(&self, method: &Method, headers: &HeaderMap) -> Result<(), Refusal> {
        let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
        let host = text(HOST).filter(|_| headers.get_all(HOST).iter().count() == 1);
        if !host.is_some_and(|host| self.is_host(host)) {
            return Err(refusal(
                StatusCode::FORBIDDEN,
                "this server answers to localhost and loopback addresses alone",
            ));
        }
        let safe = matches!(*method, Method::GET | Method::HEAD);
        match headers.get(ORIGIN).map(|origin| origin.to_str().unwrap_or("?")) {
            Some(origin) if !self.is_origin(origin, host.unwrap_or_default()) => {
                return Err(refusal(StatusCode::FORBIDDEN, "another site asked for this"));
            }
            // A command without an Origin is of no browser's page; a browser that says "same-origin" may leave it out.
            None if !safe && headers.get("sec-fetch-site").is_none() => {
                return Err(refusal(
                    StatusCode::FORBIDDEN,
                    "a command says from which page it comes (Origin)",
                ));
            }
            _ => {}
        }
        let site = headers.get("sec-fetch-site").map(HeaderValue::as_bytes);
        let own_site = matches!(site, None | Some(b"same-origin" | b"none"));
        // Following a link to the page is no command; what it would load needs the cookie, which is SameSite=Strict.
        let navigation = headers.get("sec-fetch-mode").is_some_and(|mode| mode == "navigate");
        if !(own_site || safe && navigation) {
            return Err(refusal(StatusCode::FORBIDDEN, "another site asked for this"));
        }
        if !safe {
            let json = text(CONTENT_TYPE).is_some_and(|kind| kind.split(';').next() == Some("application/json"));
            if *method != Method::POST || !json {
                return Err(refusal(
                    StatusCode::UNSUPPORTED_MEDIA_TYPE,
                    "a command is a POST of application/json",
                ));
            }
        }
        Ok(())
    }

    /// Check 5: the cookie.
    ///
    /// # Errors
    /// 401 without the right one.
    pub fn inside(&self, headers: &HeaderMap) -> Result<(), Refusal> {
        let name = self.cookie_name();
        let cookies = headers.get_all(COOKIE).iter().filter_map(|value| value.to_str().ok());
        let mut values = cookies
            .flat_map(|line| line.split(';'))
            .filter_map(|pair| pair.trim().split_once('='));
        if values.any(|(key, value)| key == name && equal(value, &self.token)) {
            return Ok(());
        }
        Err(refusal(
            StatusCode::UNAUTHORIZED,
            "open the page by the address that the terminal shows",
        ))
    }

    /// Whole names: a test of the beginning would let localhost.evil.example in.
    fn is_host(&self, host: &str) -> bool {
        let Some((name, port)) = split_host(host) else {
            return false;
        };
        if port != self.address.port() {
            return false;
        }
        if name.eq_ignore_ascii_case("localhost") {
            return self.address.ip().is_loopback() || self.address.ip().is_unspecified();
        }
        // A rebinding attack needs a name; an address is what it says.
        name.parse::<IpAddr>().is_ok_and(|ip| {
            let own = self.address.ip();
            if own.is_loopback() {
                ip.is_loopback()
            } else {
                own.is_unspecified() || ip == own || ip.is_loopback()
            }
        })
    }

    /// Scheme, host and port are those of the request.
    fn is_origin(&self, origin: &str, host: &str) -> bool {
        origin
            .strip_prefix("http://")
            .is_some_and(|origin| origin.eq_ignore_ascii_case(host) && self.is_host(origin))
    }
}

/// Name or address without brackets, and the port (80 where none is named).
fn split_host(host: &str) -> Option<(&str, u16)> {
    if let Some(rest) = host.strip_prefix('[') {
        let (name, after) = rest.split_once(']')?;
        let port = match after {
            "" => 80,
            after => after.strip_prefix(':')?.parse().ok()?,
        };
        return Some((name, port));
    }
    match host.split_once(':') {
        Some((name, port)) => Some((name, port.parse().ok()?)),
        None => Some((host, 80)),
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderName;

    use super::*;

    fn guard() -> Guard {
        Guard::new("127.0.0.1:4711".parse().unwrap()).unwrap()
    }

    fn headers(pairs: &[(&str, &str)]) -> HeaderMap {
        let pair = |(name, value): &(&str, &str)| (name.parse::<HeaderName>().unwrap(), value.parse().unwrap());
        pairs.iter().map(pair).collect()
    }

    #[test]
    fn a_host_is_a_whole_name_with_our_port() {
        let guard = guard();
        for host in [
            "127.0.0.1:4711",
            "localhost:4711",
            "LOCALHOST:4711",
            "[::1]:4711",
            "127.8.9.1:4711",
        ] {
            assert_eq!(
                guard.outside(&Method::GET, &headers(&[("host", host)])),
                Ok(()),
                "{host}"
            );
        }
        for host in [
            "localhost.evil.example:4711",
            "evil.example:4711",
            "localhost",
            "localhost:80",
            "127.0.0.1",
            "127.0.0.1.evil.example:4711",
            "192.168.1.7:4711",
            "localhost.:4711",
            "[::1",
            "[::1]x",
            "localhost:4711:4711",
            "user@localhost:4711",
            "",
        ] {
            let refused = guard.outside(&Method::GET, &headers(&[("host", host)]));
            assert_eq!(
                refused.map_err(|refusal| refusal.status),
                Err(StatusCode::FORBIDDEN),
                "{host}"
            );
        }
        assert!(guard.outside(&Method::GET, &HeaderMap::new()).is_err());
        let mut twice = headers(&[("host", "localhost:4711")]);
        twice.append(HOST, "evil.example:4711".parse().unwrap());
        assert!(guard.outside(&Method::GET, &twice).is_err());
    }

    #[test]
    fn what_a_proxy_says_of_the_host_counts_for_nothing() {
        let forged = [
            ("host", "evil.example:4711"),
            ("x-forwarded-host", "localhost:4711"),
            ("forwarded", "host=localhost:4711"),
        ];
        assert!(guard().outside(&Method::GET, &headers(&forged)).is_err());
    }

    #[test]
    fn a_command_comes_from_our_own_page_as_json() {
        let guard = guard();
        let host = ("host", "localhost:4711");
        let json = ("content-type", "application/json; charset=utf-8");
        let own = ("origin", "http://localhost:4711");
        let post = |pairs: &[(&str, &str)]| guard.outside(&Method::POST, &headers(pairs));
        assert_eq!(post(&[host, json, own]), Ok(()));
        assert_eq!(post(&[host, json, own, ("sec-fetch-site", "same-origin")]), Ok(()));
        for origin in [
            "null",
            "http://localhost:4712",
            "https://localhost:4711",
            "http://127.0.0.1:4711",
            "http://localhost.evil.example:4711",
            "http://evil.example",
        ] {
            let refused = post(&[host, json, ("origin", origin)]);
            assert_eq!(
                refused.map_err(|refusal| refusal.status),
                Err(StatusCode::FORBIDDEN),
                "{origin}"
            );
            // Reading across origins too: the answer would be of no use to that page, but it is not given either.
            assert!(
                guard
                    .outside(&Method::GET, &headers(&[host, ("origin", origin)]))
                    .is_err(),
                "{origin}"
            );
        }
        assert!(post(&[host, json]).is_err(), "no Origin and no word of the browser");
        for site in ["cross-site", "same-site", "nonsense"] {
            assert!(post(&[host, json, own, ("sec-fetch-site", site)]).is_err(), "{site}");
            assert!(
                guard
                    .outside(&Method::GET, &headers(&[host, ("sec-fetch-site", site)]))
                    .is_err()
            );
            let link = headers(&[host, ("sec-fetch-site", site), ("sec-fetch-mode", "navigate")]);
            assert_eq!(guard.outside(&Method::GET, &link), Ok(()), "a link is followed");
        }
        for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data"] {
            let refused = post(&[host, own, ("content-type", kind)]);
            assert_eq!(
                refused.map_err(|refusal| refusal.status),
                Err(StatusCode::UNSUPPORTED_MEDIA_TYPE),
                "{kind}"
            );
        }
        let put = guard.outside(&Method::PUT, &headers(&[host, json, own]));
        assert!(put.is_err());
    }

    #[test]
    fn a_code_works_once_and_gives_the_cookie_that_opens() {
        let guard = guard();
        let url = guard.launch_url();
        let code = url.strip_prefix("http://127.0.0.1:4711/?code=").unwrap();
        assert_eq!(code.len(), 48);
        for wrong in ["", "0", &code[1..], &format!("{code}0")] {
            assert!(guard.exchange(wrong).is_err());
        }
        let cookie = guard.exchange(code).unwrap();
        assert!(
            cookie.starts_with("isolux-4711=") && cookie.contains("HttpOnly; SameSite=Strict"),
            "{cookie}"
        );
        assert!(guard.exchange(code).is_err(), "once");
        assert_ne!(guard.launch_url(), url, "the next browser gets a code of its own");
        let value = cookie.split(';').next().unwrap();
        assert_eq!(guard.inside(&headers(&[("cookie", value)])), Ok(()));
        assert_eq!(
            guard.inside(&headers(&[("cookie", &format!("a=b; {value}; c=d"))])),
            Ok(())
        );
        let other = value.replace("4711", "4712");
        for wrong in [
            "",
            "isolux-4711=",
            &other,
            &value[..value.len() - 1],
            &format!("x{value}"),
        ] {
            let refused = guard.inside(&headers(&[("cookie", wrong)]));
            assert_eq!(
                refused.map_err(|refusal| refusal.status),
                Err(StatusCode::UNAUTHORIZED),
                "{wrong}"
            );
        }
    }

    #[test]
    fn beyond_loopback_an_address_is_a_host_and_a_name_is_not() {
        let guard = Guard::new("0.0.0.0:80".parse().unwrap()).unwrap();
        assert!(guard.is_host("192.168.1.7") && guard.is_host("localhost"));
        assert!(!guard.is_host("bench.evil.example"));
    }
}
