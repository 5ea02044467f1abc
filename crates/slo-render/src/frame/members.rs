//! What hangs in the spaces of a scene.

use slo_scene::{SceneDescription, SpaceId};

/// Indices of what hangs in each space directly, and is not hidden.
#[derive(Debug, Default)]
pub(super) struct Members {
    pub(super) objects: Vec<Vec<u32>>,
    pub(super) lights: Vec<Vec<u32>>,
    pub(super) copies: Vec<Vec<u32>>,
    pub(super) spaces: Vec<Vec<u32>>,
}

impl Members {
    /// Of all spaces of a scene.
    pub(super) fn of(scene: &SceneDescription) -> Self {
        let sorted = |parents: &mut dyn Iterator<Item = (bool, Option<SpaceId>)>| {
            let mut members = vec![Vec::new(); scene.spaces.len()];
            for (number, (is_hidden, parent)) in (0u32..).zip(parents) {
                if let Some(parent) = parent.filter(|_| !is_hidden) {
                    members[parent.0 as usize].push(number);
                }
            }
            members
        };
        Self {
            objects: sorted(&mut scene.objects.iter().map(|of| (of.hidden, of.parent))),
            lights: sorted(&mut scene.lights.iter().map(|of| (false, of.parent))),
            copies: sorted(&mut scene.copies.iter().map(|of| (of.hidden, of.parent))),
            spaces: sorted(&mut scene.spaces.iter().map(|of| (of.hidden, of.parent))),
        }
    }
}
