//! One request of HTTP, and its answer. A connection serves one of them: pages are small, and what lasts is the WebSocket.

use std::io::{self, Read, Write};
use std::net::TcpStream;

/// Bytes of a request's head at most.
const MOST_HEAD: usize = 16 << 10;

/// Headers at most.
const MOST_HEADERS: usize = 100;

/// The head of a request.
#[derive(Debug)]
pub(crate) struct Request {
    pub(crate) method: String,
    path: String,
    query: String,
    headers: Vec<(String, String)>,
}

impl Request {
    /// Reads one. `None` where nobody asked for anything.
    ///
    /// # Errors
    /// Says what is wrong with it.
    pub(crate) fn read(stream: &mut TcpStream) -> io::Result<Option<Self>> {
        let wrong = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text);
        let mut head = Vec::new();
        let mut piece = [0; 2048];
        while head.len() < MOST_HEAD {
            let read = stream.read(&mut piece)?;
            if read == 0 {
                return if head.is_empty() { Ok(None) } else { Err(wrong("the request has no end")) };
            }
            head.extend_from_slice(&piece[..read]);
            if let Some(request) = Request::parse(&head).map_err(|text| wrong(&text))? {
                return Ok(Some(request));
            }
        }
        Err(wrong("the request is too long"))
    }

    /// The request of a head; `None` where there is more to come. What stands behind the head is of no use here: a client has nothing to say before it is answered.
    ///
    /// # Errors
    /// Says what is wrong with it.
    pub(crate) fn parse(head: &[u8]) -> Result<Option<Self>, String> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut parsed = httparse::Request::new(&mut headers);
        let status = parsed.parse(head).map_err(|error| format!("that is no request: {error}"))?;
        if status.is_partial() {
            return Ok(None);
        }
        let target = parsed.path.unwrap_or_default();
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let text = |value: &[u8]| String::from_utf8_lossy(value).trim().to_owned();
        let headers = parsed.headers.iter().map(|header| (header.name.to_lowercase(), text(header.value)));
        Ok(Some(Request {
            method: parsed.method.unwrap_or_default().to_owned(),
            path: path.to_owned(),
            query: query.to_owned(),
            headers: headers.collect(),
        }))
    }

    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// A header; `None` also where it is there twice, for then nobody knows which one counts.
    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        let mut found = self.headers.iter().filter(|(known, _)| known == name);
        let value = found.next().map(|(_, value)| value.as_str());
        value.filter(|_| found.next().is_none())
    }

    /// A value of the query, as it is written.
    pub(crate) fn query(&self, name: &str) -> Option<&str> {
        self.query
            .split('&')
            .find_map(|pair| pair.split_once('=').filter(|(key, _)| *key == name))
            .map(|(_, value)| value)
    }

    /// The key of a WebSocket that is asked for.
    pub(crate) fn websocket_key(&self) -> Option<&str> {
        let has = |name: &str, word: &str| {
            self.header(name)
                .is_some_and(|value| value.to_lowercase().split(',').any(|part| part.trim() == word))
        };
        let asked = self.method == "GET" && has("upgrade", "websocket") && has("connection", "upgrade");
        self.header("sec-websocket-key")
            .filter(|_| asked && self.header("sec-websocket-version") == Some("13"))
    }
}

/// Writes an answer and its body.
pub(crate) fn respond(
    stream: &mut TcpStream,
    status: &str,
    kind: &str,
    body: &[u8],
    whole: bool,
) -> io::Result<()> {
    // Nothing comes from elsewhere, nobody may frame the page, and the token stays here.
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Content-Security-Policy: default-src 'self'; img-src 'self' data: blob:; frame-ancestors 'none'\r\n\r\n",
        body.len()
    );
    // In one piece: clients of WebSockets read what explains a refusal only where it comes with the head.
    let mut answer = head.into_bytes();
    if whole {
        answer.extend_from_slice(body);
    }
    stream.write_all(&answer)?;
    stream.flush()
}

/// A refusal, as a page for people.
pub(crate) fn refuse(stream: &mut TcpStream, status: &str, why: &str) -> io::Result<()> {
    let body = format!("<!doctype html><meta charset=utf-8><title>Rockfall</title><p>{why}.\n");
    respond(stream, status, "text/html; charset=utf-8", body.as_bytes(), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_whole_or_not_at_all() {
        let head = b"GET /live?token=ab&x=1 HTTP/1.1\r\nHost: a\r\nUpgrade: WebSocket\r\nConnection: keep-alive, Upgrade\r\nSec-WebSocket-Key: k\r\nSec-WebSocket-Version: 13\r\nTwice: 1\r\nTwice: 2\r\n\r\n";
        for end in 0..head.len() {
            assert!(Request::parse(&head[..end]).unwrap().is_none(), "{end}");
        }
        let request = Request::parse(head).unwrap().unwrap();
        assert_eq!((request.path(), request.query("token"), request.query("y")), ("/live", Some("ab"), None));
        assert_eq!((request.header("host"), request.header("twice")), (Some("a"), None));
        assert_eq!(request.websocket_key(), Some("k"));
        for rubbish in [&b"\x16\x03\x01\x02\x00"[..], b"GET\r\n\r\n", b"\0\0\0\0"] {
            assert!(Request::parse(rubbish).is_err());
        }
    }
}
