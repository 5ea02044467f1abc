//! Connections that wait for a request: the one that has waited longest makes room for a new one.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};

use tokio::sync::Notify;

/// Connections without a request, in the order in which they began to wait.
#[derive(Debug, Default)]
pub(super) struct Idle(Mutex<Waiting>);

#[derive(Debug, Default)]
struct Waiting {
    next: u64,
    all: BTreeMap<u64, Arc<Notify>>,
}

/// A connection, from its beginning to its end.
#[derive(Debug)]
pub(super) struct Connection {
    idle: Arc<Idle>,
    close: Arc<Notify>,
    /// Its place while it waits.
    place: Mutex<Option<u64>>,
}

impl Idle {
    /// A new connection, which waits for its first request.
    pub(super) fn enter(self: &Arc<Self>) -> Connection {
        let connection = Connection {
            idle: self.clone(),
            close: Arc::new(Notify::new()),
            place: Mutex::new(None),
        };
        connection.waits();
        connection
    }

    /// Closes the connection that has waited longest. False if all are busy.
    pub(super) fn make_room(&self) -> bool {
        let longest = lock(&self.0).all.pop_first();
        if let Some((_, close)) = &longest {
            close.notify_one();
        }
        longest.is_some()
    }
}

impl Connection {
    /// It waits for a request from now on.
    pub(super) fn waits(&self) {
        let mut waiting = lock(&self.idle.0);
        let place = waiting.next;
        waiting.next += 1;
        waiting.all.insert(place, self.close.clone());
        if let Some(before) = lock(&self.place).replace(place) {
            waiting.all.remove(&before);
        }
    }

    /// It has a request, which is answered.
    pub(super) fn is_busy(&self) {
        let mut waiting = lock(&self.idle.0);
        if let Some(place) = lock(&self.place).take() {
            waiting.all.remove(&place);
        }
    }

    /// Returns when the connection must make room.
    pub(super) async fn must_close(&self) {
        self.close.notified().await;
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.is_busy();
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_that_has_waited_longest_makes_room() {
        let idle = Arc::new(Idle::default());
        let [a, b, c] = [(); 3].map(|()| idle.enter());
        let waits = |of: &Connection| {
            lock(&of.place).is_some_and(|place| lock(&idle.0).all.contains_key(&place))
        };
        a.is_busy();
        assert!(idle.make_room());
        assert!(!waits(&a) && !waits(&b) && waits(&c));
        a.waits();
        drop(b);
        assert!(idle.make_room());
        assert!(waits(&a) && !waits(&c));
        drop(a);
        assert!(!idle.make_room());
    }
}
