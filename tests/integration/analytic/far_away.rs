//! A scene a million units from the origin looks as it does at the origin.

use crate::support::{Picture, Shot, glow, material, pivot_at, vector};

/// A little of everything about a point, seen from 10 units before it.
fn scene(o: [f64; 3]) -> Picture {
    let at = |x: f64, y: f64, z: f64| vector([o[0] + x, o[1] + y, o[2] + z]);
    let keys = pivot_at(0.0, [o[0] - 1.5, o[1], o[2] + 1.5])
        + &pivot_at(1.0, [o[0] + 1.5, o[1], o[2] + 1.5]);
    let elements = material("paper", "ambient { 0.1 0.1 0.1 } diffuse { 0.6 0.5 0.4 }")
        + &material("mirror", "reflectance 0.9 diffuse { 0.1 0.1 0.1 }")
        + &material("glass", "refraction 0.9 refraction_index 1.5")
        + &glow("blue", [0.2, 0.3, 1.0])
        + &format!(
            "rectangle floor {{ material paper vertex0 {} vertex1 {} vertex2 {} }}
             sphere ball {{ material mirror center {} radius 1 }}
             sphere lens {{ material glass center {} radius 0.8 }}
             box block {{ material paper vertex0 {} vertex1 {} vertex2 {} height 1.2 }}
             cylinder post {{ material paper base {} top {} radius 0.3 }}
             cone hat {{ material blue base {} apex {} radius 0.6 }}
             sphere bird {{ material blue center {{ 0 0 0 }} radius 0.3 {keys} }}
             light_rectangle lamp {{ color {{ 0.8 0.8 0.8 }} vertex0 {} vertex1 {} vertex2 {} }}
             light_point spot {{ color {{ 0.3 0.3 0.3 }} position {} }}",
            at(-9.0, -9.0, -1.0),
            at(9.0, -9.0, -1.0),
            at(9.0, 9.0, -1.0),
            at(-1.2, 1.0, 0.0),
            at(1.0, -1.0, -0.2),
            at(2.0, 2.0, -1.0),
            at(2.0, 3.0, -1.0),
            at(1.0, 3.0, -1.0),
            at(-3.0, 0.0, -1.0),
            at(-3.0, 0.0, 1.0),
            at(0.0, 3.0, -1.0),
            at(0.0, 3.0, 1.0),
            at(-1.0, -1.0, 4.0),
            at(1.0, -1.0, 4.0),
            at(1.0, 1.0, 4.0),
            at(-5.0, -5.0, 5.0),
        );
    let shot = Shot {
        from: vec![[o[0], o[1] - 10.0, o[2] + 2.0]],
        to: vec![o],
        lens: 0.1,
        blur: 1.0,
        samples: 16,
        recursion: 4,
        settings: "background { 0.3 0.3 0.4 }".into(),
        ..Shot::default()
    };
    shot.take(&elements)
}

#[test]
fn a_million_units_away_nothing_changes_but_the_last_digits() {
    let near = scene([0.0; 3]);
    assert!(near.sum(0) > 1000.0 && near.sum(0) < 3000.0);
    for origin in [[1e6, -1e6, 1e6], [123_456.78, 987_654.32, -1e6]] {
        let far = scene(origin);
        // Both pictures take the same samples: what differs is which side of an edge a few rays fall on.
        let mut differences: Vec<f32> = near
            .0
            .rgb
            .iter()
            .zip(&far.0.rgb)
            .map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max))
            .collect();
        differences.sort_by(f32::total_cmp);
        let [most, worst] = [differences[4096 * 95 / 100], differences[4095]];
        let mean = differences.iter().sum::<f32>() / 4096.0;
        assert!(
            most < 2e-3 && mean < 2e-3 && worst < 0.2,
            "95 %: {most}, mean {mean}, worst {worst}"
        );
    }
}
