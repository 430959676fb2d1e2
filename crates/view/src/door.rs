//! The address at which the page is, and those who come to it.

use crate::director::{Director, Order};
use crate::gate::{self, Gate};
use crate::request::{Request, refuse, respond};
use crate::{Error, Source, page, viewer};
use std::io::{ErrorKind, Write};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener, TcpStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;
use tungstenite::handshake::derive_accept_key;

/// Connections at a time.
const MOST: usize = 128;

/// A request has to be there after so long.
const PATIENCE: Duration = Duration::from_secs(10);

/// Orders that wait for the stage; who gives more waits.
const ORDERS: usize = 256;

/// Where and how the page is served.
#[derive(Clone, Debug)]
pub struct Options {
    /// The address to listen at. Any but the loopback ones asks for a token.
    pub host: IpAddr,
    /// The port; 0 for one that is free.
    pub port: u16,
    /// Where scenes are saved.
    pub saves: PathBuf,
}

impl Default for Options {
    /// This machine alone, any port.
    fn default() -> Self {
        Options { host: IpAddr::V4(Ipv4Addr::LOCALHOST), port: 0, saves: "saved".into() }
    }
}

/// An address that is ours, before there is anything to show.
#[derive(Debug)]
pub struct Door {
    listener: TcpListener,
    address: SocketAddr,
    gate: Gate,
    saves: PathBuf,
}

impl Door {
    /// Takes the address.
    ///
    /// # Errors
    /// [`Error::Taken`], [`Error::Listen`], [`Error::Start`].
    pub fn open(options: &Options) -> Result<Self, Error> {
        let wanted = SocketAddr::new(options.host, options.port);
        let failed = |error: std::io::Error| match error.kind() {
            ErrorKind::AddrInUse => Error::Taken(wanted),
            _ => Error::Listen { address: wanted, reason: error.to_string() },
        };
        let listener = TcpListener::bind(wanted).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let token =
            if options.host.is_loopback() { None } else { Some(gate::token().map_err(Error::Start)?) };
        let gate = Gate { port: address.port(), token };
        Ok(Door { listener, address, gate, saves: options.saves.clone() })
    }

    /// The address of the page, with its token.
    pub fn url(&self) -> String {
        let mut at = self.address;
        // All addresses are none that one could open.
        match at.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => at.set_ip(Ipv4Addr::LOCALHOST.into()),
            IpAddr::V6(ip) if ip.is_unspecified() => at.set_ip(Ipv6Addr::LOCALHOST.into()),
            _ => {}
        }
        let token = self.gate.token.as_ref().map(|token| format!("?token={token}"));
        format!("http://{at}/{}", token.unwrap_or_default())
    }

    /// Shows something there from now on.
    ///
    /// # Errors
    /// [`Error::Start`].
    pub fn serve(self, source: Source) -> Result<Server, Error> {
        let started = |error: std::io::Error| Error::Start(error.to_string());
        let url = self.url();
        let Door { listener, address, gate, saves } = self;
        let (stage, orders) = sync_channel(ORDERS);
        let director = Director::new(source, saves);
        let director = std::thread::Builder::new()
            .name("stage".into())
            .spawn(move || director.run(&orders))
            .map_err(started)?;
        let ended = Arc::new(AtomicBool::new(false));
        let hall = Hall {
            gate: Arc::new(gate),
            stage: stage.clone(),
            inside: Arc::default(),
            ended: Arc::clone(&ended),
        };
        let door = std::thread::Builder::new()
            .name("door".into())
            .spawn(move || hall.keep(&listener))
            .map_err(started)?;
        Ok(Server { url, address, stage, ended, threads: vec![director, door] })
    }
}

/// A page that is being served. It ends when it is dropped.
#[derive(Debug)]
pub struct Server {
    url: String,
    address: SocketAddr,
    stage: SyncSender<Order>,
    ended: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// The address of the page, with its token.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits until it ends, which only an error makes it do by itself.
    pub fn wait(mut self) {
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        let _ = self.stage.send(Order::Quit);
        // The door waits for somebody to come.
        let mut at = self.address;
        if at.ip().is_unspecified() {
            at.set_ip(if at.is_ipv4() { Ipv4Addr::LOCALHOST.into() } else { Ipv6Addr::LOCALHOST.into() });
        }
        let _ = TcpStream::connect_timeout(&at, Duration::from_secs(1));
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Takes in those who come.
#[derive(Clone, Debug)]
struct Hall {
    gate: Arc<Gate>,
    stage: SyncSender<Order>,
    inside: Arc<AtomicUsize>,
    ended: Arc<AtomicBool>,
}

impl Hall {
    fn keep(&self, listener: &TcpListener) {
        let mut id = 0;
        for stream in listener.incoming() {
            if self.ended.load(Ordering::Relaxed) {
                return;
            }
            let Ok(mut stream) = stream else {
                // No more files, say: that passes.
                std::thread::sleep(Duration::from_millis(20));
                continue;
            };
            id += 1;
            if self.inside.fetch_add(1, Ordering::Relaxed) >= MOST {
                let _ = refuse(&mut stream, "503 Service Unavailable", "too many are looking already");
                self.inside.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let hall = self.clone();
            let started = std::thread::Builder::new().name(format!("guest-{id}")).spawn(move || {
                // Who breaks off has nobody to be told.
                let _ = hall.receive(id, stream);
                hall.inside.fetch_sub(1, Ordering::Relaxed);
            });
            if started.is_err() {
                self.inside.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }

    fn receive(&self, id: u64, mut stream: TcpStream) -> std::io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = match Request::read(&mut stream) {
            Ok(Some(request)) => request,
            Ok(None) => return Ok(()),
            Err(error) if error.kind() == ErrorKind::InvalidData => {
                return refuse(&mut stream, "400 Bad Request", &error.to_string());
            }
            Err(error) => return Err(error),
        };
        // The files of the page are in everybody's hands; what it shows is not.
        let guarded = matches!(request.path(), "/" | "/live");
        if let Err(why) = self.gate.admit(&request)
            && guarded
        {
            return refuse(&mut stream, "403 Forbidden", why);
        }
        if request.path() == "/live" {
            let Some(key) = request.websocket_key() else {
                return refuse(
                    &mut stream,
                    "426 Upgrade Required",
                    "here is a WebSocket, version 13, and no page",
                );
            };
            let accept = derive_accept_key(key.as_bytes());
            let head = format!(
                "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: {accept}\r\n\r\n"
            );
            stream.write_all(head.as_bytes())?;
            return viewer::serve(id, stream, &self.stage);
        }
        let whole = request.method == "GET";
        if !whole && request.method != "HEAD" {
            return refuse(&mut stream, "405 Method Not Allowed", "the page is only to be read");
        }
        match page::file(request.path()) {
            Some((kind, content)) => respond(&mut stream, "200 OK", kind, content, whole),
            None => refuse(&mut stream, "404 Not Found", "there is nothing at this address"),
        }
    }
}
