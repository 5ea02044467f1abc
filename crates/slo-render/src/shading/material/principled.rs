//! `material_principled`: its numbers at hits.

use glam::Vec3;
use slo_accel::math::columns::{BATCH, Column, Vec3s, look_up_each};
use slo_accel::math::elementary::log2;
use slo_scene::material::Principled;

/// Columns of numbers of principled materials.
const COLUMNS: usize = 34;

/// The numbers of a principled material where no image changes them; see
/// [`Principled`] for their meaning.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// RGB.
    pub base_color: Vec3,
    /// RGB.
    pub specular_tint: Vec3,
    /// RGB.
    pub coat_tint: Vec3,
    /// RGB.
    pub sheen_tint: Vec3,
    /// Emitted radiance, W/(m² sr): colour times strength.
    pub emission: Vec3,
    /// Absorption coefficients inside the object, per scene unit.
    pub absorption: Vec3,
    /// See [`Principled::metallic`].
    pub metallic: f32,
    /// See [`Principled::roughness`].
    pub roughness: f32,
    /// See [`Principled::diffuse_roughness`].
    pub diffuse_roughness: f32,
    /// See [`Principled::ior`].
    pub ior: f32,
    /// See [`Principled::alpha`].
    pub alpha: f32,
    /// See [`Principled::normal_strength`].
    pub normal_strength: f32,
    /// See [`Principled::specular_ior_level`].
    pub specular_ior_level: f32,
    /// See [`Principled::anisotropic`].
    pub anisotropic: f32,
    /// See [`Principled::anisotropic_rotation`].
    pub anisotropic_rotation: f32,
    /// See [`Principled::transmission`].
    pub transmission: f32,
    /// See [`Principled::coat`].
    pub coat: f32,
    /// See [`Principled::coat_roughness`].
    pub coat_roughness: f32,
    /// See [`Principled::coat_ior`].
    pub coat_ior: f32,
    /// See [`Principled::sheen`].
    pub sheen: f32,
    /// See [`Principled::sheen_roughness`].
    pub sheen_roughness: f32,
    /// 1 for a pane without thickness, 0 otherwise.
    pub thin: f32,
}

impl Constants {
    /// Prepares a material of a scene.
    pub fn new(of: &Principled) -> Self {
        let distance = of.absorption_distance as f32;
        let per_unit = |left: f32| -log2(left.clamp(1e-6, 1.0)) * std::f32::consts::LN_2 / distance;
        let absorption =
            of.absorption_color.map(|left| if distance > 0.0 { per_unit(left) } else { 0.0 });
        Self {
            emission: Vec3::from(of.emission_color.value) * of.emission_strength.value,
            absorption: absorption.into(),
            thin: f32::from(u8::from(of.thin)),
            base_color: of.base_color.value.into(),
            specular_tint: of.specular_tint.value.into(),
            coat_tint: of.coat_tint.value.into(),
            sheen_tint: of.sheen_tint.value.into(),
            metallic: of.metallic.value,
            roughness: of.roughness.value,
            diffuse_roughness: of.diffuse_roughness.value,
            ior: of.ior.value,
            alpha: of.alpha.value,
            normal_strength: of.normal_strength.value,
            specular_ior_level: of.specular_ior_level.value,
            anisotropic: of.anisotropic.value,
            anisotropic_rotation: of.anisotropic_rotation.value,
            transmission: of.transmission.value,
            coat: of.coat.value,
            coat_roughness: of.coat_roughness.value,
            coat_ior: of.coat_ior.value,
            sheen: of.sheen.value,
            sheen_roughness: of.sheen_roughness.value,
        }
    }
}

/// The numbers of all materials in columns, indexed by the material.
#[derive(Clone, Debug, Default)]
pub struct PrincipledTable {
    base_color: [Vec<f32>; 3],
    specular_tint: [Vec<f32>; 3],
    coat_tint: [Vec<f32>; 3],
    sheen_tint: [Vec<f32>; 3],
    emission: [Vec<f32>; 3],
    absorption: [Vec<f32>; 3],
    metallic: Vec<f32>,
    roughness: Vec<f32>,
    diffuse_roughness: Vec<f32>,
    ior: Vec<f32>,
    alpha: Vec<f32>,
    normal_strength: Vec<f32>,
    specular_ior_level: Vec<f32>,
    anisotropic: Vec<f32>,
    anisotropic_rotation: Vec<f32>,
    transmission: Vec<f32>,
    coat: Vec<f32>,
    coat_roughness: Vec<f32>,
    coat_ior: Vec<f32>,
    sheen: Vec<f32>,
    sheen_roughness: Vec<f32>,
    thin: Vec<f32>,
    /// Whether the materials differ in a column.
    varies: Vec<bool>,
}

/// The numbers at the hits of a batch, in columns.
#[derive(Debug)]
pub struct Parameters {
    /// See [`Constants::base_color`].
    pub base_color: Vec3s,
    /// See [`Constants::specular_tint`].
    pub specular_tint: Vec3s,
    /// See [`Constants::coat_tint`].
    pub coat_tint: Vec3s,
    /// See [`Constants::sheen_tint`].
    pub sheen_tint: Vec3s,
    /// See [`Constants::emission`].
    pub emission: Vec3s,
    /// See [`Constants::absorption`].
    pub absorption: Vec3s,
    /// See [`Constants::metallic`].
    pub metallic: Column<f32>,
    /// See [`Constants::roughness`].
    pub roughness: Column<f32>,
    /// See [`Constants::diffuse_roughness`].
    pub diffuse_roughness: Column<f32>,
    /// See [`Constants::ior`].
    pub ior: Column<f32>,
    /// See [`Constants::alpha`].
    pub alpha: Column<f32>,
    /// See [`Constants::normal_strength`].
    pub normal_strength: Column<f32>,
    /// See [`Constants::specular_ior_level`].
    pub specular_ior_level: Column<f32>,
    /// See [`Constants::anisotropic`].
    pub anisotropic: Column<f32>,
    /// See [`Constants::anisotropic_rotation`].
    pub anisotropic_rotation: Column<f32>,
    /// See [`Constants::transmission`].
    pub transmission: Column<f32>,
    /// See [`Constants::coat`].
    pub coat: Column<f32>,
    /// See [`Constants::coat_roughness`].
    pub coat_roughness: Column<f32>,
    /// See [`Constants::coat_ior`].
    pub coat_ior: Column<f32>,
    /// See [`Constants::sheen`].
    pub sheen: Column<f32>,
    /// See [`Constants::sheen_roughness`].
    pub sheen_roughness: Column<f32>,
    /// See [`Constants::thin`].
    pub thin: Column<f32>,
    /// The number that a whole column holds, as bits, if it is known.
    filled: [Option<u32>; COLUMNS],
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            base_color: Vec3s::default(),
            specular_tint: Vec3s::default(),
            coat_tint: Vec3s::default(),
            sheen_tint: Vec3s::default(),
            emission: Vec3s::default(),
            absorption: Vec3s::default(),
            metallic: [0.0; BATCH],
            roughness: [0.0; BATCH],
            diffuse_roughness: [0.0; BATCH],
            ior: [0.0; BATCH],
            alpha: [0.0; BATCH],
            normal_strength: [0.0; BATCH],
            specular_ior_level: [0.0; BATCH],
            anisotropic: [0.0; BATCH],
            anisotropic_rotation: [0.0; BATCH],
            transmission: [0.0; BATCH],
            coat: [0.0; BATCH],
            coat_roughness: [0.0; BATCH],
            coat_ior: [0.0; BATCH],
            sheen: [0.0; BATCH],
            sheen_roughness: [0.0; BATCH],
            thin: [0.0; BATCH],
            filled: [None; COLUMNS],
        }
    }
}

impl PrincipledTable {
    /// Arranges materials in columns.
    pub fn new(materials: &[Constants]) -> Self {
        let number = |of: fn(&Constants) -> f32| materials.iter().map(of).collect::<Vec<f32>>();
        let color = |of: fn(&Constants) -> Vec3| {
            [0, 1, 2].map(|axis| materials.iter().map(|m| of(m)[axis]).collect::<Vec<f32>>())
        };
        let mut table = Self {
            base_color: color(|m| m.base_color),
            specular_tint: color(|m| m.specular_tint),
            coat_tint: color(|m| m.coat_tint),
            sheen_tint: color(|m| m.sheen_tint),
            emission: color(|m| m.emission),
            absorption: color(|m| m.absorption),
            metallic: number(|m| m.metallic),
            roughness: number(|m| m.roughness),
            diffuse_roughness: number(|m| m.diffuse_roughness),
            ior: number(|m| m.ior),
            alpha: number(|m| m.alpha),
            normal_strength: number(|m| m.normal_strength),
            specular_ior_level: number(|m| m.specular_ior_level),
            anisotropic: number(|m| m.anisotropic),
            anisotropic_rotation: number(|m| m.anisotropic_rotation),
            transmission: number(|m| m.transmission),
            coat: number(|m| m.coat),
            coat_roughness: number(|m| m.coat_roughness),
            coat_ior: number(|m| m.coat_ior),
            sheen: number(|m| m.sheen),
            sheen_roughness: number(|m| m.sheen_roughness),
            thin: number(|m| m.thin),
            varies: Vec::new(),
        };
        let varies = |column: &[f32]| column.iter().any(|x| *x != column[0]);
        table.varies = table.columns().map(varies).to_vec();
        table
    }

    /// All columns, in the order of [`Parameters::columns`].
    fn columns(&self) -> [&[f32]; COLUMNS] {
        [
            &self.base_color[0],
            &self.base_color[1],
            &self.base_color[2],
            &self.specular_tint[0],
            &self.specular_tint[1],
            &self.specular_tint[2],
            &self.coat_tint[0],
            &self.coat_tint[1],
            &self.coat_tint[2],
            &self.sheen_tint[0],
            &self.sheen_tint[1],
            &self.sheen_tint[2],
            &self.emission[0],
            &self.emission[1],
            &self.emission[2],
            &self.absorption[0],
            &self.absorption[1],
            &self.absorption[2],
            &self.metallic,
            &self.roughness,
            &self.diffuse_roughness,
            &self.ior,
            &self.alpha,
            &self.normal_strength,
            &self.specular_ior_level,
            &self.anisotropic,
            &self.anisotropic_rotation,
            &self.transmission,
            &self.coat,
            &self.coat_roughness,
            &self.coat_ior,
            &self.sheen,
            &self.sheen_roughness,
            &self.thin,
        ]
    }

    /// Looks up the numbers of the materials of a batch of hits. `multiplied` tells that the
    /// numbers are changed afterwards.
    #[inline(always)]
    pub fn look_up(
        &self,
        material: &Column<u32>,
        len: usize,
        multiplied: bool,
        to: &mut Parameters,
    ) {
        let mut filled = to.filled;
        let columns = self.columns().into_iter().zip(to.columns());
        for (((table, to), varies), filled) in columns.zip(&self.varies).zip(&mut filled) {
            if *varies {
                look_up_each([table], material, len, [to]);
                *filled = None;
            } else if let Some(&number) = table.first() {
                if *filled != Some(number.to_bits()) {
                    to.fill(number);
                }
                *filled = (!multiplied).then_some(number.to_bits());
            }
        }
        to.filled = filled;
    }
}

impl Parameters {
    /// All columns, in the order of [`PrincipledTable::columns`].
    fn columns(&mut self) -> [&mut Column<f32>; COLUMNS] {
        [
            &mut self.base_color.x,
            &mut self.base_color.y,
            &mut self.base_color.z,
            &mut self.specular_tint.x,
            &mut self.specular_tint.y,
            &mut self.specular_tint.z,
            &mut self.coat_tint.x,
            &mut self.coat_tint.y,
            &mut self.coat_tint.z,
            &mut self.sheen_tint.x,
            &mut self.sheen_tint.y,
            &mut self.sheen_tint.z,
            &mut self.emission.x,
            &mut self.emission.y,
            &mut self.emission.z,
            &mut self.absorption.x,
            &mut self.absorption.y,
            &mut self.absorption.z,
            &mut self.metallic,
            &mut self.roughness,
            &mut self.diffuse_roughness,
            &mut self.ior,
            &mut self.alpha,
            &mut self.normal_strength,
            &mut self.specular_ior_level,
            &mut self.anisotropic,
            &mut self.anisotropic_rotation,
            &mut self.transmission,
            &mut self.coat,
            &mut self.coat_roughness,
            &mut self.coat_ior,
            &mut self.sheen,
            &mut self.sheen_roughness,
            &mut self.thin,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches of several tables, one after the other, with and without images.
    #[test]
    fn numbers_are_those_of_the_table() {
        let material = |ior: f32, roughness: f32| Constants {
            ior,
            roughness,
            ..Constants::new(&Principled::default())
        };
        let tables = [
            PrincipledTable::new(&[material(1.5, 0.2), material(1.5, 0.7)]),
            PrincipledTable::new(&[material(1.2, 0.3), material(1.5, 0.3)]),
            PrincipledTable::new(&[material(1.5, 0.2)]),
        ];
        let index = std::array::from_fn(|i| i as u32 % 2);
        let mut to = Parameters::default();
        for turn in 0..60 {
            let (table, len) = (&tables[turn * 7 % 11 % 3], [40, 700][turn % 2]);
            let multiplied = turn % 5 < 2;
            table.look_up(&index, len, multiplied, &mut to);
            for i in 0..len {
                let row = i % 2 % table.ior.len();
                assert_eq!([to.ior[i], to.roughness[i]], [table.ior[row], table.roughness[row]]);
                if multiplied {
                    to.ior[i] *= 0.5;
                    to.roughness[i] *= 0.5;
                }
            }
        }
    }
}
