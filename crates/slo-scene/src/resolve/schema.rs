//! The elements of the language and the attributes that each takes.

use crate::format::syntax::{Follows, Grammar};
use crate::settings::{Entries, Entry, Film, Form, Settings};

/// An element or inner block: its keyword and what may stand in it.
#[derive(Debug)]
pub(super) struct Schema {
    pub(super) keyword: &'static str,
    pub(super) attributes: &'static [Attribute],
}

/// What may stand in an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attribute {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) required: bool,
    pub(super) repeated: bool,
}

/// What an attribute takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A number.
    Number,
    /// One of several words.
    Choice,
    /// A word of the user's own: a name, a path; with how to call it.
    Word(&'static str),
    /// Three numbers in braces; with how to call them.
    Vector(&'static str),
    /// Attributes in braces.
    Block,
    /// A name, and attributes in braces.
    Element,
}

impl Attribute {
    const fn new(name: &'static str, kind: Kind) -> Self {
        Self { name, kind, required: false, repeated: false }
    }

    const fn required(self) -> Self {
        Self { required: true, ..self }
    }

    const fn repeated(self) -> Self {
        Self { repeated: true, ..self }
    }

    /// How to write it.
    pub(super) fn usage(&self) -> String {
        let name = self.name;
        match self.kind {
            Kind::Number => format!("`{name} NUMBER`"),
            Kind::Choice => format!("`{name} WORD`"),
            Kind::Word(what) => format!("`{name} {what}`"),
            Kind::Vector(what) => format!("`{name} {{ {what} }}`"),
            Kind::Block => format!("`{name} {{ ... }}`"),
            Kind::Element => format!("`{name} NAME {{ ... }}`"),
        }
    }
}

impl Schema {
    pub(super) fn attribute(&self, name: &str) -> Option<&'static Attribute> {
        self.attributes.iter().find(|a| a.name == name)
    }
}

const fn number(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Number)
}

const fn point(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Vector("x y z"))
}

const fn color(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Vector("r g b"))
}

const fn word(name: &'static str, what: &'static str) -> Attribute {
    Attribute::new(name, Kind::Word(what))
}

const fn block(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Block)
}

const fn inner(name: &'static str) -> Attribute {
    Attribute::new(name, Kind::Element)
}

/// The attributes of an element that is a list of settings.
const fn attributes<S, const N: usize>(entries: &[Entry<S>]) -> [Attribute; N] {
    let mut attributes = [Attribute::new("", Kind::Number); N];
    let mut i = 0;
    while i < N {
        let entry = &entries[i];
        let kind = match entry.form {
            Form::Flag | Form::Count(..) | Form::Whole | Form::Single(_) | Form::Double(_) => {
                Kind::Number
            }
            Form::Color => Kind::Vector("r g b"),
            Form::Word(_) => Kind::Choice,
            Form::Text(what) => Kind::Word(what),
        };
        attributes[i] =
            Attribute { required: entry.is_required, ..Attribute::new(entry.name, kind) };
        i += 1;
    }
    attributes
}

const MATERIAL: Attribute = word("material", "NAME").required();
const KEY_FRAME: Attribute = block("addKframe").repeated();
const VERTEX_0: Attribute = point("vertex0").required();
const VERTEX_1: Attribute = point("vertex1").required();
const VERTEX_2: Attribute = point("vertex2").required();
const COLOR: Attribute = color("color").required();
const BASE: Attribute = point("base").required();
const RADIUS: Attribute = number("radius").required();

pub(super) const SCALING: Schema = Schema { keyword: "Scaling", attributes: &[] };

const SETTINGS_ROWS: [Attribute; Settings::ENTRIES.len()] = attributes(Settings::ENTRIES);
pub(super) const SETTINGS: Schema = Schema { keyword: "settings", attributes: &SETTINGS_ROWS };

pub(super) const CAMERA: Schema = Schema {
    keyword: "Camera",
    attributes: &[
        number("fps").required(),
        inner("Film").required(),
        inner("CamSegment").required().repeated(),
    ],
};

const FILM_ROWS: [Attribute; Film::ENTRIES.len()] = attributes(Film::ENTRIES);
pub(super) const FILM: Schema = Schema { keyword: "Film", attributes: &FILM_ROWS };

pub(super) const CAM_SEGMENT: Schema = Schema {
    keyword: "CamSegment",
    attributes: &[
        number("videoStart").required(),
        number("videoEnd").required(),
        number("sceneStart"),
        number("sceneEnd"),
        point("addPosition").required().repeated(),
        point("addTarget").required().repeated(),
        point("skyStart"),
        point("skyEnd"),
        number("fovStart").required(),
        number("fovEnd"),
        number("dofStart"),
        number("dofEnd"),
        number("lensRadiusStart"),
        number("lensRadiusEnd"),
        number("blurDuration"),
    ],
};

pub(super) const LIGHT_POINT: Schema =
    Schema { keyword: "light_point", attributes: &[COLOR, point("position").required()] };

pub(super) const LIGHT_RECTANGLE: Schema =
    Schema { keyword: "light_rectangle", attributes: &[COLOR, VERTEX_0, VERTEX_1, VERTEX_2] };

pub(super) const PHONG_INFO: Schema = Schema {
    keyword: "phong_info",
    attributes: &[
        color("ambient"),
        color("diffuse"),
        color("specular"),
        number("shininess"),
        number("reflectance"),
        number("diffuse_reflection"),
        number("refraction"),
        number("diffuse_refraction"),
        number("refraction_index"),
    ],
};

pub(super) const MATERIAL_PHONG: Schema =
    Schema { keyword: "material_phong", attributes: &[word("phong_info", "NAME").required()] };

pub(super) const TEXTURE: Schema =
    Schema { keyword: "texture", attributes: &[word("filename", "PATH").required()] };

pub(super) const MATERIAL_TEXTURE: Schema = Schema {
    keyword: "material_texture",
    attributes: &[
        word("phong_info", "NAME").required(),
        word("texture", "NAME").required(),
        number("scale_U"),
        number("scale_V"),
    ],
};

pub(super) const PLANE: Schema = Schema {
    keyword: "plane",
    attributes: &[point("normal").required(), point("position").required(), MATERIAL, KEY_FRAME],
};

pub(super) const SPHERE: Schema = Schema {
    keyword: "sphere",
    attributes: &[point("center").required(), RADIUS, MATERIAL, KEY_FRAME],
};

pub(super) const TRIANGLE: Schema = Schema {
    keyword: "triangle",
    attributes: &[VERTEX_0, VERTEX_1, VERTEX_2, MATERIAL, KEY_FRAME],
};

pub(super) const RECTANGLE: Schema = Schema {
    keyword: "rectangle",
    attributes: &[VERTEX_0, VERTEX_1, VERTEX_2, MATERIAL, KEY_FRAME],
};

pub(super) const BOX: Schema = Schema {
    keyword: "box",
    attributes: &[VERTEX_0, VERTEX_1, VERTEX_2, number("height").required(), MATERIAL, KEY_FRAME],
};

pub(super) const CYLINDER: Schema = Schema {
    keyword: "cylinder",
    attributes: &[BASE, point("top").required(), RADIUS, MATERIAL, KEY_FRAME],
};

pub(super) const CONE: Schema = Schema {
    keyword: "cone",
    attributes: &[BASE, point("apex").required(), RADIUS, MATERIAL, KEY_FRAME],
};

pub(super) const MESH: Schema = Schema {
    keyword: "mesh",
    attributes: &[
        word("filename", "PATH").required().repeated(),
        number("smooth_normals"),
        MATERIAL,
        KEY_FRAME,
    ],
};

pub(super) const ADD_KFRAME: Schema = Schema {
    keyword: "addKframe",
    attributes: &[number("time").required(), block("pre"), block("key"), block("nex")],
};

const PLACEMENT: [Attribute; 3] = [point("pivot"), point("up"), point("right")];
pub(super) const PRE: Schema = Schema { keyword: "pre", attributes: &PLACEMENT };
pub(super) const KEY: Schema = Schema { keyword: "key", attributes: &PLACEMENT };
pub(super) const NEX: Schema = Schema { keyword: "nex", attributes: &PLACEMENT };

/// What may stand at the top of a scene.
pub(super) static ELEMENTS: [&Schema; 17] = [
    &SCALING,
    &SETTINGS,
    &CAMERA,
    &LIGHT_POINT,
    &LIGHT_RECTANGLE,
    &PHONG_INFO,
    &MATERIAL_PHONG,
    &TEXTURE,
    &MATERIAL_TEXTURE,
    &PLANE,
    &SPHERE,
    &TRIANGLE,
    &RECTANGLE,
    &BOX,
    &CYLINDER,
    &CONE,
    &MESH,
];

/// What stands only in other elements.
static INNER: [&Schema; 6] = [&FILM, &CAM_SEGMENT, &ADD_KFRAME, &PRE, &KEY, &NEX];

/// The language, as far as the parser asks.
pub(super) struct SceneGrammar;

impl Grammar for SceneGrammar {
    fn follows(&self, owner: Option<&str>, word: &str) -> Option<Follows> {
        let Some(owner) = owner else {
            return ELEMENTS.iter().any(|s| s.keyword == word).then_some(Follows::Element);
        };
        let schema = ELEMENTS.iter().chain(&INNER).find(|s| s.keyword == owner)?;
        Some(match schema.attribute(word)?.kind {
            Kind::Element => Follows::Element,
            Kind::Block => Follows::Block,
            Kind::Vector(_) => Follows::Vector,
            Kind::Word(_) => Follows::Name,
            Kind::Number | Kind::Choice => Follows::Value,
        })
    }
}

/// Elements that take an attribute of that name.
pub(super) fn owners(name: &str) -> Vec<&'static str> {
    let schemas = ELEMENTS.iter().chain(&INNER);
    schemas.filter(|s| s.attribute(name).is_some()).map(|s| s.keyword).collect()
}
