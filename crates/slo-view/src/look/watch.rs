//! Who watches a piece of the picture: stops it as soon as something changes, and shows it if it takes
//! long.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use slo_picture::film::{Film, Steps};
use slo_render::render::Observer;

/// Time between two pictures of one piece.
const PAUSE: Duration = Duration::from_millis(300);

pub(super) struct Watch<'a> {
    stop: &'a (dyn Fn() -> bool + Sync),
    show: Option<&'a (dyn Fn(&Film) + Sync)>,
    shown: Mutex<Instant>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(stop: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { stop, show: None, shown: Mutex::new(Instant::now()) }
    }

    pub(super) fn showing(self, show: &'a (dyn Fn(&Film) + Sync)) -> Self {
        Self { show: Some(show), ..self }
    }
}

impl Observer for Watch<'_> {
    fn advanced(&self, _: f64) {}

    fn should_stop(&self) -> bool {
        (self.stop)()
    }

    fn gives_up(&self) -> bool {
        (self.stop)()
    }

    fn wants_film(&self) -> bool {
        // One thread is enough.
        let Ok(mut shown) = self.shown.try_lock() else { return false };
        let is_due = self.show.is_some() && shown.elapsed() > PAUSE;
        if is_due {
            *shown = Instant::now();
        }
        is_due
    }

    fn keep(&self, film: Option<Film>, _: Steps) {
        if let (Some(show), Some(film)) = (self.show, film) {
            show(&film);
        }
    }
}
