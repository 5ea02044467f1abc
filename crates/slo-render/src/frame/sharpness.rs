//! How sharp materials are: where photons are sent.

use slo_scene::material::{Principled, inside_out};
use slo_scene::{Material, MaterialKind};

use crate::shading::bsdf::{SHARP, SHARP_INVERSE};
use crate::shading::material;

/// Estimates the share of light that the sharp lobes of each material scatter; 0 if it has none.
pub(super) fn shares(materials: &[Material]) -> Vec<f32> {
    let mut shares = vec![0.0f32; materials.len()];
    // Materials in circles are errors of the scene.
    for number in inside_out(materials).unwrap_or_default() {
        let material = &materials[number.0 as usize];
        shares[number.0 as usize] = match &material.kind {
            MaterialKind::Phong(_) => {
                let row = material::row(material);
                let if_sharp = |share, inverse| if inverse < SHARP_INVERSE { share } else { 0.0 };
                if_sharp(row.reflectance, row.reflection_lobe)
                    + if_sharp(row.refraction, row.refraction_lobe)
            }
            MaterialKind::Principled(of) => of_principled(of),
            MaterialKind::Mix(mix) => [mix.first, mix.second]
                .iter()
                .fold(0.0, |most, part| most.max(shares[part.0 as usize])),
        };
    }
    shares
}

fn of_principled(of: &Principled) -> f32 {
    let Principled { roughness, coat, coat_roughness, metallic, transmission, .. } = of;
    // An image may darken a roughness to 0.
    let is_sharp = |roughness: &slo_scene::material::Varying<f32>| {
        roughness.image.is_some() || roughness.value * roughness.value < SHARP
    };
    let root = (of.ior.value - 1.0) / (of.ior.value + 1.0).max(f32::MIN_POSITIVE);
    let gloss = (root * root * 2.0 * of.specular_ior_level.value).min(1.0);
    let below = transmission.value + (1.0 - transmission.value) * gloss;
    let base = metallic.value + (1.0 - metallic.value) * below;
    let coated = if is_sharp(coat_roughness) { coat.value * 0.04 } else { 0.0 };
    coated + if is_sharp(roughness) { base } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use slo_scene::{Files, load};

    use super::*;

    fn materials(elements: &str, last: &str) -> Vec<Material> {
        let text = format!(
            "Camera c {{ fps 25 Film f {{ width 8 height 8 }}
                CamSegment a {{ videoStart 0 videoEnd 1 addPosition {{ 0 -9 0 }} addTarget {{ 0 0 0 }} fovStart .3 }} }}
             lamp_point l {{ power {{ 9 9 9 }} position {{ 0 0 4 }} }}
             {elements} sphere s {{ center {{ 0 0 0 }} radius 1 material {last} }}"
        );
        let loaded = load("scene.txt", text.as_bytes(), &Files::built_in("", &[]));
        let scene = loaded.scene.unwrap_or_else(|| panic!("{}", loaded.diagnostics.render(false)));
        scene.materials
    }

    #[test]
    fn what_is_said_to_be_sharp_is_a_target() {
        for (is_sharp, material) in [
            (true, "material_principled m { roughness 0 }"),
            (true, "material_principled m { roughness .446 metallic 1 }"),
            (false, "material_principled m { roughness .448 metallic 1 transmission 1 }"),
            (false, "material_principled m { }"),
            (true, "material_principled m { coat .5 }"),
            (false, "material_principled m { coat .5 coat_roughness .5 }"),
            (false, "material_principled m { roughness 0 specular_ior_level 0 }"),
            (
                true,
                "phong_info i { reflectance .5 diffuse_reflection .142 } material_phong m { phong_info i }",
            ),
            (
                false,
                "phong_info i { reflectance .5 diffuse_reflection .144 } material_phong m { phong_info i }",
            ),
            (
                true,
                "phong_info i { refraction .5 refraction_index 1.5 } material_phong m { phong_info i }",
            ),
            (false, "phong_info i { diffuse { 1 1 1 } } material_phong m { phong_info i }"),
        ] {
            let found = &materials(material, "m");
            assert_eq!(found[0].kind.is_sharp(), is_sharp, "{material}");
            assert_eq!(shares(found)[0] > 0.0, is_sharp, "{material}");
        }
    }

    #[test]
    fn mixes_of_mixes_take_no_time() {
        let mut elements = "material_principled m0 { roughness 0 transmission 1 } ".to_owned();
        for i in 1..60 {
            let below = i - 1;
            elements += &format!("material_mix m{i} {{ first m{below} second m{below} }} ");
        }
        let found = shares(&materials(&elements, "m59"));
        assert!(found.iter().all(|share| *share == found[0]) && found[0] > 0.9, "{found:?}");
    }
}
