//! Lights: one file for each kind, with its data, its element of the language, and how that is read.

mod environment;
mod lamp;
mod lamp_disc;
mod lamp_point;
mod lamp_rectangle;
mod lamp_spot;
mod lamp_sun;
mod point;
mod rectangle;

use glam::DVec3;

use crate::attributes::Fields;
use crate::key_frame::KeyFrame;
use crate::key_frame::SpaceId;
use crate::kinds::kinds;
use crate::material::Palette;
use crate::settings::Repeat;
use crate::shape::Shape;
use lamp::{Lamp, WrittenLight};

pub use environment::{Environment, Sky};
pub use lamp_disc::DiscLamp;
pub use lamp_point::PointLamp;
pub use lamp_rectangle::RectangleLamp;
pub use lamp_spot::SpotLamp;
pub use lamp_sun::SunLamp;
pub use point::PointLight;
pub use rectangle::RectangleLight;

/// How an element becomes a light.
pub(crate) type ReadLight =
    for<'a> fn(&mut Fields<'_, 'a, '_>, &mut Palette<'_, 'a>) -> Option<LightKind>;

/// A light.
#[derive(Clone, Debug)]
pub struct Light {
    /// The name in the text.
    pub name: String,
    /// Where and how it shines.
    pub kind: LightKind,
    /// In order of time; none: lamp space is the parent's.
    pub key_frames: Vec<KeyFrame>,
    /// What it hangs in; `None`: scene space.
    pub parent: Option<SpaceId>,
    /// How their motion goes on before the first and after the last; `None`: not at all.
    pub repeat: Option<Repeat>,
    /// Whether camera rays see it. All other rays do.
    pub camera_visible: bool,
    /// Whether it stops rays, as an opaque, black surface does.
    pub solid: bool,
    /// `light_group`: the layer that holds its light.
    pub group: Option<String>,
}

impl Light {
    /// A light that rests where its kind says, in no group, seen by the camera, and solid if it has a
    /// surface.
    pub fn new(name: impl Into<String>, kind: LightKind) -> Self {
        let (key_frames, group) = (Vec::new(), None);
        Self {
            name: name.into(),
            kind,
            key_frames,
            parent: None,
            repeat: None,
            camera_visible: true,
            solid: true,
            group,
        }
    }
}

kinds! {
    /// Where and how a light shines.
    pub enum LightKind: dyn Lamp, read by ReadLight {
        /// `light_point`
        Point(PointLight),
        /// `light_rectangle`
        Rectangle(RectangleLight),
        /// `lamp_point`
        PointLamp(PointLamp),
        /// `lamp_spot`
        SpotLamp(SpotLamp),
        /// `lamp_sun`
        SunLamp(SunLamp),
        /// `lamp_rectangle`
        RectangleLamp(RectangleLamp),
        /// `lamp_disc`
        DiscLamp(DiscLamp),
        /// `environment`
        Environment(Environment),
    }
}

impl LightKind {
    /// Whether the light brings nothing.
    pub fn is_dark(&self) -> bool {
        self.common().is_dark()
    }

    /// The surface that shines, in lamp space; `None` if no ray can hit the light, or if no shape is
    /// like it.
    pub fn surface(&self) -> Option<Shape> {
        self.common().surface()
    }

    /// Hands the flat parts of the surface to `put`, for as long as that returns true, in lamp space.
    pub(crate) fn for_flat_parts(&self, put: &mut dyn FnMut(&[DVec3]) -> bool) {
        self.common().for_flat_parts(put);
    }

    /// Whether it is one of the thesis's lights: its light does not fall off with distance.
    pub fn is_of_thesis(&self) -> bool {
        match self {
            Self::Point(_) | Self::Rectangle(_) => true,
            Self::PointLamp(_)
            | Self::SpotLamp(_)
            | Self::SunLamp(_)
            | Self::RectangleLamp(_)
            | Self::DiscLamp(_)
            | Self::Environment(_) => false,
        }
    }
}
