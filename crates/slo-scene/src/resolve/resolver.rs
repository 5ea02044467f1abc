//! Syntax tree -> scene, element by element.

use std::sync::Arc;

use super::collect::Scene;
use super::elements::{LANGUAGE, Role};
use super::includes::{Texts, Trees};
use super::oddities::Said;
use super::texture::{Image, texture, warn_of_alpha};
use super::{camera, key_frames, lights, oddities, overlaps, photons, repeat, settings, tangents};
use crate::assets::Assets;
use crate::attributes::{Element, Fields, References, Referred};
use crate::description::{Camera, MaterialId, Object, SceneDescription};
use crate::diagnostics::{Diagnostic, Diagnostics, SourceId, Span};
use crate::files::{ContentHash, Files};
use crate::light::Light;
use crate::material::{
    Material, Palette, PhongInfo, ReadMaterial, Whole, check_contained, phong_info, wholes,
};
use crate::settings::Settings;
use crate::shape::ReadShape;
use crate::texture::Texture;

/// The scene of a text that is a source of `diagnostics`, changed by `adapt`; its content means
/// nothing if there are errors.
pub(crate) fn resolve(
    text: &str,
    source: SourceId,
    files: &Files,
    mut hash: ContentHash,
    adapt: &dyn Fn(&mut SceneDescription),
    diagnostics: &mut Diagnostics,
) -> Option<SceneDescription> {
    let texts = Texts::default();
    let trees = Trees::read(text, source, &texts, files, &mut hash, diagnostics);
    let name = diagnostics.source(source).name.clone();
    let scene = Scene::collect(&trees, diagnostics);
    let scale = scaling(&scene, diagnostics);
    let references = scene.references(diagnostics);
    let assets = Assets::new(files, &name, trees.folders.clone(), hash);
    let said = Said::default();
    let mut resolver = Resolver { scene, scale, references, assets, said, diagnostics };
    let description = resolver.description(adapt);
    resolver.references.report_dangling(resolver.diagnostics);
    if !resolver.diagnostics.has_errors() {
        resolver.warn_unused();
    }
    description
}

/// `Scaling`, which stands before everything that it scales.
fn scaling(scene: &Scene<'_, '_>, diagnostics: &mut Diagnostics) -> f64 {
    let element = scene.only(|role| matches!(role, Role::Scaling), diagnostics);
    let Some(element) = element else { return 1.0 };
    if let Some(first) = scene.first_with_positions()
        && scene.is_before(first, &element)
    {
        diagnostics.push(
            Diagnostic::error("`Scaling` stands after an element with positions")
                .at(element.head(), "")
                .also(first.head(), "this would not be scaled")
                .help("write it at the top of the scene"),
        );
    }
    let mut fields = Fields::bare(element, &LANGUAGE, diagnostics);
    let Some([factor]) = fields.numbers(element.keyword, element.block) else { return 1.0 };
    if factor > 0.0 {
        return factor;
    }
    let span = element.block.open.to(element.block.close);
    diagnostics.push(Diagnostic::error("`Scaling` must be more than 0").at(span, ""));
    1.0
}

struct Resolver<'t, 'a, 'd> {
    scene: Scene<'t, 'a>,
    scale: f64,
    references: References<'a>,
    assets: Assets<'d>,
    said: Said<'a>,
    diagnostics: &'d mut Diagnostics,
}

impl<'t, 'a> Resolver<'t, 'a, '_> {
    fn description(&mut self, adapt: &dyn Fn(&mut SceneDescription)) -> Option<SceneDescription> {
        let (settings, background) = self.settings();
        let camera = self.camera();
        let lights = self.lights(camera.as_ref());
        lights::check_sky(&lights, background, self.diagnostics);
        let phong_infos = self.phong_infos();
        let images = self.textures();
        let textures: Vec<_> = images.iter().map(|image| image.texture.clone()).collect();
        let materials = self.materials(&phong_infos, &textures);
        warn_of_alpha(&images, &materials, self.diagnostics);
        let objects = self.objects(camera.as_ref(), &wholes(&materials));
        let mut scene = SceneDescription {
            settings,
            camera: camera?,
            lights: lights.iter().map(|(light, _)| light.clone()).collect(),
            materials,
            textures: textures.into_iter().collect::<Option<_>>()?,
            objects: objects.iter().map(|(object, _)| object.clone()).collect(),
            content_hash: self.assets.hash.finish(),
        };
        if !self.references.are_dangling() && !self.diagnostics.has_errors() {
            adapt(&mut scene);
            oddities::check(&self.said, &scene, self.diagnostics);
            let places: Vec<Span> = lights.iter().map(|(_, place)| *place).collect();
            photons::check(self.said.photons, &scene, &places, self.diagnostics);
            overlaps::check(&objects, &lights, &scene.camera, self.diagnostics);
        }
        Some(scene)
    }

    fn fields(&mut self, element: Element<'t, 'a>) -> Fields<'t, 'a, '_> {
        Fields::read(element, &LANGUAGE, self.scale, self.diagnostics)
    }

    /// The settings, and where they set `background`.
    fn settings(&mut self) -> (Settings, Option<Span>) {
        match self.scene.only(|role| matches!(role, Role::Settings), self.diagnostics) {
            Some(element) => {
                let mut fields = self.fields(element);
                let place = |name| Some(fields.get(name)?.keyword.span);
                let (background, shadow) = (place("background"), place("shadow"));
                let photons = [place("photons"), place("photonSeed")];
                let of_photon_map = settings::OF_PHOTON_MAP.iter();
                let of_photon_map =
                    of_photon_map.filter_map(|name| Some(fields.get(name)?.keyword)).collect();
                let settings = settings::settings(&mut fields);
                (self.said.shadow, self.said.photons) = (shadow, photons);
                self.said.of_photon_map = of_photon_map;
                (settings, background)
            }
            None => (Settings::default(), None),
        }
    }

    fn camera(&mut self) -> Option<Camera> {
        let element = self.scene.only(|role| matches!(role, Role::Camera), self.diagnostics);
        let Some(element) = element else {
            // If the text has no element at all, its content has been reported.
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
    fn lights(&mut self, camera: Option<&Camera>) -> Vec<(Light, Span)> {
        let elements = self.scene.of(|role| match role {
            Role::Light(read) => Some(read),
            _ => None,
        });
        let light = |(read, element)| {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            let references = &mut self.references;
            let mut palette = Palette { references, phong_infos: &[], textures: &[] };
            self.said.groups.extend(fields.word("light_group"));
            lights::light(read, &mut fields, &mut palette, camera)
        };
        elements.into_iter().filter_map(light).collect()
    }

    fn phong_infos(&mut self) -> Vec<PhongInfo> {
        let elements = self.scene.of(|role| matches!(role, Role::PhongInfo).then_some(()));
        let ambient = &mut self.said.ambient;
        let mut read = |(_, element)| {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            let info = phong_info(&mut fields);
            let field = fields.get("ambient").filter(|_| info.ambient != [0.0; 3]);
            ambient.extend(field.map(|field| field.keyword.span));
            info
        };
        elements.into_iter().map(&mut read).collect()
    }

    fn textures(&mut self) -> Vec<Image<'a>> {
        let elements = self.scene.of(|role| matches!(role, Role::Texture).then_some(()));
        let image = |(_, element)| {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            texture(&mut fields, &mut self.assets)
        };
        elements.into_iter().map(image).collect()
    }

    fn materials(
        &mut self,
        phong_infos: &[PhongInfo],
        textures: &[Option<Arc<Texture>>],
    ) -> Vec<Material> {
        let elements = self.scene.of(|role| match role {
            Role::Material(read) => Some(read),
            _ => None,
        });
        let heads: Vec<_> = elements.iter().map(|(_, element)| element.head()).collect();
        let mut material = |(read, element)| self.material(read, element, phong_infos, textures);
        let materials: Vec<_> = elements.into_iter().filter_map(&mut material).collect();
        // If one is missing, references lead to others.
        if materials.len() == heads.len() {
            check_contained(&materials, &heads, self.diagnostics);
        }
        materials
    }

    fn material(
        &mut self,
        read: ReadMaterial,
        element: Element<'t, 'a>,
        phong_infos: &[PhongInfo],
        textures: &[Option<Arc<Texture>>],
    ) -> Option<Material> {
        let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
        let mut palette = Palette { references: &mut self.references, phong_infos, textures };
        let kind = read(&mut fields, &mut palette)?;
        Some(Material { name: element.name.text.to_owned(), kind })
    }

    /// Objects, with the places that they are defined at.
    fn objects(&mut self, camera: Option<&Camera>, materials: &[Whole]) -> Vec<(Object, Span)> {
        let elements = self.scene.objects();
        let object = |(read, element): (ReadShape, Element<'t, 'a>)| {
            Some((self.object(read, element, camera, materials)?, element.head()))
        };
        let mut objects = elements.into_iter().filter_map(object).collect::<Vec<_>>();
        self.assets.release_meshes();
        tangents::add_tangents(&mut objects, materials);
        objects
    }

    fn object(
        &mut self,
        read: ReadShape,
        element: Element<'t, 'a>,
        camera: Option<&Camera>,
        materials: &[Whole],
    ) -> Option<Object> {
        let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
        let material = fields.word("material");
        let key_frames = key_frames::key_frames(&mut fields);
        if let Some(camera) = camera {
            oddities::check_key_times(&mut fields, &key_frames, camera);
        }
        let repeat = repeat::repeat(&mut fields, &key_frames, camera);
        let sampled = fields.count("sampled", 0, 1).is_none_or(|flag| flag.value == 1);
        let light_group = fields.word("light_group");
        self.said.groups.extend(light_group);
        let light_group = light_group.map(|group| group.text.to_owned());
        let shape = read(&mut fields, &mut self.assets);
        let files = fields.words("filename").unwrap_or_default();
        let find = |name| self.references.find(Referred::Material, name);
        let material = material.and_then(find);
        if let Some(material) = material {
            self.said.emission.extend(oddities::emission(&fields, material));
        }
        if material.and_then(|index| materials.get(index)).is_some_and(|m| m.has_images) {
            self.assets.warn_without_uvs(&files, self.diagnostics);
        }
        Some(Object {
            name: element.name.text.to_owned(),
            material: MaterialId(material? as u32),
            shape: shape?,
            key_frames,
            repeat,
            sampled,
            light_group,
        })
    }

    fn warn_unused(&mut self) {
        self.references.warn_unused(self.diagnostics);
        if self.scene.objects().is_empty() {
            self.diagnostics.push(Diagnostic::warning("the scene has no objects"));
        }
    }
}
