//! Images as materials use them.

/// Index into the textures of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureId(pub u32);

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureUse {
    /// The image.
    pub texture: TextureId,
    /// `scale_U`, `scale_V`: repetitions over one unit of uv.
    pub scale: [f32; 2],
}
