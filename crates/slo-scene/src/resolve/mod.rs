//! Syntax tree -> scene: every element in its room, references followed.

mod assets;
mod camera;
mod collect;
mod fields;
mod key_frames;
mod lights;
mod materials;
mod oddities;
mod overlaps;
mod schema;
mod settings;
mod shapes;
mod values;

use std::sync::Arc;

use self::assets::Assets;
use self::collect::Scene;
use self::fields::{Element, Fields, Value, quoted_list};
use self::schema::{ELEMENTS, SceneGrammar};
use super::files::{ContentHash, Files};
use super::names::{Names, invisible};
use super::{
    Camera, Light, Material, MaterialId, Object, SceneDescription, Settings, Shape, Texture,
    TextureId, TextureUse,
};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Span};
use crate::format::syntax::Word;
use crate::format::{parse, written};

/// The scene of a text that is a source of `diagnostics`; a scene without meaning where there are
/// errors.
pub(super) fn resolve(
    text: &str,
    source: SourceId,
    files: &Files,
    hash: ContentHash,
    diagnostics: &mut Diagnostics,
) -> Option<SceneDescription> {
    let tree = parse(text, source, &SceneGrammar, diagnostics);
    let name = diagnostics.source(source).name.clone();
    let scene = Scene::collect(&tree, diagnostics);
    let scale = scaling(&scene, diagnostics);
    let names = scene.names(diagnostics);
    let assets = Assets::new(files, &name, hash);
    let dangling = Vec::new();
    let mut resolver = Resolver { scene, scale, names, assets, dangling, diagnostics };
    let description = resolver.description();
    resolver.report_dangling();
    if !resolver.diagnostics.has_errors() {
        resolver.warn_unused();
    }
    description
}

/// `Scaling`, which stands before everything that it scales.
fn scaling(scene: &Scene<'_, '_>, diagnostics: &mut Diagnostics) -> f64 {
    let Some(element) = scene.only("Scaling", diagnostics) else { return 1.0 };
    if let Some(first) = scene.first_with_positions()
        && first.keyword.span < element.keyword.span
    {
        diagnostics.push(
            Diagnostic::error("`Scaling` stands after an element with positions")
                .at(element.head(), "")
                .also(first.head(), "this would not be scaled")
                .help("write it at the top of the scene"),
        );
    }
    let mut fields = Fields::bare(element, diagnostics);
    let Some([factor]) = fields.numbers(element.keyword, element.block) else { return 1.0 };
    if factor > 0.0 {
        return factor;
    }
    let span = element.block.open.to(element.block.close);
    diagnostics.push(Diagnostic::error("`Scaling` must be more than 0").at(span, ""));
    1.0
}

/// What can be referred to.
struct AllNames<'a> {
    phong_infos: Names<'a>,
    materials: Names<'a>,
    textures: Names<'a>,
    /// Names of elements of unknown types: they may be what a reference means.
    unknown: Names<'a>,
}

impl<'a> AllNames<'a> {
    /// The names of a kind, and those of the other kinds.
    fn of(&mut self, referred: Referred) -> (&mut Names<'a>, [&Names<'a>; 2]) {
        let Self { phong_infos, materials, textures, .. } = self;
        match referred {
            Referred::PhongInfo => (phong_infos, [materials, textures]),
            Referred::Material => (materials, [phong_infos, textures]),
            Referred::Texture => (textures, [phong_infos, materials]),
        }
    }
}

/// Dangling names that are told apart and explained; beyond, each place counts by itself.
const MOST_DANGLING: usize = 100;

struct Resolver<'t, 'a, 'd> {
    scene: Scene<'t, 'a>,
    scale: f64,
    names: AllNames<'a>,
    assets: Assets<'d>,
    dangling: Vec<Dangling<'a>>,
    diagnostics: &'d mut Diagnostics,
}

/// A name that nothing has, and everything that refers to it.
struct Dangling<'a> {
    referred: Referred,
    words: Vec<Word<'a>>,
}

/// The kinds of elements that are referred to.
#[derive(Clone, Copy, PartialEq)]
enum Referred {
    PhongInfo,
    Material,
    Texture,
}

impl<'t, 'a> Resolver<'t, 'a, '_> {
    fn description(&mut self) -> Option<SceneDescription> {
        let settings = self.settings();
        let camera = self.camera();
        let lights = self.lights();
        let phong_infos = self.phong_infos();
        let textures = self.textures();
        let materials = self.materials(&phong_infos);
        let objects = self.objects(camera.as_ref(), &materials);
        let scene = SceneDescription {
            settings,
            camera: camera?,
            lights: lights.iter().map(|(light, _)| light.clone()).collect(),
            materials,
            textures: textures.into_iter().collect::<Option<_>>()?,
            objects: objects.iter().map(|(object, _)| object.clone()).collect(),
            content_hash: self.assets.hash.finish(),
        };
        if self.dangling.is_empty() && !self.diagnostics.has_errors() {
            oddities::check_light(&scene, self.diagnostics);
            overlaps::check(&objects, &lights, &scene.camera, self.diagnostics);
        }
        Some(scene)
    }

    fn fields(&mut self, element: Element<'t, 'a>) -> Fields<'t, 'a, '_> {
        Fields::read(element, self.scale, self.diagnostics)
    }

    fn settings(&mut self) -> Settings {
        match self.scene.only("settings", self.diagnostics) {
            Some(element) => settings::settings(&mut self.fields(element)),
            None => Settings::default(),
        }
    }

    fn camera(&mut self) -> Option<Camera> {
        let Some(element) = self.scene.only("Camera", self.diagnostics) else {
            // Where nothing is an element, what is there has been reported.
            let is_known = self.scene.is_empty() && self.diagnostics.has_errors();
            if !self.scene.is_truncated && !is_known {
                let what = if self.scene.is_empty() { "is empty" } else { "has no `Camera`" };
                self.diagnostics.push(
                    Diagnostic::error(format!("the scene {what}"))
                        .help("write `Camera NAME { fps NUMBER  Film NAME { ... }  CamSegment NAME { ... } }`"),
                );
            }
            return None;
        };
        camera::camera(&mut self.fields(element))
    }

    /// Lights, with the places that they are defined at.
    fn lights(&mut self) -> Vec<(Light, Span)> {
        let elements = self.scene.of(&["light_point", "light_rectangle"]);
        let mut lights = Vec::new();
        for element in elements {
            let mut fields = self.fields(element);
            let light = match element.schema.keyword {
                "light_point" => lights::point(&mut fields),
                _ => lights::rectangle(&mut fields),
            };
            lights.extend(light.map(|light| (light, element.head())));
        }
        lights
    }

    fn phong_infos(&mut self) -> Vec<Material> {
        let elements = self.scene.of(&["phong_info"]);
        elements.into_iter().map(|e| materials::phong_info(&mut self.fields(e))).collect()
    }

    fn textures(&mut self) -> Vec<Option<Arc<Texture>>> {
        let mut textures = Vec::new();
        for element in self.scene.of(&["texture"]) {
            let path = self.fields(element).word("filename");
            textures.push(path.and_then(|path| self.assets.texture(path, self.diagnostics)));
        }
        textures
    }

    fn materials(&mut self, phong_infos: &[Material]) -> Vec<Material> {
        let elements = self.scene.of(&["material_phong", "material_texture"]);
        elements.into_iter().filter_map(|e| self.material(e, phong_infos)).collect()
    }

    fn material(&mut self, element: Element<'t, 'a>, phong_infos: &[Material]) -> Option<Material> {
        let mut fields = self.fields(element);
        let (phong, texture) = (fields.word("phong_info"), fields.word("texture"));
        let scale = materials::texture_scale(&mut fields);
        let phong = phong.and_then(|word| self.refer(Referred::PhongInfo, word));
        let texture = texture.and_then(|word| self.refer(Referred::Texture, word));
        Some(Material {
            name: element.name.text.to_owned(),
            texture: texture.map(|id| TextureUse { texture: TextureId(id as u32), scale }),
            ..phong_infos.get(phong?)?.clone()
        })
    }

    /// Objects, with the places that they are defined at.
    fn objects(&mut self, camera: Option<&Camera>, materials: &[Material]) -> Vec<(Object, Span)> {
        let elements = self.scene.objects();
        let object = |e: Element<'t, 'a>| Some((self.object(e, camera, materials)?, e.head()));
        elements.into_iter().filter_map(object).collect()
    }

    fn object(
        &mut self,
        element: Element<'t, 'a>,
        camera: Option<&Camera>,
        materials: &[Material],
    ) -> Option<Object> {
        let mut fields = Fields::read(element, self.scale, self.diagnostics);
        let material = fields.word("material");
        let key_frames = key_frames::key_frames(&mut fields);
        if let Some(camera) = camera {
            oddities::check_key_times(&mut fields, &key_frames, camera);
        }
        let shape = match element.schema.keyword {
            "plane" => shapes::plane(&mut fields),
            "sphere" => shapes::sphere(&mut fields),
            "triangle" => shapes::triangle(&mut fields),
            "rectangle" => shapes::rectangle(&mut fields),
            "box" => shapes::cuboid(&mut fields),
            "cylinder" => shapes::cylinder(&mut fields),
            "cone" => shapes::cone(&mut fields),
            _ => mesh(&mut fields, &mut self.assets),
        };
        let files = filenames(&fields).unwrap_or_default();
        let material = material.and_then(|word| self.refer(Referred::Material, word));
        if material.and_then(|index| materials.get(index)).is_some_and(|m| m.texture.is_some()) {
            self.assets.warn_without_uvs(&files, self.diagnostics);
        }
        Some(Object {
            name: element.name.text.to_owned(),
            material: MaterialId(material? as u32),
            shape: shape?,
            key_frames,
        })
    }

    /// Index of what a word refers to; notes a name that there is not.
    fn refer(&mut self, referred: Referred, word: Word<'a>) -> Option<usize> {
        let (names, _) = self.names.of(referred);
        let found = names.find(word.text);
        if found.is_none() && !self.names.unknown.contains(word.text) && !self.scene.is_truncated {
            self.note_dangling(referred, word);
        }
        found
    }

    fn note_dangling(&mut self, referred: Referred, word: Word<'a>) {
        let same = |d: &&mut Dangling<'_>| d.referred == referred && d.words[0].text == word.text;
        match self.dangling.iter_mut().take(MOST_DANGLING).find(same) {
            Some(dangling) => dangling.words.push(word),
            None => self.dangling.push(Dangling { referred, words: vec![word] }),
        }
    }

    fn report_dangling(&mut self) {
        for (i, Dangling { referred, words }) in self.dangling.iter().enumerate() {
            let (names, others) = self.names.of(*referred);
            let mut diagnostic = dangling(words[0], names, others, i < MOST_DANGLING);
            for word in words[1..].iter().take(2) {
                diagnostic = diagnostic.also(word.span, "and here");
            }
            if words.len() > 3
                && let Some(last) = diagnostic.secondary.last_mut()
            {
                last.text = format!("and here, and in {} more places", words.len() - 3);
            }
            self.diagnostics.push(diagnostic);
        }
    }

    fn warn_unused(&mut self) {
        let AllNames { phong_infos, materials, textures, .. } = &self.names;
        for names in [phong_infos, materials, textures] {
            names.warn_unused(self.diagnostics);
        }
        if self.scene.objects().is_empty() {
            self.diagnostics.push(Diagnostic::warning("the scene has no objects"));
        }
    }
}

fn mesh(fields: &mut Fields<'_, '_, '_>, assets: &mut Assets<'_>) -> Option<Shape> {
    let smooth = fields.count("smooth_normals", 0, 1);
    let paths = filenames(fields)?;
    let smooth = smooth.is_some_and(|s| s.value == 1);
    let mesh = assets.mesh(&paths, smooth, fields.scale, fields.diagnostics)?;
    Some(Shape::Mesh { mesh, smooth })
}

/// The files of a mesh.
fn filenames<'a>(fields: &Fields<'_, 'a, '_>) -> Option<Vec<Word<'a>>> {
    let paths = fields.all("filename").into_iter().map(|field| match field.value {
        Value::Word(word) => Some(word),
        _ => None,
    });
    paths.collect()
}

/// The error about a name that nothing has; with what was meant, if it is to be looked for.
fn dangling(
    word: Word<'_>,
    names: &Names<'_>,
    others: [&Names<'_>; 2],
    is_explained: bool,
) -> Diagnostic {
    let kind = names.kind();
    let message = format!("no {kind} is called `{}`", word.text);
    if !is_explained {
        return Diagnostic::error(message).at(word.span, "");
    }
    if let Some(other) = others.iter().find(|o| o.contains(word.text)) {
        let label = format!("this is the name of a {}", other.kind());
        return Diagnostic::error(message).at(word.span, label);
    }
    if let Some(near) = names.closest(word.text) {
        let error = Diagnostic::error(format!("{message}, did you mean `{}`?", written(near)));
        return Diagnostic { help: invisible(word.text), ..error.at(word.span, "") };
    }
    let diagnostic = Diagnostic::error(message);
    let known: Vec<_> = names.all().filter(|n| !n.is_empty()).collect();
    let help = match known.as_slice() {
        [] => format!("the scene has no {kind}"),
        known => format!("there is {}", quoted_list(known.iter().map(|name| written(name)), 8)),
    };
    diagnostic.at(word.span, "").help(help)
}
