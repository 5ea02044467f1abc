//! What every shape must say of itself.

use glam::DVec3;

use crate::assets::Assets;
use crate::attributes::Fields;
use crate::kinds::Keyword;
use crate::light_map::Unwrapped;

/// A surface, in object space.
pub(super) trait Surface {
    /// Number of triangles that the shape consists of; 0 if it is curved.
    fn triangle_count(&self) -> usize;

    /// Whether only the outside of the surface can be seen from outside of it.
    fn is_closed(&self) -> bool;

    /// Hands the flat parts of the surface to `put`, for as long as that returns true:
    /// counter-clockwise seen from outside, in object space.
    fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool);

    /// Returns where the surface lies in images, by its texture coordinates.
    ///
    /// # Errors
    /// Why no place in an image belongs to one place of the surface.
    fn unwrapped(&self) -> Result<Unwrapped, &'static str>;

    /// Whether all of its indices lead somewhere.
    fn is_consistent(&self) -> bool {
        true
    }
}

/// A shape that has an element of the language.
pub(super) trait WrittenShape: Surface + Sized {
    /// The element, and what it takes beside what all objects take.
    const KEYWORDS: &'static [Keyword];

    /// Reads the element; `None` if something is wrong, which is reported.
    fn read(fields: &mut Fields<'_, '_, '_>, assets: &mut Assets<'_>) -> Option<Self>;
}
