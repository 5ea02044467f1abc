//! Frames whose pixels are the texels of a light map.

use super::error::FrameError;
use super::kept::Aids;
use super::scene::FrameScene;
use super::texels::Baked;
use slo_accel::Isa;
use slo_scene::material::{Principled, Varying};
use slo_scene::{Material, MaterialKind, SceneDescription};

impl FrameScene {
    /// Builds a frame for the light map of an object, the one with the index `object` in the scene.
    /// Every sample starts at a point of a texel. Reuses what it can of another frame, as
    /// [`build_with`](Self::build_with) does.
    ///
    /// `None` if the frame does not show the object, or if the object has no light map.
    ///
    /// # Errors
    /// Fails in the same cases as [`build`](Self::build).
    pub fn build_light_map(
        scene: &SceneDescription,
        number: i64,
        object: usize,
        isa: Isa,
        mut before: Option<Self>,
    ) -> Result<Option<Self>, FrameError> {
        let Some(light_map) = scene.objects.get(object).and_then(|of| of.light_map) else {
            return Ok(None);
        };
        let mut around = scene.clone();
        let film = &mut around.camera.film;
        (film.width, film.height) = (light_map.side, light_map.side);
        let white = around.materials.len() as u32;
        around.materials.push(white_material());
        let known_light = before.as_mut().map(|of| std::mem::take(&mut of.known_light));
        let known_light = known_light.unwrap_or_default();
        let aids = Aids { before: before.map(|of| of.remains()), ..Aids::default() };
        let frame = Self::build_with(&around, number, isa, aids)?;
        let texels = frame.texels(scene, object, light_map);
        let baked = texels.map(|texels| Baked { texels, white });
        Ok(baked.map(|baked| Self { baked: Some(baked), known_light, ..frame }))
    }
}

fn white_material() -> Material {
    let white = Principled {
        base_color: Varying::constant([1.0; 3]),
        ior: Varying::constant(1.0),
        specular_ior_level: Varying::constant(0.0),
        ..Principled::default()
    };
    Material { name: String::new(), kind: MaterialKind::Principled(white) }
}
