//! The elements at the top of a scene: the one list of the language.

use std::sync::LazyLock;

use super::camera::CAMERA;
use super::key_frames::ADD_KFRAME;
use super::settings::SETTINGS;
use crate::attributes::schema::{Attribute, Schema, block, word};
use crate::attributes::{Language, Referred};
use crate::kinds::Kind;
use crate::light::{LightKind, ReadLight};
use crate::material::{MaterialKind, PHONG_INFO, ReadMaterial};
use crate::shape::{ReadShape, Shape};

/// What an element is in the scene.
#[derive(Clone, Copy, Debug)]
pub(super) enum Role {
    Scaling,
    Settings,
    Camera,
    Light(ReadLight),
    PhongInfo,
    Material(ReadMaterial),
    Texture,
    Object(ReadShape),
}

impl Role {
    /// Whether `Scaling` changes what the element says.
    pub(super) fn has_positions(self) -> bool {
        match self {
            Self::Camera | Self::Light(_) | Self::Object(_) => true,
            Self::Scaling
            | Self::Settings
            | Self::PhongInfo
            | Self::Material(_)
            | Self::Texture => false,
        }
    }

    /// What elements refer to it as, if any does.
    pub(super) fn referred(self) -> Option<Referred> {
        match self {
            Self::PhongInfo => Some(Referred::PhongInfo),
            Self::Material(_) => Some(Referred::Material),
            Self::Texture => Some(Referred::Texture),
            Self::Scaling | Self::Settings | Self::Camera | Self::Light(_) | Self::Object(_) => {
                None
            }
        }
    }
}

/// An element of the language.
#[derive(Debug)]
pub(super) struct Known {
    pub(super) schema: Schema,
    pub(super) role: Role,
}

/// `Scaling`, which holds a number.
const SCALING: Schema = Schema::new("Scaling", &[]);

/// `texture`
const TEXTURE: Schema = Schema::new("texture", &[word("filename", "PATH").required()]);

/// What all objects take beside their shapes.
const OBJECT: &[Attribute] = &[word("material", "NAME").required(), block(&ADD_KFRAME).repeated()];

/// All elements, in the order of messages.
pub(super) static ELEMENTS: LazyLock<Vec<Known>> = LazyLock::new(|| {
    let mut elements = vec![
        Known { schema: SCALING, role: Role::Scaling },
        Known { schema: SETTINGS, role: Role::Settings },
        Known { schema: CAMERA, role: Role::Camera },
    ];
    elements.extend(written(LightKind::KINDS, &[], Role::Light));
    elements.push(Known { schema: PHONG_INFO, role: Role::PhongInfo });
    elements.extend(written(MaterialKind::KINDS, &[], Role::Material));
    elements.push(Known { schema: TEXTURE, role: Role::Texture });
    elements.extend(written(Shape::KINDS, OBJECT, Role::Object));
    elements
});

/// The language of these elements.
pub(super) static LANGUAGE: LazyLock<Language> =
    LazyLock::new(|| Language::new(ELEMENTS.iter().map(|known| &known.schema).collect()));

/// The elements of all kinds of a thing.
fn written<R: Copy>(
    kinds: &'static [Kind<R>],
    common: &'static [Attribute],
    role: fn(R) -> Role,
) -> impl Iterator<Item = Known> {
    kinds.iter().flat_map(move |kind| {
        let role = role(kind.read);
        kind.keywords.iter().map(move |keyword| Known { schema: keyword.schema(common), role })
    })
}
