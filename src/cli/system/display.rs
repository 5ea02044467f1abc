//! Pictures that a viewer on the network shows while they are rendered, by the protocol of
//! [tev](https://github.com/Tom94/tev).
//!
//! A packet is its own length in 4 bytes, its kind in 1 byte, and fields without padding; numbers are
//! little-endian, texts end with a 0 byte. A slow viewer gets the latest light of each tile and misses what came
//! before. If the viewer goes away, the rendering does not notice.

use std::collections::BTreeMap;
use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::cli::base::Terminal;
use slo_picture::film::{Area, Film};

/// How long a viewer may take to answer or to take a packet, and to take the rest at the end.
const PATIENCE: Duration = Duration::from_secs(5);

/// Kinds of packets.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE_V3: u8 = 6;

const CHANNELS: [&str; 3] = ["R", "G", "B"];

/// A connection to a viewer.
pub(crate) struct Display {
    shared: Arc<Shared>,
    terminal: Terminal,
}

/// An image that the viewer shows.
pub(crate) struct DisplayedImage<'a> {
    display: &'a Display,
    name: String,
}

/// What a packet is about: the number of an image, and the row and column of a tile of it, or the image
/// itself.
type Subject = (u64, Option<(u32, u32)>);

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    /// Packets that wait, in the order in which they are sent.
    waiting: BTreeMap<Subject, Vec<u8>>,
    /// Number of the present image.
    image: u64,
    /// Whether a packet is on its way.
    is_sending: bool,
    /// Why nothing is sent any more.
    lost: Option<String>,
    has_ended: bool,
}

impl Display {
    /// Connects to a viewer. If it can't be reached, warns, and returns `None`.
    pub(crate) fn connect(address: &str, terminal: Terminal) -> Option<Self> {
        let stream = match connect(address) {
            Ok(stream) => stream,
            Err(why) => {
                terminal.warn(format_args!(
                    "no viewer answers at `{address}` ({why}); rendering goes on without it"
                ));
                return None;
            }
        };
        let shared = Arc::new(Shared::default());
        let sender = shared.clone();
        thread::spawn(move || sender.send_all(stream));
        Some(Self { shared, terminal })
    }

    /// Begins an image.
    pub(crate) fn image(&self, name: &str, width: u32, height: u32) -> DisplayedImage<'_> {
        let mut state = self.shared.lock();
        state.image += 1;
        let number = state.image;
        state.waiting.insert((number, None), create(name, width, height));
        drop(state);
        self.shared.changed.notify_all();
        DisplayedImage { display: self, name: name.to_owned() }
    }
}

impl DisplayedImage<'_> {
    /// Shows a part of the image as it is now.
    pub(crate) fn show(&self, tile: &Film) {
        let Shared { changed, .. } = &*self.display.shared;
        let area = tile.area();
        let packet = update(&self.name, area, &tile.image().rgb);
        let mut state = self.display.shared.lock();
        if state.lost.is_none() {
            let number = state.image;
            state.waiting.insert((number, Some((area.y0, area.x0))), packet);
            drop(state);
            changed.notify_all();
        }
    }
}

impl Drop for Display {
    /// Waits a little for the viewer to take what is left.
    fn drop(&mut self) {
        let end = Instant::now() + PATIENCE;
        let mut state = self.shared.lock();
        while state.lost.is_none() && (!state.waiting.is_empty() || state.is_sending) {
            let Some(left) = end.checked_duration_since(Instant::now()) else { break };
            let waited = self.shared.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        state.has_ended = true;
        let lost = state.lost.take();
        drop(state);
        self.shared.changed.notify_all();
        if let Some(why) = lost {
            self.terminal.warn(format_args!("the viewer went away: {why}"));
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends what waits until the end.
    fn send_all(&self, mut stream: TcpStream) {
        loop {
            let mut state = self.lock();
            state.is_sending = false;
            self.changed.notify_all();
            let packet = loop {
                if let Some((_, packet)) = state.waiting.pop_first() {
                    state.is_sending = true;
                    break packet;
                }
                if state.has_ended {
                    return;
                }
                state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
            };
            drop(state);
            if let Err(error) = stream.write_all(&packet) {
                let mut state = self.lock();
                (state.is_sending, state.lost) = (false, Some(error.to_string()));
                state.waiting.clear();
                drop(state);
                self.changed.notify_all();
                return;
            }
        }
    }
}

fn connect(address: &str) -> Result<TcpStream, String> {
    let mut last = "it is no address".to_owned();
    for address in address.to_socket_addrs().map_err(|error| error.to_string())? {
        match TcpStream::connect_timeout(&address, PATIENCE) {
            Ok(stream) => {
                stream.set_write_timeout(Some(PATIENCE)).map_err(|error| error.to_string())?;
                return Ok(stream);
            }
            Err(error) => last = error.to_string(),
        }
    }
    Err(last)
}

/// Makes the packet of a new image.
fn create(name: &str, width: u32, height: u32) -> Vec<u8> {
    let mut packet = Packet::new(CREATE_IMAGE, name);
    packet.number(width);
    packet.number(height);
    packet.channels();
    packet.finish()
}

/// Makes the packet of a part of an image, whose pixels are row by row.
fn update(name: &str, area: Area, rgb: &[[f32; 3]]) -> Vec<u8> {
    let mut packet = Packet::new(UPDATE_IMAGE_V3, name);
    packet.channels();
    for number in [area.x0, area.y0, area.width(), area.height()] {
        packet.number(number);
    }
    // Each channel begins at its own number and is three numbers apart.
    for offset in 0..CHANNELS.len() as i64 {
        packet.0.extend(offset.to_le_bytes());
    }
    for _ in CHANNELS {
        packet.0.extend((CHANNELS.len() as i64).to_le_bytes());
    }
    packet.0.extend(rgb.iter().flatten().flat_map(|light| light.to_le_bytes()));
    packet.finish()
}

struct Packet(Vec<u8>);

impl Packet {
    /// A packet about an image, which does not ask the viewer to come to the front.
    fn new(kind: u8, name: &str) -> Self {
        let mut packet = Self(vec![0, 0, 0, 0, kind, 0]);
        packet.text(name);
        packet
    }

    fn text(&mut self, text: &str) {
        self.0.extend(text.bytes().filter(|byte| *byte != 0));
        self.0.push(0);
    }

    /// Signed in the protocol; no picture is that large.
    fn number(&mut self, number: u32) {
        self.0.extend(number.to_le_bytes());
    }

    fn channels(&mut self) {
        self.number(CHANNELS.len() as u32);
        CHANNELS.iter().for_each(|name| self.text(name));
    }

    fn finish(mut self) -> Vec<u8> {
        let length = self.0.len() as u32;
        self.0[..4].copy_from_slice(&length.to_le_bytes());
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_those_of_the_protocol() {
        let made = create("a.exr", 16, 9);
        let expected = b"\x1e\0\0\0\x04\0a.exr\0\x10\0\0\0\x09\0\0\0\x03\0\0\0R\0G\0B\0";
        assert_eq!(made, expected);
        let area = Area { x0: 1, y0: 2, x1: 3, y1: 3 };
        let made = update("a", area, &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let (head, numbers) = made.split_at(made.len() - 24);
        let expected = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0].map(f32::to_le_bytes).concat();
        assert_eq!(numbers, expected);
        assert_eq!(head[..8], [made.len() as u8, 0, 0, 0, 6, 0, b'a', 0]);
        assert_eq!(head[8..18], *b"\x03\0\0\0R\0G\0B\0");
        assert_eq!(head[18..34], [1, 2, 2, 1].map(u32::to_le_bytes).concat());
        assert_eq!(head[34..], [0i64, 1, 2, 3, 3, 3].map(i64::to_le_bytes).concat());
    }
}
