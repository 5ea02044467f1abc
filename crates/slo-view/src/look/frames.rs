//! The frame that is looked at, which changes as little as it must.

use slo_accel::Isa;
use slo_render::frame::{Aids, FrameError, FrameScene};
use slo_scene::{Integrator, SceneDescription};

/// What a frame is needed for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Purpose {
    /// Number of the scene: everything but its camera.
    pub(super) content: u64,
    /// Number of the picture: its camera too.
    pub(super) picture: u64,
    /// Pixels.
    pub(super) size: [u32; 2],
    /// Seconds that the shutter of each segment stays open.
    pub(super) shutters: Vec<f64>,
    /// Whether it is for a draft, without what takes long to prepare.
    pub(super) is_draft: bool,
    /// Whether it is for finding out what is seen, with layers and a sharp lens.
    pub(super) is_sharp: bool,
    /// Whether costs of pixels are counted.
    pub(super) counts: bool,
}

/// Builds frames from those before.
#[derive(Debug, Default)]
pub(super) struct Frames {
    last: Option<(FrameScene, Purpose)>,
    /// What has a structure of its own, because it is likely to be moved.
    apart: Option<String>,
    /// Why costs can't be counted.
    uncounted: Option<String>,
}

impl Frames {
    /// An object or a lamp is likely to be moved.
    pub(super) fn set_apart(&mut self, name: Option<&str>) {
        self.apart = name.map(str::to_owned);
    }

    /// Why costs can't be counted.
    pub(super) fn uncounted(&self) -> Option<&str> {
        self.uncounted.as_deref()
    }

    /// Makes a frame of a scene for a purpose, unless it is there.
    pub(super) fn make(
        &mut self,
        scene: &SceneDescription,
        number: i64,
        isa: Isa,
        purpose: Purpose,
    ) -> Result<&FrameScene, FrameError> {
        let is_draft = purpose.is_draft && has_drafts(scene);
        let purpose = Purpose { is_draft, ..purpose };
        let frame = match self.last.take() {
            Some((frame, last)) if last == purpose => frame,
            last => {
                let mut frame = self.changed(last, scene, number, isa, &purpose)?;
                let refused = purpose.counts.then(|| frame.count(true).err()).flatten();
                self.uncounted = refused.map(|error| error.to_string());
                frame
            }
        };
        Ok(&self.last.insert((frame, purpose)).0)
    }

    /// Makes another frame of the last one.
    fn changed(
        &self,
        last: Option<(FrameScene, Purpose)>,
        scene: &SceneDescription,
        number: i64,
        isa: Isa,
        purpose: &Purpose,
    ) -> Result<FrameScene, FrameError> {
        let mut before = None;
        if let Some((frame, last)) = last {
            before = Some(frame.remains_for_others());
            let of = |of: &Purpose| (of.content, of.is_draft, of.shutters.clone());
            let is_same = of(&last) == of(purpose);
            if is_same && let Some(frame) = frame.seen_anew(scene, number)? {
                return Ok(frame);
            }
        }
        let aids = Aids { before, stays: true, apart: self.apart.clone(), ..Aids::default() };
        match purpose.is_draft {
            false => FrameScene::build_with(scene, number, isa, aids),
            true => FrameScene::build_with(&draft(scene), number, isa, aids),
        }
    }
}

/// Whether drafts of a scene leave something out.
fn has_drafts(scene: &SceneDescription) -> bool {
    let settings = &scene.settings;
    settings.photons > 0.0 || settings.guide || settings.integrator == Integrator::PhotonMap
}

/// The scene without what takes long to prepare.
fn draft(scene: &SceneDescription) -> SceneDescription {
    let mut scene = scene.clone();
    scene.settings.photons = 0.0;
    scene.settings.guide = false;
    if scene.settings.integrator == Integrator::PhotonMap {
        scene.settings.integrator = Integrator::Path;
    }
    scene
}
