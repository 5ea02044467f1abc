//! Lights: one file for each kind, with its data, its element of the language, and how that is read.

mod lamp;
mod point;
mod rectangle;

use crate::attributes::Fields;
use crate::kinds::kinds;
use crate::shape::Shape;
use lamp::{Lamp, WrittenLight};

pub use point::PointLight;
pub use rectangle::RectangleLight;

/// How an element becomes a light.
pub(crate) type ReadLight = fn(&mut Fields<'_, '_, '_>, &mut ()) -> Option<LightKind>;

/// A light.
#[derive(Clone, Debug)]
pub struct Light {
    /// The name in the text.
    pub name: String,
    /// Where and how it shines.
    pub kind: LightKind,
}

kinds! {
    /// Where and how a light shines.
    pub enum LightKind: dyn Lamp, read by ReadLight {
        /// `light_point`
        Point(PointLight),
        /// `light_rectangle`
        Rectangle(RectangleLight),
    }
}

impl LightKind {
    /// Whether the light brings nothing.
    pub fn is_dark(&self) -> bool {
        self.common().is_dark()
    }

    /// The surface that shines, in scene space; `None` if no ray can hit the light.
    pub fn surface(&self) -> Option<Shape> {
        self.common().surface()
    }
}
