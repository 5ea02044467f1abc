//! Syntax tree -> scene, element by element.

use std::sync::Arc;

use super::collect::Scene;
use super::copies::{self, Shown, WrittenCopy};
use super::elements::{LANGUAGE, Role};
use super::includes::{Texts, Trees};
use super::oddities::Said;
use super::spaces::{Hanging, Hangings};
use super::texture::{Image, texture, warn_of_alpha};
use super::{camera, light_maps, lights, oddities, overlaps, photons, settings, tangents};
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
    let hangings = Hangings::default();
    let mut resolver = Resolver { scene, scale, references, assets, said, hangings, diagnostics };
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
    hangings: Hangings,
    diagnostics: &'d mut Diagnostics,
}

impl<'t, 'a> Resolver<'t, 'a, '_> {
    fn description(&mut self, adapt: &dyn Fn(&mut SceneDescription)) -> Option<SceneDescription> {
        let (settings, background) = self.settings();
        let camera = self.camera();
        let (mut lights, light_numbers) = self.lights(camera.as_ref());
        lights::check_sky(&lights, background, self.diagnostics);
        let phong_infos = self.phong_infos();
        let images = self.textures();
        let textures: Vec<_> = images.iter().map(|image| image.texture.clone()).collect();
        let materials = self.materials(&phong_infos, &textures);
        warn_of_alpha(&images, &materials, self.diagnostics);
        let (mut objects, object_numbers) = self.objects(camera.as_ref(), &wholes(&materials));
        self.groups(camera.as_ref());
        let copies = self.copies(camera.as_ref());
        self.assets.release_meshes();
        let hung = self.hangings.hang(self.diagnostics);
        for ((light, _), number) in lights.iter_mut().zip(&light_numbers) {
            light.parent = hung.parent(*number);
        }
        for ((object, _), number) in objects.iter_mut().zip(&object_numbers) {
            object.parent = hung.parent(*number);
        }
        let shown = Shown {
            objects: &objects,
            object_numbers: &object_numbers,
            light_numbers: &light_numbers,
            hangings: &self.hangings,
            hung: &hung,
        };
        let copies = copies::copies(copies, &shown, self.diagnostics);
        let (lights, light_places): (Vec<Light>, Vec<Span>) = lights.into_iter().unzip();
        let (objects, object_places): (Vec<Object>, Vec<Span>) = objects.into_iter().unzip();
        let mut scene = SceneDescription {
            settings,
            camera: camera?,
            lights,
            materials,
            textures: textures.into_iter().collect::<Option<_>>()?,
            objects,
            spaces: hung.spaces,
            copies,
            content_hash: self.assets.hash.finish(),
        };
        if !self.references.are_dangling() && !self.diagnostics.has_errors() {
            adapt(&mut scene);
            oddities::check(&self.said, &scene, self.diagnostics);
            photons::check(self.said.photons, &scene, &light_places, self.diagnostics);
            overlaps::check(&scene, &object_places, &light_places, self.diagnostics);
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

    /// Lights, with the places that they are defined at; and the number of each among all that may
    /// hang.
    fn lights(&mut self, camera: Option<&Camera>) -> (Vec<(Light, Span)>, Vec<usize>) {
        let elements = self.scene.hanging(|role| match role {
            Role::Light(read) => Some(read),
            _ => None,
        });
        let light = |(number, read, element)| {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            let references = &mut self.references;
            let hanging = Hanging::read(&mut fields, references, false, camera);
            self.hangings.insert(number, hanging.clone());
            let mut palette = Palette { references, phong_infos: &[], textures: &[] };
            self.said.groups.extend(fields.word("light_group"));
            Some((lights::light(read, &mut fields, &mut palette, &hanging, camera)?, number))
        };
        elements.into_iter().filter_map(light).unzip()
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

    /// Objects, with the places that they are defined at; and the number of each among all that may
    /// hang.
    fn objects(
        &mut self,
        camera: Option<&Camera>,
        materials: &[Whole],
    ) -> (Vec<(Object, Span)>, Vec<usize>) {
        let elements = self.scene.hanging(|role| match role {
            Role::Object(read) => Some(read),
            _ => None,
        });
        let object = |(number, read, element): (usize, ReadShape, Element<'t, 'a>)| {
            let object = self.object(number, read, element, camera, materials)?;
            Some(((object, element.head()), number))
        };
        let (mut objects, numbers): (Vec<_>, Vec<_>) =
            elements.into_iter().filter_map(object).unzip();
        tangents::add_tangents(&mut objects, materials);
        (objects, numbers)
    }

    /// Reads groups, which are nothing but spaces.
    fn groups(&mut self, camera: Option<&Camera>) {
        let elements = self.scene.hanging(|role| matches!(role, Role::Group).then_some(()));
        for (number, (), element) in elements {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            let hanging = Hanging::read(&mut fields, &mut self.references, true, camera);
            if let Some(camera) = camera {
                oddities::check_key_times(&mut fields, hanging.key_frames(), camera);
            }
            self.hangings.insert(number, hanging);
        }
    }

    /// Reads copies, once all other elements that may hang were read.
    fn copies(&mut self, camera: Option<&Camera>) -> Vec<WrittenCopy> {
        let elements = self.scene.hanging(|role| matches!(role, Role::Copy).then_some(()));
        let copy = |(number, (), element)| {
            let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
            let hanging = Hanging::read(&mut fields, &mut self.references, false, camera);
            if let Some(camera) = camera {
                oddities::check_key_times(&mut fields, hanging.key_frames(), camera);
            }
            self.hangings.insert(number, hanging);
            let (references, assets) = (&mut self.references, &mut self.assets);
            copies::read(number, &mut fields, &self.hangings, references, assets)
        };
        elements.into_iter().filter_map(copy).collect()
    }

    fn object(
        &mut self,
        number: usize,
        read: ReadShape,
        element: Element<'t, 'a>,
        camera: Option<&Camera>,
        materials: &[Whole],
    ) -> Option<Object> {
        let mut fields = Fields::read(element, &LANGUAGE, self.scale, self.diagnostics);
        let material = fields.word("material");
        let hanging = Hanging::read(&mut fields, &mut self.references, false, camera);
        let (key_frames, repeat) = (hanging.key_frames().to_vec(), hanging.repeat());
        self.hangings.insert(number, hanging);
        if let Some(camera) = camera {
            oddities::check_key_times(&mut fields, &key_frames, camera);
        }
        let sampled = fields.count("sampled", 0, 1).is_none_or(|flag| flag.value == 1);
        let hidden = fields.count("hidden", 0, 1).is_some_and(|flag| flag.value == 1);
        let light_group = fields.word("light_group");
        self.said.groups.extend(light_group);
        let light_group = light_group.map(|group| group.text.to_owned());
        let shape = read(&mut fields, &mut self.assets);
        let light_map = light_maps::read(&mut fields, shape.as_ref(), hidden);
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
            parent: None,
            repeat,
            sampled,
            hidden,
            light_group,
            light_map,
        })
    }

    fn warn_unused(&mut self) {
        self.references.warn_unused(self.diagnostics);
        self.hangings.warn_unused(self.diagnostics);
        if self.scene.of(|role| matches!(role, Role::Object(_)).then_some(())).is_empty() {
            self.diagnostics.push(Diagnostic::warning("the scene has no objects"));
        }
    }
}
