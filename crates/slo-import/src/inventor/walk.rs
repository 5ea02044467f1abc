//! The way through the nodes of a file, from left to right, with the state that they set.

use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::scene::{Scene, name_of};
use super::state::{State, Texture, matrix};
use super::tree::Node;
use super::view::Seen;
use super::{DEEPEST, nodes, nurbs, shapes, solids};
use crate::error::ImportError;
use crate::files::Source;
use crate::images::{Images, png};
use crate::model::Model;

/// Most nodes, each as often as it is reached.
const MOST_NODES: usize = 2_000_000;

/// Most triangles and corners of all shapes.
const MOST_CORNERS: usize = 200_000_000;

/// Most copies of an array.
const MOST_COPIES: f64 = 1e6;

/// Nodes that say nothing about a picture.
const SILENT: &[&str] = &[
    "Info",
    "Label",
    "Font",
    "FontStyle",
    "PickStyle",
    "Complexity",
    "TextureCoordinateFunction",
    "NurbsProfile",
    "ProfileCoordinate2",
    "ProfileCoordinate3",
    "LinearProfile",
    "VertexProperty",
    "EventCallback",
    "Callback",
];

/// Groups that restore the state.
const SEPARATORS: &[&str] =
    &["Separator", "Selection", "Annotation", "WWWAnchor", "LocateHighlight"];

/// The parts of node kits that say something about a picture, in the order in which they act.
const PARTS: &[&str] = &[
    "lightList",
    "cameraList",
    "lightModel",
    "environment",
    "drawStyle",
    "material",
    "texture2",
    "appearance",
    "units",
    "transform",
    "texture2Transform",
    "childList",
    "materialBinding",
    "normalBinding",
    "textureCoordinateBinding",
    "shapeHints",
    "coordinate3",
    "coordinate4",
    "normal",
    "textureCoordinate2",
    "localTransform",
    "shape",
    "contents",
    "light",
    "camera",
    "containerNode",
];

/// Kits whose parts act on what follows them.
const OPEN_KITS: &[&str] = &["AppearanceKit", "NodeKitListPart"];

pub(super) struct Walker {
    scene: Scene,
    seen: Seen,
    images: Images,
    visited: usize,
    depth: usize,
}

impl Walker {
    pub(super) fn new(model: Model) -> Self {
        let (scene, seen, images) = (Scene::new(model), Seen::default(), Images::default());
        Self { scene, seen, images, visited: 0, depth: 0 }
    }

    /// The model, with what is left to add.
    pub(super) fn finish(self) -> Model {
        let mut model = self.scene.model;
        self.seen.finish(&mut model);
        model
    }

    /// Visits nodes one after the other.
    pub(super) fn all(
        &mut self,
        nodes: &[Rc<Node>],
        state: &mut State,
        source: &Source,
    ) -> Result<(), ImportError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(source.bad(format!("nodes and files are nested more than {DEEPEST} deep")));
        }
        for node in nodes {
            self.visited += 1;
            if self.visited > MOST_NODES || self.scene.corners > MOST_CORNERS {
                let message =
                    format!("it has more than {MOST_NODES} nodes or {MOST_CORNERS} corners");
                return Err(source.bad(message));
            }
            self.visit(node, state, source)?;
        }
        self.depth -= 1;
        Ok(())
    }

    fn visit(
        &mut self,
        node: &Node,
        state: &mut State,
        source: &Source,
    ) -> Result<(), ImportError> {
        if let Some(name) = node.name.as_deref().and_then(name_of)
            && (!node.children.is_empty() || is_kit(&node.class))
        {
            state.name = Some(name);
        }
        let children = &node.children;
        match node.class.as_str() {
            class if SEPARATORS.contains(&class) => {
                return self.all(children, &mut state.clone(), source);
            }
            "Group" => return self.all(children, state, source),
            "TransformSeparator" => {
                let (matrix, unit) = (state.matrix, state.unit);
                self.all(children, state, source)?;
                (state.matrix, state.unit) = (matrix, unit);
            }
            "Switch" => {
                let choice = match node.number("whichChild", -1.0) as i64 {
                    -2 => state.choice,
                    choice => choice,
                };
                state.choice = choice;
                let chosen = match usize::try_from(choice) {
                    Ok(choice) => children.get(choice..=choice).unwrap_or_default(),
                    Err(_) if choice == -3 => children,
                    Err(_) => &[],
                };
                return self.all(chosen, state, source);
            }
            "LOD" | "LevelOfDetail" => {
                return self.all(children.get(..1).unwrap_or_default(), state, source);
            }
            "Array" => {
                for place in places(node) {
                    let mut inner = state.clone();
                    inner.matrix *= DMat4::from_translation(place);
                    self.all(children, &mut inner, source)?;
                }
            }
            "MultipleCopy" => {
                let identity = DMat4::IDENTITY.to_cols_array();
                for copy in node.numbers("matrix").unwrap_or(&identity).chunks_exact(16) {
                    let mut inner = state.clone();
                    inner.matrix *= matrix(Some(copy));
                    self.all(children, &mut inner, source)?;
                }
            }
            "File" | "WWWInline" => return self.file(node.word("name"), state, source),
            "Texture2" => state.texture = self.texture(node, source),
            _ if state.set(node) => {}
            _ if self.seen.add(node, state, &mut self.scene.model) => {}
            _ if shapes::add(&mut self.scene, node, state)
                || solids::add(&mut self.scene, node, state)
                || nurbs::add(&mut self.scene, node, state) => {}
            class if SILENT.contains(&class) => {}
            class if is_kit(class) => {
                let parts = PARTS.iter().filter_map(|part| node.node(part).cloned());
                let parts: Vec<Rc<Node>> = parts.collect();
                if OPEN_KITS.contains(&class) {
                    return self.all(&parts, state, source);
                }
                return self.all(&parts, &mut state.clone(), source);
            }
            class => {
                self.unknown(class, node, state);
                return self.all(children, state, source);
            }
        }
        Ok(())
    }

    /// What is known of a node of an unknown class: that engines turn things from a place on.
    fn unknown(&mut self, class: &str, node: &Node, state: &mut State) {
        let class: String = class.chars().take(40).collect();
        match class.as_str() {
            "Rotor" | "Pendulum" | "Shuttle" => {
                let place = node.vector("translation", DVec3::ZERO);
                state.matrix *= DMat4::from_rotation_translation(node.turn("rotation"), place);
                self.scene.model.notes.leave_out(format!("that a `{class}` moves"));
            }
            _ => self.scene.model.notes.leave_out(format!("the node `{class}`")),
        }
    }

    /// Reads another file in place.
    fn file(&mut self, name: &str, state: &mut State, source: &Source) -> Result<(), ImportError> {
        let Ok(file) = source.beside(name) else {
            let name: String = name.chars().take(60).collect();
            self.scene.model.notes.leave_out(format!("the file `{name}`, which can't be read"));
            return Ok(());
        };
        // Each file that is read costs at least its bytes.
        self.visited += file.bytes.len() / 1000;
        let nodes = nodes(&file, &mut self.scene.model.notes)?;
        let outer = state.name.replace(file.stem());
        self.all(&nodes, state, &file)?;
        state.name = outer;
        Ok(())
    }

    fn texture(&mut self, node: &Node, source: &Source) -> Option<Texture> {
        let (name, numbers) = (node.word("filename"), node.numbers("image").unwrap_or(&[]));
        let image = if !name.is_empty() {
            self.images.find(source, name, &["", "textures/"], &mut self.scene.model)?
        } else {
            let [width, height, components, pixels @ ..] = numbers else { return None };
            if *width < 1.0 || *height < 1.0 {
                return None;
            }
            let image = inline([*width, *height], *components, pixels);
            let Some(image) = image.and_then(|image| png("texture", &image)) else {
                self.scene.model.notes.leave_out("a damaged image");
                return None;
            };
            let images = &mut self.scene.model.images;
            let known = images.iter().position(|known| known.bytes == image.bytes);
            known.unwrap_or_else(|| {
                images.push(image);
                images.len() - 1
            })
        };
        let clamps = node.word("wrapS") == "CLAMP";
        if clamps != (node.word("wrapT") == "CLAMP") {
            self.scene.model.notes.leave_out("that an image repeats in one direction only");
        }
        if node.word("model") == "BLEND" {
            self.scene.model.notes.leave_out("that an image blends two colours");
        }
        Some(Texture { image, clamps, replaces: node.word("model") == "DECAL" })
    }
}

/// Whether a node's parts are fields that hold nodes. Programs have kits of their own.
fn is_kit(class: &str) -> bool {
    class.ends_with("Kit") || class == "NodeKitListPart"
}

/// Where the copies of an array are.
fn places(node: &Node) -> Vec<DVec3> {
    let axes = [("1", DVec3::X), ("2", DVec3::Y), ("3", DVec3::Z)].map(|(number, usual)| {
        let count = node.number(&format!("numElements{number}"), 1.0).clamp(0.0, MOST_COPIES);
        (count as usize, node.vector(&format!("separation{number}"), usual))
    });
    let share = match node.word("origin") {
        "CENTER" => 0.5,
        "LAST" => 1.0,
        _ => 0.0,
    };
    let [(n1, s1), (n2, s2), (n3, s3)] = axes;
    if n1 as f64 * n2 as f64 * n3 as f64 > MOST_COPIES {
        return Vec::new();
    }
    let whole: DVec3 = axes.map(|(n, s)| s * (n.max(1) - 1) as f64).into_iter().sum();
    let place = |i: usize, j: usize, k: usize| {
        s1 * i as f64 + s2 * j as f64 + s3 * k as f64 - whole * share
    };
    (0..n3)
        .flat_map(|k| (0..n2).flat_map(move |j| (0..n1).map(move |i| (i, j, k))))
        .map(|(i, j, k)| place(i, j, k))
        .collect()
}

/// An image whose pixels are numbers; rows run upward.
fn inline(size: [f64; 2], components: f64, pixels: &[f64]) -> Option<image::DynamicImage> {
    let [width, height] = size.map(|side| side as u32);
    if pixels.len() != width as usize * height as usize {
        return None;
    }
    let bytes = |pixel: f64| {
        let pixel = pixel as u32;
        match components as u32 {
            1 => [pixel as u8, pixel as u8, pixel as u8, 255],
            2 => [(pixel >> 8) as u8, (pixel >> 8) as u8, (pixel >> 8) as u8, pixel as u8],
            3 => [(pixel >> 16) as u8, (pixel >> 8) as u8, pixel as u8, 255],
            _ => pixel.to_be_bytes(),
        }
    };
    let rows = pixels.chunks_exact(width as usize).rev().flatten();
    let image = image::RgbaImage::from_raw(width, height, rows.flat_map(|p| bytes(*p)).collect())?;
    let is_opaque = image.pixels().all(|pixel| pixel[3] == 255);
    let image = image::DynamicImage::from(image);
    Some(if is_opaque { image.to_rgb8().into() } else { image })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_begin_where_they_say() {
        let numbers = |name: &str, numbers: &[f64]| {
            (name.to_owned(), super::super::tree::Value::Numbers(numbers.to_vec()))
        };
        let mut fields = vec![numbers("numElements1", &[3.0]), numbers("numElements2", &[2.0])];
        fields.push(numbers("separation1", &[2.0, 0.0, 0.0]));
        let words = |word: &str| {
            ("origin".to_owned(), super::super::tree::Value::Words(vec![word.to_owned()]))
        };
        let mut node = Node { fields, ..Node::default() };
        assert_eq!(
            places(&node)[..4].iter().map(|p| p.x).collect::<Vec<_>>(),
            [0.0, 2.0, 4.0, 0.0]
        );
        node.fields.push(words("CENTER"));
        assert_eq!(places(&node)[0], DVec3::new(-2.0, -0.5, 0.0));
        node.fields.pop();
        node.fields.push(words("LAST"));
        assert_eq!(places(&node)[5], DVec3::ZERO);
    }
}
