//! What a scene consists of, in a few lines.

use std::collections::HashSet;
use std::fmt;
use std::sync::Arc;

use super::{LightShape, SceneDescription, Shape};
use crate::animation::{Clock, SegmentFrames};

/// Counts of a scene, for people who check it without rendering it.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Objects.
    pub objects: usize,
    /// Objects with two key frames or more.
    pub animated_objects: usize,
    /// Triangles that the objects are made of, before any is tessellated or lights are added.
    pub triangles: usize,
    /// Spheres, cylinders and cones.
    pub curved: usize,
    /// Lights without and with an area.
    pub lights: [usize; 2],
    /// Materials.
    pub materials: usize,
    /// Different images.
    pub textures: usize,
    /// Different meshes.
    pub meshes: usize,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// Least and most camera paths per pixel.
    pub samples: [u32; 2],
    /// Frames of each camera segment, in order of time.
    pub segments: Vec<SegmentFrames>,
}

impl SceneDescription {
    /// What the scene consists of.
    pub fn summary(&self) -> Summary {
        let shapes = self.objects.iter().map(|o| &o.shape);
        let area_lights = self.lights.iter().filter(|l| is_area(&l.shape)).count();
        let per_pixel = |samples: u32| samples.saturating_mul(self.settings.dof_samples);
        Summary {
            objects: self.objects.len(),
            animated_objects: self.objects.iter().filter(|o| o.key_frames.len() > 1).count(),
            triangles: shapes.clone().map(triangles).sum(),
            curved: shapes.clone().filter(|s| triangles(s) == 0).count(),
            lights: [self.lights.len() - area_lights, area_lights],
            materials: self.materials.len(),
            textures: self.textures.iter().map(Arc::as_ptr).collect::<HashSet<_>>().len(),
            meshes: shapes.filter_map(mesh_address).collect::<HashSet<_>>().len(),
            size: [self.camera.film.width, self.camera.film.height],
            samples: [self.settings.image_min_samples, self.settings.image_samples].map(per_pixel),
            segments: Clock::new(&self.camera).segments().cloned().collect(),
        }
    }
}

fn is_area(shape: &LightShape) -> bool {
    matches!(shape, LightShape::Rectangle { .. })
}

fn triangles(shape: &Shape) -> usize {
    match shape {
        Shape::Triangle { .. } => 1,
        Shape::Plane { .. } | Shape::Rectangle { .. } => 2,
        Shape::Box { .. } => 12,
        Shape::Mesh { mesh, .. } => mesh.faces.len(),
        Shape::Sphere { .. } | Shape::Cylinder { .. } | Shape::Cone { .. } => 0,
    }
}

fn mesh_address(shape: &Shape) -> Option<*const super::Mesh> {
    match shape {
        Shape::Mesh { mesh, .. } => Some(Arc::as_ptr(mesh)),
        _ => None,
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size;
        let [least, most] = self.samples;
        let [points, areas] = self.lights;
        writeln!(f, "picture    {width} x {height}, {} per pixel", range(least, most))?;
        writeln!(f, "objects    {}, {} of them animated", self.objects, self.animated_objects)?;
        writeln!(f, "triangles  {}", self.triangles)?;
        writeln!(f, "curved     {}", self.curved)?;
        writeln!(f, "lights     {}, {areas} of them with an area", points + areas)?;
        writeln!(f, "materials  {}", self.materials)?;
        writeln!(f, "meshes     {}", self.meshes)?;
        writeln!(f, "textures   {}", self.textures)?;
        self.segments.iter().try_for_each(|segment| writeln!(f, "segment    {segment}"))
    }
}

fn range(least: u32, most: u32) -> String {
    match (least, most) {
        (1, 1) => "1 sample".to_owned(),
        _ if least == most => format!("{most} samples"),
        _ => format!("{least} to {most} samples"),
    }
}
