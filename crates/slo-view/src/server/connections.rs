//! Connections: few, and none for ever.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use super::answers::answer;
use super::guard::Guard;
use crate::studio::Link;

/// Most connections at once.
const CONNECTIONS: usize = 256;
/// How long a connection may stay without the head of a request. Browsers open some in advance, and lose
/// requests on those that are closed at the wrong moment.
const HEAD: Duration = Duration::from_secs(60);
/// Longest head of a request.
const LONGEST_HEAD: usize = 16 << 10;
/// Most headers of a request.
const HEADERS: usize = 64;
/// Time before the next try if the system has no connection.
const PAUSE: Duration = Duration::from_millis(50);

/// Accepts connections and answers their requests, without end.
pub(super) async fn accept(
    listener: &TcpListener,
    guard: &Arc<Guard>,
    link: &Arc<Link>,
) -> Infallible {
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        // One too many is closed at once.
        let Ok(place) = free.clone().try_acquire_owned() else { continue };
        let _ = stream.set_nodelay(true);
        let (guard, link) = (guard.clone(), link.clone());
        tokio::spawn(async move {
            let service = service_fn(|request| {
                let (guard, link) = (guard.clone(), link.clone());
                async move { Ok::<_, Infallible>(answer(request, &guard, &link).await) }
            });
            let mut http = http1::Builder::new();
            http.timer(TokioTimer::new()).header_read_timeout(HEAD);
            http.max_buf_size(LONGEST_HEAD).max_headers(HEADERS);
            // Whatever goes wrong with a connection is its own matter.
            let _ = http.serve_connection(TokioIo::new(stream), service).await;
            drop(place);
        });
    }
}
