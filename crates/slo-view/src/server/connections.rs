//! Connections: few, and none for ever.

use std::convert::Infallible;
use std::future::{Future, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use super::answers::answer;
use super::guard::Guard;
use super::idle::Idle;
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
/// How long a new connection waits for the place of one that makes room.
const ROOM: Duration = Duration::from_secs(1);
/// Time before the next try if the system has no connection.
const PAUSE: Duration = Duration::from_millis(50);

/// Accepts connections and answers their requests, without end.
pub(super) async fn accept(
    listener: &TcpListener,
    guard: &Arc<Guard>,
    link: &Arc<Link>,
) -> Infallible {
    let free = Arc::new(Semaphore::new(CONNECTIONS));
    let idle = Arc::new(Idle::default());
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            tokio::time::sleep(PAUSE).await;
            continue;
        };
        let place = match free.clone().try_acquire_owned() {
            Ok(place) => place,
            // If all are busy, one too many is closed at once.
            Err(_) if !idle.make_room() => continue,
            Err(_) => match tokio::time::timeout(ROOM, free.clone().acquire_owned()).await {
                Ok(Ok(place)) => place,
                _ => continue,
            },
        };
        let _ = stream.set_nodelay(true);
        let (guard, link) = (guard.clone(), link.clone());
        let connection = idle.enter();
        tokio::spawn(async move {
            let connection = &connection;
            let service = service_fn(|request| {
                let (guard, link) = (guard.clone(), link.clone());
                async move {
                    connection.is_busy();
                    let answer = answer(request, &guard, &link).await;
                    connection.waits();
                    Ok::<_, Infallible>(answer)
                }
            });
            let mut http = http1::Builder::new();
            http.timer(TokioTimer::new()).header_read_timeout(HEAD);
            http.max_buf_size(LONGEST_HEAD).max_headers(HEADERS);
            // Whatever goes wrong with a connection is its own matter.
            let served = http.serve_connection(TokioIo::new(stream), service);
            let (mut served, mut closed) = (pin!(served), pin!(connection.must_close()));
            let either = |context: &mut Context<'_>| {
                let is_over = served.as_mut().poll(context).is_ready()
                    || closed.as_mut().poll(context).is_ready();
                if is_over { Poll::Ready(()) } else { Poll::Pending }
            };
            poll_fn(either).await;
            drop(place);
        });
    }
}
