//! What the thread of the scene and the server have in common.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex};

use serde_json::Value;
use slo_scene::Look;
use tokio::sync::{oneshot, watch};

use crate::command::Command;
use crate::finished::{Finishing, Progress};
use crate::look::Shot;

/// A request, and whom to answer: with the number of the picture that shows it, or why it can't be done.
#[derive(Debug)]
pub(crate) struct Message {
    pub(crate) command: Command,
    pub(crate) reply: oneshot::Sender<Result<u64, String>>,
}

/// What is on the screen.
#[derive(Clone, Debug)]
pub(crate) struct Shown {
    /// Counts what was on the screen.
    pub(crate) number: u64,
    pub(crate) shot: Shot,
    pub(crate) look: Look,
}

/// What the thread of the scene and the server have in common.
#[derive(Debug)]
pub(crate) struct Link {
    inbox: Mutex<Sender<Message>>,
    /// Number of requests that wait.
    waiting: AtomicUsize,
    shown: watch::Sender<Option<Arc<Shown>>>,
    /// Number of changes, and what there is to know, as JSON.
    state: watch::Sender<(u64, Value)>,
    finishing: Mutex<Finishing>,
}

impl Link {
    pub(crate) fn new(inbox: Sender<Message>) -> Self {
        Self {
            inbox: Mutex::new(inbox),
            waiting: AtomicUsize::new(0),
            shown: watch::Sender::new(None),
            state: watch::Sender::new((0, Value::Null)),
            finishing: Mutex::default(),
        }
    }

    /// Passes a request on. The answer fails if the thread of the scene has ended.
    pub(crate) fn ask(&self, command: Command) -> oneshot::Receiver<Result<u64, String>> {
        let (reply, answer) = oneshot::channel();
        self.waiting.fetch_add(1, Ordering::SeqCst);
        let inbox = self.inbox.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let _ = inbox.send(Message { command, reply });
        answer
    }

    /// Whether requests wait.
    pub(crate) fn is_waited_for(&self) -> bool {
        self.waiting.load(Ordering::SeqCst) > 0
    }

    /// Number of requests that wait.
    pub(crate) fn waiting(&self) -> usize {
        self.waiting.load(Ordering::SeqCst)
    }

    /// Notes that a request does not wait any more.
    pub(super) fn took(&self) {
        self.waiting.fetch_sub(1, Ordering::SeqCst);
    }

    /// Puts a picture on the screen.
    pub(super) fn show(&self, shot: Shot, look: Look) {
        self.shown.send_modify(|shown| {
            let number = shown.as_ref().map_or(1, |shown| shown.number + 1);
            *shown = Some(Arc::new(Shown { number, shot, look }));
        });
    }

    /// Shows the picture in another way.
    pub(super) fn tone(&self, look: Look) {
        self.shown.send_modify(|shown| {
            if let Some(before) = shown.take() {
                let (number, shot) = (before.number + 1, before.shot.clone());
                *shown = Some(Arc::new(Shown { number, shot, look }));
            }
        });
    }

    /// What is on the screen.
    pub(crate) fn screen(&self) -> watch::Receiver<Option<Arc<Shown>>> {
        self.shown.subscribe()
    }

    /// Makes known what there is to know, if it is new.
    pub(super) fn tell(&self, news: Value) {
        self.state.send_if_modified(|(number, state)| {
            let is_new = *state != news;
            if is_new {
                (*number, *state) = (*number + 1, news);
            }
            is_new
        });
    }

    /// What there is to know.
    pub(crate) fn state(&self) -> watch::Receiver<(u64, Value)> {
        self.state.subscribe()
    }

    /// Notes that there is news of the finished frame.
    pub(super) fn finishing_changed(&self) {
        self.state.send_modify(|(number, _)| *number += 1);
    }

    /// Another frame is finished from now on; the one before is cancelled.
    pub(super) fn set_finishing(&self, finishing: Finishing) {
        let mut current = self.finishing.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        current.cancel();
        *current = finishing;
    }

    /// How far the finished frame is.
    pub(crate) fn finished(&self) -> Progress {
        self.finishing.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).progress()
    }
}
