//! The server: requests of the page, and nothing of the scene.

mod answers;
mod connections;
mod guard;
mod idle;
mod page;
mod rate;
mod token;

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc;

use rayon::ThreadPool;
use slo_accel::Isa;
use slo_scene::animation::NoSegment;
use tokio::net::TcpListener;
use tokio::runtime::Builder;
use tokio::sync::oneshot;

use crate::source::Source;
use crate::studio::{Link, Studio};
pub(crate) use guard::Guard;
use token::Token;

/// How a scene is shown.
#[derive(Debug)]
pub struct Options {
    /// Where to listen: an address of this machine, and a port or 0 for any.
    pub listen: SocketAddr,
    /// The first frame to be shown: it must be one of the scene's, if that has no errors. `None`: the
    /// scene's first.
    pub frame: Option<i64>,
    /// The threads that render.
    pub pool: ThreadPool,
    /// Their instruction set.
    pub isa: Isa,
}

/// Why a scene can't be shown.
#[derive(Debug)]
pub enum Error {
    /// The address can't be listened on.
    Listen(io::Error),
    /// The scene has no such frame.
    Frame(NoSegment),
    /// The system has no threads or random numbers.
    System(String),
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listen(error) => write!(f, "can't listen: {error}"),
            Self::Frame(error) => error.fmt(f),
            Self::System(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for Error {}

/// Shows a scene until the program ends. `ready` receives the address of the page, which contains a secret.
///
/// # Errors
/// See [`Error`].
pub fn serve(
    source: Box<dyn Source>,
    options: Options,
    ready: impl FnOnce(&str),
) -> Result<(), Error> {
    let Options { listen, frame, pool, isa } = options;
    let system = |error: &dyn fmt::Display| Error::System(error.to_string());
    let runtime =
        Builder::new_current_thread().enable_io().enable_time().build().map_err(|e| system(&e))?;
    let token = Token::random().map_err(|e| system(&e))?;
    runtime.block_on(async {
        let listener = TcpListener::bind(listen).await.map_err(Error::Listen)?;
        let address = listener.local_addr().map_err(Error::Listen)?;
        let (sender, inbox) = mpsc::channel();
        let link = Arc::new(Link::new(sender));
        let (ended, end) = oneshot::channel();
        let studio_link = link.clone();
        let (loaded, load) = oneshot::channel();
        let work = move || {
            let studio = Studio::new(source, frame, Arc::new(pool), isa, studio_link, inbox);
            let fault = frame.and_then(|frame| studio.lacks(frame));
            let is_there = fault.is_none();
            let _ = loaded.send(fault);
            if is_there {
                studio.run();
            }
            let _ = ended.send(());
        };
        let studio = std::thread::Builder::new().name("studio".into()).spawn(work);
        let studio = studio.map_err(|e| system(&e))?;
        if frame.is_some()
            && let Ok(Some(fault)) = load.await
        {
            return Err(Error::Frame(fault));
        }
        ready(&format!("http://{}/{}/", reachable(address), token.text()));
        let guard = Arc::new(Guard::new(token, address));
        tokio::spawn(async move { connections::accept(&listener, &guard, &link).await });
        // The studio ends by itself only if it fails.
        let _ = end.await;
        match studio.join() {
            Ok(()) => Ok(()),
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}

/// The address under which this machine reaches itself.
fn reachable(address: SocketAddr) -> SocketAddr {
    let mut reachable = address;
    if address.ip().is_unspecified() {
        reachable.set_ip(match address {
            SocketAddr::V4(_) => std::net::Ipv4Addr::LOCALHOST.into(),
            SocketAddr::V6(_) => std::net::Ipv6Addr::LOCALHOST.into(),
        });
    }
    reachable
}
