//! Different ways to sample the same integral agree on its value.

use crate::support::{Picture, Shot, glow, material, pivot_at};

/// A scene that samples everything at once: pixel, time, lens, lights, glossy reflection and
/// refraction.
fn everything(settings: &str, samples: u32) -> Picture {
    let keys = pivot_at(0.0, [-2.0, 0.0, 1.0]) + &pivot_at(1.0, [2.0, 0.0, 1.0]);
    let elements = material("paper", "ambient { 0.1 0.1 0.1 } diffuse { 0.6 0.5 0.4 }")
        + &material("brass", "reflectance 0.7 diffuse_reflection 0.3 diffuse { 0.2 0.2 0 }")
        + &material("frost", "refraction 0.8 refraction_index 1.3 diffuse_refraction 0.1")
        + &glow("blue", [0.2, 0.3, 1.0])
        + &format!(
            "plane floor {{ material paper normal {{ 0 0 1 }} position {{ 0 0 -1 }} }}
             sphere ball {{ material brass center {{ -1.5 1 0 }} radius 1 }}
             sphere lens {{ material frost center {{ 1 -1 -0.2 }} radius 0.8 }}
             sphere bird {{ material blue center {{ 0 0 0 }} radius 0.5 {keys} }}
             light_rectangle lamp {{
                 color {{ 0.7 0.7 0.7 }} vertex0 {{ -1 -1 4 }} vertex1 {{ 1 -1 4 }} vertex2 {{ 1 1 4 }}
             }}
             light_point spot {{ color {{ 0.4 0.2 0.2 }} position {{ -5 -5 5 }} }}"
        );
    let shot = Shot {
        lens: 0.3,
        blur: 1.0,
        samples,
        settings: format!("background {{ 0.3 0.3 0.4 }} {settings}"),
        ..Shot::default()
    };
    shot.take(&elements)
}

/// Means over blocks of 8 x 8 pixels.
fn blocks(picture: &Picture) -> Vec<f64> {
    let mean = |block: usize| {
        let (bx, by) = (block % 8 * 8, block / 8 * 8);
        let pixels = (0..64).map(|i| picture.at(bx + i % 8, by + i / 8));
        pixels.map(|p| p[0] + p[1] + p[2]).sum::<f64>() / 192.0
    };
    (0..64).map(mean).collect()
}

/// Root mean square difference of the blocks, and the difference of the means of the whole
/// pictures.
fn differences(a: &[f64], b: &[f64]) -> [f64; 2] {
    let each = a.iter().zip(b).map(|(a, b)| a - b);
    [(each.clone().map(|d| d * d).sum::<f64>() / 64.0).sqrt(), (each.sum::<f64>() / 64.0).abs()]
}

#[test]
fn generators_and_ways_to_ask_lights_agree() {
    let reference = blocks(&everything("", 256));
    for settings in [
        "generatorType PSEUDO",
        "generatorType ZERO_TWO",
        "generatorType QUASI seed 1",
        "lightSamplingType SAMPLE_ONE_AT_TIME",
        "lightSamplingType SAMPLE_ONE_AT_TIME softShadowSamples 3",
        "softShadowSamples 4 diffuseReflectionSamples 3 diffuseRefractionSamples 2",
        "dofSamples 2 accelerator NONE",
    ] {
        // The standard deviation of one sample is below 0.3 here: at most 0.005 over 64 pixels of
        // 64 samples, and 0.0006 over the picture.
        let [each, whole] = differences(&blocks(&everything(settings, 64)), &reference);
        assert!(each < 5e-3 && whole < 2e-3, "{settings}: {each}, {whole}");
    }
    // A bias of 2 % would be detected.
    let darker: Vec<f64> = reference.iter().map(|v| v * 0.98).collect();
    assert!(differences(&darker, &reference)[0] > 5e-3);
}

#[test]
fn another_seed_or_frame_changes_noise_and_nothing_else() {
    let [a, b] = ["seed 1", "seed 2"].map(|seed| everything(seed, 4));
    assert!(a.0 != b.0);
    assert!(differences(&blocks(&a), &blocks(&b))[1] < 0.01);
}
