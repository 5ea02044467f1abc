//! `--check`: reads a scene with all its files and reports its contents.

use crate::cli::base::{Problem, Terminal, counted};
use crate::cli::files::load;
use crate::cli::options::Job;
use slo_scene::animation::{Clock, Spaces};
use slo_scene::format::Short;
use slo_scene::light::LightKind;
use slo_scene::{Camera, Look, Object, SceneDescription, Settings, Texture, ToneMap};

/// Reports on the job's scene without rendering it.
pub(crate) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    let scene = load::scene(job, terminal)?;
    let clock = Clock::new(&scene.camera);
    if job.frames.is_some() {
        for frame in job.for_scene(&scene)?.frames().numbers {
            clock.shutter(frame).map_err(|error| load::no_segment(&error))?;
        }
    }
    if scene.settings.accelerator.needs_gpu() {
        slo_render::frame::check_device(scene.settings.accelerator).map_err(load::no_frame)?;
    }
    terminal.note("the scene has no errors");
    for line in report(&scene) {
        terminal.note(line);
    }
    Ok(())
}

fn report(scene: &SceneDescription) -> Vec<String> {
    let mut lines = vec![picture(&scene.camera, &scene.settings), samples(&scene.settings)];
    lines.extend(segments(&scene.camera));
    lines.push(objects(scene));
    lines.push(lights_and_materials(scene));
    lines
}

fn picture(camera: &Camera, settings: &Settings) -> String {
    let film = &camera.film;
    let (format, look) = (film.output, look(film.look(settings)));
    format!(
        "picture: {} x {} pixels, {format}, {look}, {} frame{} per second",
        film.width,
        film.height,
        Short(camera.fps),
        if camera.fps == 1.0 { "" } else { "s" }
    )
}

/// Names the encoding, and what is applied before it.
fn look(look: Look) -> String {
    let Look { exposure, tone_map, encoding } = look;
    let mut words = encoding.to_string();
    if exposure != 0.0 {
        words += &format!(", exposure {exposure}");
    }
    if tone_map != ToneMap::None {
        words += &format!(", {tone_map}");
    }
    words
}

fn samples(settings: &Settings) -> String {
    let Settings { image_samples: most, image_min_samples: least, .. } = *settings;
    let image = if least < most { format!("{least} to {most}") } else { most.to_string() };
    format!(
        "samples: {image} image x {} dof, {} shadow, {} reflection, {} refraction; \
         {}, recursion {}",
        settings.dof_samples,
        settings.soft_shadow_samples,
        settings.diffuse_reflection_samples,
        settings.diffuse_refraction_samples,
        settings.integrator,
        settings.recursion()
    )
}

fn segments(camera: &Camera) -> Vec<String> {
    let clock = Clock::new(camera);
    clock.segments().map(|segment| format!("segment {segment}")).collect()
}

fn objects(scene: &SceneDescription) -> String {
    let objects = &scene.objects;
    let spaces = Spaces::new(&scene.spaces).unwrap_or_default();
    let is_moving = |object: &&Object| {
        let path = spaces.path(&object.key_frames, object.repeat, object.parent);
        path.is_ok_and(|path| !path.rests())
    };
    let moving = objects.iter().filter(is_moving).count();
    let triangles: usize = objects.iter().map(|object| object.shape.triangle_count()).sum();
    let triangles = counted(triangles, "triangle");
    format!("objects: {}, {moving} of them animated; {triangles}", objects.len())
}

fn lights_and_materials(scene: &SceneDescription) -> String {
    let count = |sort| scene.lights.iter().filter(|light| sort_of(&light.kind) == sort).count();
    let skies = match count(Sort::Sky) {
        0 => String::new(),
        skies => format!(", {skies} in the sky"),
    };
    let texels = |texture: &Texture| u64::from(texture.width()) * u64::from(texture.height());
    let texels: u64 = scene.textures.iter().map(|texture| texels(texture)).sum();
    format!(
        "lights: {} area, {} point{skies}; materials: {}; textures: {} of {:.1} megapixels",
        count(Sort::Area),
        count(Sort::Point),
        scene.materials.len(),
        scene.textures.len(),
        texels as f64 / 1e6
    )
}

/// What a light is to those who wait for the picture.
#[derive(Clone, Copy, PartialEq)]
enum Sort {
    Point,
    Area,
    Sky,
}

fn sort_of(kind: &LightKind) -> Sort {
    match kind {
        LightKind::SunLamp(_) | LightKind::Environment(_) => Sort::Sky,
        LightKind::DiscLamp(_) => Sort::Area,
        kind if kind.surface().is_some() => Sort::Area,
        _ => Sort::Point,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::options::empty_scene;

    #[test]
    fn frames_per_second_of_any_size_are_short() {
        let mut scene = empty_scene();
        let mut said = |fps: f64| {
            scene.camera.fps = fps;
            picture(&scene.camera, &scene.settings)
        };
        assert!(said(25.0).ends_with(" 25 frames per second"), "{}", said(25.0));
        assert!(said(1.0).ends_with(" 1 frame per second"), "{}", said(1.0));
        assert!(said(1e-300).ends_with(" 1e-300 frames per second"), "{}", said(1e-300));
    }
}
