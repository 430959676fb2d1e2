//! One viewer: a thread that listens and one that sends.

use crate::command::Command;
use crate::director::Order;
use crate::outbox::Outbox;
use crate::scenery::Scenery;
use crate::wire::{self, Sent, SentColors};
use serde_json::json;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::Duration;
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

/// Who takes nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(20);

/// Bytes of a message of the page at most.
const MOST: usize = 16 << 10;

/// Wrong messages that are answered; then the viewer is shown the door.
const MOST_WRONG: usize = 100;

/// Serves a viewer over a connection that has become a WebSocket, until one of both ends it.
pub(crate) fn serve(id: u64, stream: TcpStream, stage: &SyncSender<Order>) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(None)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let outbox = Arc::new(Outbox::default());
    let sender = {
        let (stream, outbox) = (stream.try_clone()?, Arc::clone(&outbox));
        std::thread::Builder::new().name(format!("viewer-{id}")).spawn(move || {
            // That a viewer is gone is no error.
            let _ = send(stream.try_clone(), &outbox);
            let _ = stream.shutdown(Shutdown::Both);
        })?
    };
    if stage.send(Order::Join(id, Arc::clone(&outbox))).is_ok() {
        let half = Half { stream: stream.try_clone()?, outbox: Arc::clone(&outbox) };
        listen(id, half, &outbox, stage);
        let _ = stage.send(Order::Leave(id));
    }
    outbox.close("");
    // The other side may be gone without a word.
    let _ = stream.set_write_timeout(Some(Duration::from_millis(500)));
    let _ = sender.join();
    Ok(())
}

fn config() -> WebSocketConfig {
    WebSocketConfig::default().max_message_size(Some(MOST)).max_frame_size(Some(MOST)).write_buffer_size(0)
}

/// The listening side: what it has to answer to control frames goes out between the messages of the sending side.
struct Half {
    stream: TcpStream,
    outbox: Arc<Outbox>,
}

impl Read for Half {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.stream.read(into)
    }
}

impl Write for Half {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.outbox.control(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn listen(id: u64, half: Half, outbox: &Outbox, stage: &SyncSender<Order>) {
    let mut socket = WebSocket::from_raw_socket(half, Role::Server, Some(config()));
    let mut wrong = 0;
    loop {
        let complaint = match socket.read() {
            Ok(Message::Text(text)) => match Command::read(&text) {
                // The stage has its hands full: this viewer waits, and nobody else.
                Ok(command) => match stage.send(Order::Say(id, command)) {
                    Ok(()) => continue,
                    Err(_) => return,
                },
                Err(why) => why,
            },
            Ok(Message::Binary(bytes)) => match <[u8; 4]>::try_from(&bytes[..]) {
                Ok(number) => {
                    outbox.acknowledge(u32::from_le_bytes(number));
                    continue;
                }
                Err(_) => format!("{} bytes are no number of a moment, expected 4", bytes.len()),
            },
            Ok(Message::Close(_)) | Err(Error::ConnectionClosed | Error::AlreadyClosed) => return,
            Ok(_) => continue,
            Err(Error::Capacity(error)) => {
                outbox.close(&format!("{error}: a command has {MOST} bytes at most"));
                return;
            }
            Err(Error::Utf8(_)) => {
                outbox.close("that is no text");
                return;
            }
            Err(_) => return,
        };
        wrong += 1;
        if wrong > MOST_WRONG {
            outbox.close("too many messages make no sense");
            return;
        }
        outbox.answer(json!({"is": "error", "text": complaint}).to_string().into());
    }
}

fn send(stream: io::Result<TcpStream>, outbox: &Outbox) -> Result<(), Error> {
    let mut raw = stream.as_ref().map_err(|error| Error::Io(error.kind().into()))?.try_clone()?;
    let mut socket = WebSocket::from_raw_socket(stream?, Role::Server, Some(config()));
    let mut known = Known::default();
    loop {
        let parcel = outbox.take();
        if !parcel.control.is_empty() {
            raw.write_all(&parcel.control)?;
        }
        for text in parcel.answers.iter().chain(&parcel.status).chain(&parcel.picked) {
            socket.send(Message::text(&**text))?;
        }
        if let Some((moment, number)) = &parcel.moment {
            for message in known.scenery(&moment.scenery) {
                socket.send(Message::binary(message))?;
            }
            socket.send(Message::binary(moment.message(&mut known.sent, *number)))?;
        }
        if let Some(colors) = &parcel.colors {
            if let Some(message) = colors.message(&mut known.colors) {
                socket.send(Message::binary(message))?;
            }
            if known.colors.legend.as_deref() != Some(&colors.legend) {
                known.colors.legend = Some(Arc::clone(&colors.legend));
                socket.send(Message::text(&*colors.legend))?;
            }
        }
        if let Some(lines) = &parcel.lines {
            socket.send(Message::binary(lines.to_vec()))?;
        }
        if let Some(why) = &parcel.last {
            if !why.is_empty() {
                let text = json!({"is": "error", "text": why}).to_string();
                socket.send(Message::text(text))?;
            }
            socket.close(None)?;
            socket.flush()?;
            return Ok(());
        }
    }
}

/// What a viewer has been sent.
#[derive(Default)]
struct Known {
    scenery: Option<Arc<Scenery>>,
    sent: Sent,
    colors: SentColors,
}

impl Known {
    /// Messages that bring a viewer from the table that it knows to this one.
    fn scenery(&mut self, now: &Arc<Scenery>) -> Vec<Vec<u8>> {
        let mut messages = Vec::new();
        let (mut meshes, mut bodies) = (0, 0);
        match &self.scenery {
            Some(known) if Arc::ptr_eq(known, now) => return messages,
            Some(known) if known.epoch == now.epoch => {
                (meshes, bodies) = (known.meshes.len(), known.bodies.len());
            }
            _ => (self.sent, self.colors) = (Sent::default(), SentColors::default()),
        }
        let anew = bodies == 0;
        if anew {
            messages.push(wire::bodies(0, &[], true));
        }
        if now.meshes.len() > meshes {
            messages.push(wire::meshes(meshes, now.meshes[meshes..].iter().map(Arc::as_ref)));
        }
        if now.bodies.len() > bodies {
            messages.push(wire::bodies(bodies, &now.bodies[bodies..], false));
        }
        self.scenery = Some(Arc::clone(now));
        messages
    }
}
