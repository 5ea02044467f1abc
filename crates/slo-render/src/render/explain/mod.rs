//! Accounts of the samples of one pixel, and what they add up to.

mod tally;
mod way;

use std::ops::Range;

use super::guide;
use super::photon_map::photon_light;
use super::photons::maps_of;
use crate::frame::FrameScene;
use crate::integrator::{Account, Beside, Tracer, Work};
use crate::photons::pass_of;
use slo_scene::Integrator;

pub use tally::{Bright, Share, Tally, luminance, rays_of};
pub use way::{Names, Step, word};

/// Traces samples of the pixel in a column and row once more, and passes each with its account to
/// `tell`, in order. Its light is, bit by bit, the one that a picture holds of the sample. Returns `None` if
/// `gives_up` said to give up.
///
/// Photons and the field that guides rays are those of a picture. They are traced on the threads of the
/// current rayon pool, samples on one of them.
pub fn explain(
    frame: &FrameScene,
    [x, y]: [u32; 2],
    samples: Range<u32>,
    gives_up: &(dyn Fn() -> bool + Sync),
    tell: &mut dyn FnMut(u32, &Account),
) -> Option<()> {
    guide::learn(frame, &|_| {}, gives_up)?;
    let light = match frame.settings.integrator {
        Integrator::PhotonMap => Some(photon_light(frame, gives_up)?),
        _ => None,
    };
    let mut tracer = Tracer::default();
    let mut maps = None;
    for first in samples {
        let pass = pass_of(first);
        if frame.emission.is_some() && maps.as_ref().is_none_or(|(of, _)| *of != pass) {
            maps = Some((pass, maps_of(frame, pass, gives_up)?));
        }
        let maps = maps.as_ref().map(|(_, maps)| maps);
        let beside = Beside { maps, light: light.as_ref(), ..Beside::default() };
        let work = Work { x, y, first, count: 1 };
        let account = tracer.account(frame, work, beside, &gives_up)?;
        tell(first, &account);
    }
    Some(())
}
