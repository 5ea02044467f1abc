//! What holds for the shapes that follow.

use std::rc::Rc;

use glam::{DAffine2, DMat4, DVec2, DVec3};

use super::tree::{Node, turn};

/// Which of several values belongs to what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Binding {
    Overall,
    Part,
    PartIndexed,
    Face,
    FaceIndexed,
    Vertex,
    #[default]
    VertexIndexed,
}

impl Binding {
    /// The binding of this name; `usual` if there is none.
    pub(super) fn of(word: &str, usual: Self) -> Self {
        match word {
            "OVERALL" | "NONE" => Self::Overall,
            "PER_PART" => Self::Part,
            "PER_PART_INDEXED" => Self::PartIndexed,
            "PER_FACE" => Self::Face,
            "PER_FACE_INDEXED" => Self::FaceIndexed,
            "PER_VERTEX" => Self::Vertex,
            "PER_VERTEX_INDEXED" => Self::VertexIndexed,
            _ => usual,
        }
    }
}

/// Materials: lists, of which the last entry goes on.
#[derive(Clone, Debug)]
pub(super) struct Materials {
    pub(super) ambient: Rc<Vec<DVec3>>,
    pub(super) diffuse: Rc<Vec<DVec3>>,
    pub(super) specular: Rc<Vec<DVec3>>,
    pub(super) emissive: Rc<Vec<DVec3>>,
    pub(super) shininess: Rc<Vec<f64>>,
    pub(super) transparency: Rc<Vec<f64>>,
}

/// How texture coordinates come about.
#[derive(Clone, Debug, Default)]
pub(super) enum Coordinates {
    /// From the box of a shape.
    #[default]
    Usual,
    Listed(Rc<Vec<[f64; 2]>>),
    /// By these two directions.
    Plane([DVec3; 2]),
}

/// An image on shapes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Texture {
    pub(super) image: usize,
    pub(super) clamps: bool,
    /// Whether it replaces the colour of the surface.
    pub(super) replaces: bool,
}

/// Everything that holds for the shapes that follow.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) matrix: DMat4,
    pub(super) points: Rc<Vec<DVec3>>,
    /// Weights of control points, if there are any.
    pub(super) weights: Rc<Vec<f64>>,
    pub(super) normals: Rc<Vec<DVec3>>,
    pub(super) coordinates: Coordinates,
    pub(super) materials: Materials,
    pub(super) material_binding: Binding,
    pub(super) normal_binding: Binding,
    pub(super) coordinate_binding: Binding,
    pub(super) is_clockwise: bool,
    pub(super) crease: f64,
    pub(super) texture: Option<Texture>,
    pub(super) texture_place: DAffine2,
    pub(super) is_unlit: bool,
    pub(super) is_hidden: bool,
    /// Whether only lines or points are drawn.
    pub(super) is_outlined: bool,
    /// The light that is everywhere.
    pub(super) everywhere: DVec3,
    /// Metres of a unit.
    pub(super) unit: f64,
    /// The child that the last switch chose.
    pub(super) choice: i64,
    pub(super) name: Option<String>,
}

impl Default for Materials {
    fn default() -> Self {
        Self {
            ambient: Rc::new(vec![DVec3::splat(0.2)]),
            diffuse: Rc::new(vec![DVec3::splat(0.8)]),
            specular: Rc::new(vec![DVec3::ZERO]),
            emissive: Rc::new(vec![DVec3::ZERO]),
            shininess: Rc::new(vec![0.2]),
            transparency: Rc::new(vec![0.0]),
        }
    }
}

impl Default for State {
    fn default() -> Self {
        Self {
            matrix: DMat4::IDENTITY,
            points: Rc::new(vec![DVec3::ZERO]),
            weights: Rc::default(),
            normals: Rc::default(),
            coordinates: Coordinates::Usual,
            materials: Materials::default(),
            material_binding: Binding::Overall,
            normal_binding: Binding::VertexIndexed,
            coordinate_binding: Binding::VertexIndexed,
            is_clockwise: false,
            crease: 0.0,
            texture: None,
            texture_place: DAffine2::IDENTITY,
            is_unlit: false,
            is_hidden: false,
            is_outlined: false,
            everywhere: DVec3::splat(0.2),
            unit: 1.0,
            choice: -1,
            name: None,
        }
    }
}

impl State {
    /// Sets what a property node says. Returns whether it is one that needs nothing but the state.
    pub(super) fn set(&mut self, node: &Node) -> bool {
        match node.class.as_str() {
            "Coordinate3" => {
                self.points = Rc::new(node.vectors("point").unwrap_or_default());
                self.weights = Rc::default();
            }
            "Coordinate4" => {
                let points = node.numbers("point").unwrap_or(&[0.0, 0.0, 0.0, 1.0]).chunks_exact(4);
                let weight = |p: &[f64]| if p[3] == 0.0 { 1.0 } else { p[3] };
                let point = |p: &[f64]| DVec3::from_slice(p) / weight(p);
                self.points = Rc::new(points.clone().map(point).collect());
                self.weights = Rc::new(points.map(weight).collect());
            }
            "Normal" => self.normals = Rc::new(node.vectors("vector").unwrap_or_default()),
            "NormalBinding" => {
                self.normal_binding = Binding::of(node.word("value"), Binding::VertexIndexed);
            }
            "MaterialBinding" => {
                self.material_binding = Binding::of(node.word("value"), Binding::Overall);
            }
            "TextureCoordinateBinding" => {
                self.coordinate_binding = Binding::of(node.word("value"), Binding::VertexIndexed);
            }
            "TextureCoordinate2" => {
                self.coordinates = Coordinates::Listed(Rc::new(node.pairs("point")));
            }
            "TextureCoordinatePlane" => {
                let axes = [("directionS", DVec3::X), ("directionT", DVec3::Y)];
                self.coordinates =
                    Coordinates::Plane(axes.map(|(name, usual)| node.vector(name, usual)));
            }
            "TextureCoordinateDefault" => self.coordinates = Coordinates::Usual,
            "Texture2Transform" => self.texture_place *= texture_place(node),
            "Material" => self.material(node),
            "BaseColor" => {
                if let Some(colors) = node.vectors("rgb").filter(|colors| !colors.is_empty()) {
                    self.materials.diffuse = Rc::new(colors);
                }
            }
            "PackedColor" => {
                let usual = [f64::from(0xcccc_ccff_u32)];
                self.materials.pack(node.numbers("orderedRGBA").unwrap_or(&usual));
            }
            "LightModel" => self.is_unlit = node.word("model") == "BASE_COLOR",
            "ShapeHints" => {
                self.is_clockwise = node.word("vertexOrdering") == "CLOCKWISE";
                self.crease = node.number("creaseAngle", 0.0);
            }
            "DrawStyle" => {
                self.is_hidden = node.word("style") == "INVISIBLE";
                self.is_outlined = matches!(node.word("style"), "LINES" | "POINTS");
            }
            "Environment" => {
                let color = node.vector("ambientColor", DVec3::ONE);
                self.everywhere = color * node.number("ambientIntensity", 0.2);
            }
            _ => return self.transform(node),
        }
        true
    }

    /// Multiplies the transform by what a node says. Returns whether it is a transform.
    fn transform(&mut self, node: &Node) -> bool {
        let matrix = match node.class.as_str() {
            "Transform" => {
                let center = node.vector("center", DVec3::ZERO);
                let sized = DMat4::from_quat(node.turn("scaleOrientation"));
                let scale = DMat4::from_scale(node.vector("scaleFactor", DVec3::ONE));
                DMat4::from_translation(node.vector("translation", DVec3::ZERO) + center)
                    * DMat4::from_quat(node.turn("rotation"))
                    * sized
                    * scale
                    * sized.transpose()
                    * DMat4::from_translation(-center)
            }
            "Translation" => DMat4::from_translation(node.vector("translation", DVec3::ZERO)),
            "Rotation" => DMat4::from_quat(node.turn("rotation")),
            "Scale" => DMat4::from_scale(node.vector("scaleFactor", DVec3::ONE)),
            "RotationXYZ" => {
                let axis = match node.word("axis") {
                    "Y" => DVec3::Y,
                    "Z" => DVec3::Z,
                    _ => DVec3::X,
                };
                DMat4::from_quat(turn(axis, node.number("angle", 0.0)))
            }
            "MatrixTransform" => matrix(node.numbers("matrix")),
            "ResetTransform" => {
                if node.word("whatToReset") != "BBOX" {
                    self.matrix = DMat4::IDENTITY;
                }
                return true;
            }
            "Units" => {
                let unit = unit(node.word("units"));
                let factor = unit / self.unit;
                self.unit = unit;
                DMat4::from_scale(DVec3::splat(factor))
            }
            _ => return false,
        };
        self.matrix *= matrix;
        true
    }

    fn material(&mut self, node: &Node) {
        let Materials { ambient, diffuse, specular, emissive, .. } = Materials::default();
        let colors = |name, usual| match node.vectors(name).filter(|colors| !colors.is_empty()) {
            Some(colors) => Rc::new(colors),
            None => usual,
        };
        let numbers = |name, usual| match node.numbers(name).filter(|numbers| !numbers.is_empty()) {
            Some(numbers) => Rc::new(numbers.to_vec()),
            None => Rc::new(vec![usual]),
        };
        self.materials = Materials {
            ambient: colors("ambientColor", ambient),
            diffuse: colors("diffuseColor", diffuse),
            specular: colors("specularColor", specular),
            emissive: colors("emissiveColor", emissive),
            shininess: numbers("shininess", 0.2),
            transparency: numbers("transparency", 0.0),
        };
    }
}

impl Materials {
    /// Colours and opacities as numbers `0xRRGGBBAA`.
    pub(super) fn pack(&mut self, colors: &[f64]) {
        let byte = |color: &f64, shift: u32| f64::from((*color as u32 >> shift) & 0xff) / 255.0;
        let rgb = |color: &f64| DVec3::new(byte(color, 24), byte(color, 16), byte(color, 8));
        self.diffuse = Rc::new(colors.iter().map(rgb).collect());
        self.transparency = Rc::new(colors.iter().map(|color| 1.0 - byte(color, 0)).collect());
    }
}

/// A matrix for row vectors, row by row, which is a matrix for columns, column by column.
pub(super) fn matrix(numbers: Option<&[f64]>) -> DMat4 {
    match numbers.and_then(|numbers| numbers.first_chunk::<16>()) {
        Some(numbers) => DMat4::from_cols_array(numbers),
        None => DMat4::IDENTITY,
    }
}

fn texture_place(node: &Node) -> DAffine2 {
    let pair = |name, usual: f64| {
        node.pairs(name).first().map_or(DVec2::splat(usual), |pair| DVec2::from(*pair))
    };
    let (center, angle) = (pair("center", 0.0), node.number("rotation", 0.0));
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let turn = DAffine2::from_cols(DVec2::new(cos, sin), DVec2::new(-sin, cos), DVec2::ZERO);
    DAffine2::from_translation(pair("translation", 0.0) + center)
        * turn
        * DAffine2::from_scale(pair("scaleFactor", 1.0))
        * DAffine2::from_translation(-center)
}

fn unit(word: &str) -> f64 {
    match word {
        "CENTIMETERS" => 0.01,
        "MILLIMETERS" => 0.001,
        "MICROMETERS" | "MICRONS" => 1e-6,
        "NANOMETERS" => 1e-9,
        "ANGSTROMS" => 1e-10,
        "KILOMETERS" => 1000.0,
        "FEET" => 0.3048,
        "INCHES" => 0.0254,
        "POINTS" => 0.0254 / 72.0,
        "YARDS" => 0.9144,
        "MILES" => 1609.344,
        "NAUTICAL_MILES" => 1852.0,
        _ => 1.0,
    }
}
