//! The elements at the top of a scene: the one list of the language.

use std::sync::LazyLock;

use super::camera::CAMERA;
use super::settings::SETTINGS;
use super::texture::TEXTURE;
use crate::attributes::schema::{Attribute, Schema, block, number, word};
use crate::attributes::{ADD_KFRAME, Language, PARENT, REPEAT, Referred};
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
    Group,
    Copy,
}

impl Role {
    /// Whether `Scaling` changes what the element says.
    pub(super) fn has_positions(self) -> bool {
        match self {
            Self::Camera | Self::Light(_) | Self::Object(_) | Self::Group | Self::Copy => true,
            Self::Scaling
            | Self::Settings
            | Self::PhongInfo
            | Self::Material(_)
            | Self::Texture => false,
        }
    }

    /// The kind of reference that leads to such an element, if there is one.
    pub(super) fn referred(self) -> Option<Referred> {
        match self {
            Self::PhongInfo => Some(Referred::PhongInfo),
            Self::Material(_) => Some(Referred::Material),
            Self::Texture => Some(Referred::Texture),
            Self::Light(_) | Self::Object(_) | Self::Group | Self::Copy => Some(Referred::Object),
            Self::Scaling | Self::Settings | Self::Camera => None,
        }
    }

    /// Whether such an element may hang in others, and others in it.
    pub(super) fn hangs(self) -> bool {
        self.referred() == Some(Referred::Object)
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

/// What all objects take beside their shapes.
const OBJECT: &[Attribute] = &[
    word("material", "NAME").required(),
    number("sampled"),
    word("light_group", "NAME"),
    number("lightMap"),
    number("lightMapInside"),
    HIDDEN,
    PARENT,
    block(&ADD_KFRAME).repeated(),
    REPEAT,
];

/// Whether something is left out of the picture.
const HIDDEN: Attribute = number("hidden");

/// `group`
const GROUP: Schema =
    Schema::new("group", &[HIDDEN, PARENT, REPEAT, block(&ADD_KFRAME).repeated()]);

/// What copies take beside what they are copies of.
const COPIED: &[Attribute] =
    &[word("material", "NAME"), HIDDEN, PARENT, REPEAT, block(&ADD_KFRAME).repeated()];

/// `copy`
const COPY: Schema = Schema::new("copy", &[word("of", "NAME").required()]).with(COPIED);

/// `copies`
const COPIES: Schema = Schema::new(
    "copies",
    &[word("of", "NAME").required().repeated(), word("placements", "PATH").required()],
)
.with(COPIED);

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
    elements.push(Known { schema: GROUP, role: Role::Group });
    elements.push(Known { schema: COPY, role: Role::Copy });
    elements.push(Known { schema: COPIES, role: Role::Copy });
    elements
});

/// The language of these elements.
pub(crate) static LANGUAGE: LazyLock<Language> =
    LazyLock::new(|| Language::new(ELEMENTS.iter().map(|known| &known.schema).collect()));

/// The kind of reference that leads to elements of a keyword, if there is one.
pub(crate) fn referred(keyword: &str) -> Option<Referred> {
    ELEMENTS.iter().find(|known| known.schema.keyword == keyword)?.role.referred()
}

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

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_element_has_a_keyword_of_its_own() {
        let keywords: HashSet<_> = LANGUAGE.keywords().collect();
        assert_eq!(keywords.len(), ELEMENTS.len());
    }

    #[test]
    fn blocks_follow_from_the_elements_that_take_them() {
        assert_eq!(LANGUAGE.owners("pivot"), ["pre", "key", "nex"]);
        assert_eq!(LANGUAGE.owners("width"), ["Film"]);
        let round = ["lamp_point", "lamp_spot", "lamp_disc", "sphere", "cylinder", "cone"];
        assert_eq!(LANGUAGE.owners("radius"), round);
    }

    #[test]
    fn what_moves_and_what_rays_pass_through() {
        let lamps = ["lamp_point", "lamp_spot", "lamp_sun", "lamp_rectangle", "lamp_disc"];
        let objects = ELEMENTS.iter().filter(|known| matches!(known.role, Role::Object(_)));
        let objects = objects.map(|known| known.schema.keyword);
        let moving: Vec<_> = ["light_point", "light_rectangle"]
            .into_iter()
            .chain(lamps)
            .chain(objects)
            .chain(["group", "copy", "copies"])
            .collect();
        assert_eq!(LANGUAGE.owners("addKframe"), moving);
        assert_eq!(LANGUAGE.owners("parent"), moving);
        let visible: Vec<_> = lamps.into_iter().chain(["environment"]).collect();
        assert_eq!(LANGUAGE.owners("camera_visible"), visible);
        let solid = ["lamp_point", "lamp_spot", "lamp_rectangle", "lamp_disc"];
        assert_eq!(LANGUAGE.owners("solid"), solid);
    }
}
