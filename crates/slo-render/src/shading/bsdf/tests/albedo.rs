//! Albedos of whole materials.

use super::hits::{Hits, color, direction, material};
use crate::shading::material::principled::Parameters;
use slo_accel::math::columns::BATCH;

const DEGREES: [f64; 3] = [0.0, 60.0, 80.0];

fn albedos(parameters: &Parameters, eta: f64) -> [f64; 3] {
    let hits = Hits::new(parameters, &DEGREES.map(|d| direction(d, 0.1)), true);
    [0, 1, 2].map(|i| hits.albedo(i, eta, 100_000).x)
}

/// What Blender 5.0.1 returned, from 0, 60 and 80 degrees.
#[test]
fn materials_return_what_blender_does() {
    let gray = |p: &mut Parameters, x: f32| color(&mut p.base_color, [x; 3]);
    let roughness = |p: &mut Parameters, x: f32| p.roughness = [x; BATCH];
    let cases: [(&str, Box<Parameters>, [f64; 3]); 17] = [
        ("defaults", material(|_| ()), [0.8074, 0.8124, 0.8221]),
        ("white", material(|p| gray(p, 1.0)), [0.9999, 0.9986, 0.9914]),
        ("black", material(|p| gray(p, 0.0)), [0.0373, 0.0678, 0.1448]),
        (
            "black, smooth",
            material(|p| {
                gray(p, 0.0);
                roughness(p, 0.0);
            }),
            [0.0400, 0.0892, 0.3877],
        ),
        (
            "black, rough",
            material(|p| {
                gray(p, 0.0);
                roughness(p, 1.0);
            }),
            [0.0138, 0.0245, 0.0477],
        ),
        (
            "black, level 1",
            material(|p| {
                gray(p, 0.0);
                p.specular_ior_level = [1.0; BATCH];
            }),
            [0.0746, 0.1055, 0.1809],
        ),
        ("metal", material(|p| p.metallic = [1.0; BATCH]), [0.7861, 0.7810, 0.7999]),
        (
            "metal, rough",
            material(|p| {
                p.metallic = [1.0; BATCH];
                roughness(p, 1.0);
            }),
            [0.5976, 0.6405, 0.7069],
        ),
        (
            "white metal, rough",
            material(|p| {
                gray(p, 1.0);
                p.metallic = [1.0; BATCH];
                roughness(p, 1.0);
            }),
            [1.0000, 0.9998, 0.9992],
        ),
        (
            "rough diffuse",
            material(|p| {
                p.diffuse_roughness = [1.0; BATCH];
                p.ior = [1.0; BATCH];
            }),
            [0.7312, 0.7586, 0.7860],
        ),
        (
            "coat",
            material(|p| {
                gray(p, 0.0);
                p.ior = [1.0; BATCH];
                p.coat = [1.0; BATCH];
            }),
            [0.0400, 0.0892, 0.3877],
        ),
        (
            "sheen",
            material(|p| {
                gray(p, 0.0);
                p.ior = [1.0; BATCH];
                p.sheen = [1.0; BATCH];
            }),
            [0.0186, 0.1539, 0.4579],
        ),
        (
            "sheen on white",
            material(|p| {
                gray(p, 1.0);
                p.ior = [1.0; BATCH];
                p.sheen = [1.0; BATCH];
            }),
            [1.0; 3],
        ),
        ("glass", material(|p| p.transmission = [1.0; BATCH]), [0.8969, 0.8983, 0.9020]),
        (
            "glass, rougher",
            material(|p| {
                p.transmission = [1.0; BATCH];
                roughness(p, 0.7);
            }),
            [0.8951, 0.8892, 0.8875],
        ),
        (
            "white glass, rough",
            material(|p| {
                gray(p, 1.0);
                p.transmission = [1.0; BATCH];
                roughness(p, 1.0);
            }),
            [1.0002, 1.0000, 0.9969],
        ),
        ("Lambert", material(|p| p.specular_ior_level = [0.0; BATCH]), [0.8; 3]),
    ];
    let mut wrong = Vec::new();
    for (name, parameters, expected) in cases {
        let found = albedos(&parameters, 1.5);
        for (found, expected) in found.into_iter().zip(expected) {
            if (found - expected).abs() > (0.005 * expected).max(0.001) {
                wrong.push(format!("{name}: {found:.4} is not {expected:.4}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What Blender 5.0.1 returned from sheen on black, at cosines of 1/9, 2/9, 3/9 and 6/9.
#[test]
fn sheen_returns_what_blender_does() {
    let cos = [1.0 / 9.0, 2.0 / 9.0, 3.0 / 9.0, 6.0 / 9.0];
    let eyes = cos.map(|cos: f64| direction(libm::acos(cos).to_degrees(), 0.1));
    for (roughness, expected) in [
        (0.05, [0.00056, 0.00002, 0.0, 0.0]),
        (0.1, [0.03219, 0.00096, 0.00013, 0.0]),
        (0.15, [0.15337, 0.01613, 0.00203, 0.00007]),
        (0.25, [0.35026, 0.13339, 0.04187, 0.00182]),
        (0.5, [0.53733, 0.39961, 0.28144, 0.07967]),
    ] {
        let parameters = material(|p| {
            color(&mut p.base_color, [0.0; 3]);
            p.ior = [1.0; BATCH];
            p.sheen = [1.0; BATCH];
            p.sheen_roughness = [roughness; BATCH];
        });
        let hits = Hits::new(&parameters, &eyes, true);
        for (i, expected) in expected.into_iter().enumerate() {
            let found = hits.albedo(i, 1.0, 10_000).x;
            let off = (found - expected).abs();
            assert!(off < 0.005 * expected + 2e-5, "{roughness}, {i}: {found} is not {expected}");
        }
    }
}

/// White materials scatter all light, whatever their roughness.
#[test]
fn white_furnace() {
    let degrees = [0.0, 30.0, 60.0, 75.0, 85.0];
    let mut wrong = Vec::new();
    for step in 0..=20 {
        let r = step as f32 / 20.0;
        let white = |change: &dyn Fn(&mut Parameters)| {
            material(|p| {
                color(&mut p.base_color, [1.0; 3]);
                p.roughness = [r; BATCH];
                change(p);
            })
        };
        let glass = || white(&|p| p.transmission = [1.0; BATCH]);
        let cases = [
            ("gloss", white(&|_| ()), true),
            ("metal", white(&|p| p.metallic = [1.0; BATCH]), true),
            ("glass", glass(), true),
            ("glass from inside", glass(), false),
            (
                "pane",
                white(&|p| {
                    p.transmission = [1.0; BATCH];
                    p.thin = [1.0; BATCH];
                }),
                true,
            ),
            (
                "coat",
                white(&|p| {
                    p.coat = [1.0; BATCH];
                    p.coat_roughness = [r; BATCH];
                    p.ior = [1.0; BATCH];
                }),
                true,
            ),
            (
                "sheen",
                white(&|p| {
                    p.sheen = [1.0; BATCH];
                    p.sheen_roughness = [r; BATCH];
                    p.ior = [1.0; BATCH];
                }),
                true,
            ),
            (
                "rough diffuse",
                white(&|p| {
                    p.diffuse_roughness = [r; BATCH];
                    p.ior = [1.0; BATCH];
                }),
                true,
            ),
        ];
        for (name, parameters, outside) in cases {
            // Total reflection is the hardest.
            if outside && step % 2 == 1 {
                continue;
            }
            let hits = Hits::new(&parameters, &degrees.map(|d| direction(d, 0.2)), outside);
            let eta = if parameters.thin[0] == 1.0 { 1.0 } else { parameters.ior[0] };
            let eta = f64::from(if outside { eta } else { 1.0 / eta });
            for (i, degrees) in degrees.into_iter().enumerate() {
                let found = hits.albedo(i, eta, 20_000).x;
                if (found - 1.0).abs() > 0.005 {
                    wrong.push(format!("{name}, roughness {r}, {degrees} degrees: {found:.4}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
