//! Who may come in.
//!
//! A page of somebody else, open in the same browser, can send requests to any address of this machine; so a WebSocket has to come from our own page (its `Origin` is our address), and on the loopback
//! address the name by which we were called has to be one of this machine, since a stranger's name can be made to mean it ("DNS rebinding"). Where the address is open to others, who comes needs the token as well.

use crate::request::Request;

/// What has to hold for those who come.
#[derive(Clone, Debug)]
pub(crate) struct Gate {
    pub(crate) port: u16,
    /// Needed where others than this machine can come.
    pub(crate) token: Option<String>,
}

impl Gate {
    /// Whether a request for the page or its WebSocket may pass.
    ///
    /// # Errors
    /// Says what is missing.
    pub(crate) fn admit(&self, request: &Request) -> Result<(), &'static str> {
        let Some(host) = request.header("host") else { return Err("the request names no host") };
        if let Some(origin) = request.header("origin") {
            let own = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
            if own != Some(host) {
                return Err("this page is another one's: it may not look at a simulation here");
            }
        }
        match &self.token {
            Some(token) if !request.query("token").is_some_and(|given| equal(given, token)) => {
                Err("the token is missing or wrong: open the address that the program printed")
            }
            Some(_) => Ok(()),
            None if self.is_ours(host) => Ok(()),
            None => Err("this name does not mean this machine: open the address that the program printed"),
        }
    }

    fn is_ours(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.ends_with(']') => (name, port.parse().ok()),
            _ => (host, Some(80)),
        };
        port == Some(self.port) && matches!(name, "localhost" | "127.0.0.1" | "[::1]")
    }
}

/// Whether two texts are equal; how long it takes tells nothing of where they differ.
fn equal(a: &str, b: &str) -> bool {
    let differ = a.bytes().zip(b.bytes()).fold(0, |all, (x, y)| all | (x ^ y));
    a.len() == b.len() && std::hint::black_box(differ) == 0
}

/// A token that nobody guesses: 128 random bits.
///
/// # Errors
/// What the system says that has no random numbers.
pub(crate) fn token() -> Result<String, String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|error| format!("no random numbers: {error}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(path: &str, headers: &[(&str, &str)]) -> Request {
        let headers: String = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
        Request::parse(format!("GET {path} HTTP/1.1\r\n{headers}\r\n").as_bytes()).unwrap().unwrap()
    }

    #[test]
    fn on_this_machine_names_and_origins_of_others_are_refused() {
        let gate = Gate { port: 4000, token: None };
        let admit = |headers: &[(&str, &str)]| gate.admit(&request("/", headers)).is_ok();
        for host in ["localhost:4000", "127.0.0.1:4000", "[::1]:4000"] {
            assert!(admit(&[("Host", host)]));
            assert!(admit(&[("Host", host), ("Origin", &format!("http://{host}"))]));
            assert!(!admit(&[("Host", host), ("Origin", "http://evil.example")]));
            assert!(!admit(&[("Host", host), ("Origin", "null")]));
        }
        for host in [
            "evil.example:4000",
            "localhost:4001",
            "localhost",
            "127.0.0.1",
            "[::1]",
            "",
            "localhost.evil.example:4000",
        ] {
            assert!(!admit(&[("Host", host)]), "{host}");
        }
        assert!(!admit(&[("Host", "evil.example:4000"), ("Origin", "http://evil.example:4000")]));
        assert!(!admit(&[]));
    }

    #[test]
    fn from_elsewhere_it_takes_the_token() {
        let token = token().unwrap();
        let gate = Gate { port: 4000, token: Some(token.clone()) };
        let host = [("Host", "box.example:4000")];
        assert!(gate.admit(&request(&format!("/?token={token}"), &host)).is_ok());
        assert!(gate.admit(&request(&format!("/live?a=b&token={token}"), &host)).is_ok());
        let short = &token[..31];
        for wrong in
            ["/", "/?token=", "/?token=0123", &format!("/?token={token}0"), &format!("/?token={short}")]
        {
            assert!(gate.admit(&request(wrong, &host)).is_err(), "{wrong}");
        }
        let evil = [("Host", "box.example:4000"), ("Origin", "http://evil.example")];
        assert!(gate.admit(&request(&format!("/?token={token}"), &evil)).is_err());
        assert_ne!(token, super::token().unwrap());
    }
}
