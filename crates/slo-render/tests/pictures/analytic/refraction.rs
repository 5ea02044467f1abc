//! Snell's law: slabs, prisms, total reflection.

use crate::support::{Picture, Shot, glow, material, panel, rectangle, vector};

/// A view so narrow that its rays are nearly parallel: 0.02 to each side at distance 1.
fn narrow(from: [f64; 3], to: [f64; 3]) -> Shot {
    Shot { from: vec![from], to: vec![to], fov: 0.02, ..Shot::default() }
}

fn glass(index: f64) -> String {
    material("glass", &format!("refraction 1 refraction_index {index}")) + &glow("white", [1.0; 3])
}

/// A box around the origin: `half` are its half sizes along its own axes a and b, and 50 along z. a
/// points to (sin, cos) and b to (cos, -sin) of the angle.
fn slanted_box(angle: f64, half: [f64; 2]) -> String {
    let (s, c) = libm::sincos(angle);
    let corner = |a: f64, b: f64, z: f64| vector([a * s + b * c, a * c - b * s, z]);
    let [a, b] = half;
    format!(
        "box block {{ material glass vertex0 {} vertex1 {} vertex2 {} height {} }}\n",
        corner(-a, b, -50.0),
        corner(-a, -b, -50.0),
        corner(-a, -b, 50.0),
        2.0 * a
    )
}

/// Position of the edge between the dark left and the bright right part of the middle rows, in
/// pixels from the picture's middle.
fn edge(picture: &Picture) -> f64 {
    let columns = picture.columns(28..36, 0);
    assert_eq!((columns[0], columns[63]), (0.0, 1.0), "{columns:?}");
    32.0 - columns.iter().sum::<f64>()
}

#[test]
fn a_slanted_slab_shifts_what_is_behind_it() {
    // A ray that meets a slab of thickness T at angle a leaves it parallel to itself, shifted by T
    // sin a (1 - cos a / (n cos a')) toward the slab's normal, with sin a' = sin a / n.
    let thickness = 0.5;
    for (degrees, index) in [(45.0_f64, 1.5), (45.0, 1.1), (20.0, 2.4), (60.0, 1.33), (45.0, 0.8)] {
        let angle = degrees.to_radians();
        let (sin, cos) = libm::sincos(angle);
        let cos_inside = (1.0 - (sin / index) * (sin / index)).sqrt();
        let shift = thickness * sin * (1.0 - cos / (index * cos_inside));
        let scene = glass(index)
            + &slanted_box(angle, [thickness / 2.0, 4.0])
            + &panel("half", "white", [shift, 100.0], 6.0, [-100.0, 100.0]);
        let found = edge(&narrow([0.0, -10.0, 0.0], [0.0; 3]).take(&scene));
        // A pixel is 0.01 at the panel.
        assert!(found.abs() < 0.25, "{found} at {degrees} degrees, index {index}, shift {shift}");
    }
}

#[test]
fn a_slab_brings_nearer_what_is_behind_it() {
    // Seen straight on, a slab of thickness T brings objects nearer by T (1 - 1/n): a panel 20 away
    // behind a slab of 6 appears 18 away.
    let scene = glass(1.5)
        + &slanted_box(0.0, [3.0, 90.0])
        + &panel("p", "white", [-0.1, 0.1], 10.0, [-0.1, 0.1]);
    let picture = narrow([0.0, -10.0, 0.0], [0.0; 3]).take(&scene);
    let side = 0.2 * 32.0 / (0.02 * 18.0);
    let found = picture.sum(0).sqrt();
    assert!((found / side - 1.0).abs() < 0.01, "{found}, expected {side}");
}

#[test]
fn a_prism_deflects_toward_its_base() {
    // A quarter prism: the corner of a cube, met at 45 degrees. sin a' = sin 45 / n; at the second
    // face the angle inside is 90 - a', and sin e = n sin(90 - a') = n cos a'. The deflection is
    // 45 + e - 90, away from the corner at x = +sqrt 2.
    let index = 1.2;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let inside = libm::asin(half / index);
    let out = libm::asin(index * libm::cos(inside));
    let deflection = out - 45_f64.to_radians();
    // The path through the cube |x| + |y| < sqrt 2 enters at (0.7, 0.7 - sqrt 2), at angle a' to
    // the normal.
    let corner = std::f64::consts::SQRT_2;
    let bend = libm::tan(45_f64.to_radians() - inside);
    let entry = [0.7, 0.7 - corner];
    // x falls by `bend` for every unit of y, until x + y = sqrt 2.
    let way = (corner - entry[0] - entry[1]) / (1.0 - bend);
    let exit = [entry[0] - bend * way, entry[1] + way];
    assert!(exit[0] > 0.0);
    let target = exit[0] - libm::tan(deflection) * (20.0 - exit[1]);
    let scene = glass(index)
        + &slanted_box(45_f64.to_radians(), [1.0, 1.0])
        + &panel("half", "white", [target, 100.0], 20.0, [-100.0, 100.0]);
    let found = edge(&narrow([0.7, -10.0, 0.0], [0.7, 0.0, 0.0]).take(&scene));
    assert!(found.abs() < 0.25, "{found}");
}

#[test]
fn a_ray_that_can_not_leave_is_reflected_with_all_its_light() {
    // A cube of index 1.5, met at 45 degrees beside its corner. The ray is totally reflected at the
    // second face and leaves through the third at 45 degrees, perpendicular to its original
    // direction.
    let index = 1.5;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let corner = std::f64::consts::SQRT_2;
    let inside = libm::asin(half / index);
    let bend = libm::tan(45_f64.to_radians() - inside);
    let entry = [0.8, 0.8 - corner];
    let way = (corner - entry[0] - entry[1]) / (1.0 - bend);
    let second = [entry[0] - bend * way, entry[1] + way];
    // Reflected at x + y = sqrt 2, the direction (-bend, 1) becomes (-1, bend); then -x + y = sqrt
    // 2.
    let way = (corner + second[0] - second[1]) / (1.0 + bend);
    let third = [second[0] - way, second[1] + bend * way];
    assert!(second[0] > 0.0 && third[0] < 0.0 && second[1] > 0.0);
    // A wall at x = -5, glowing in its farther part, where y is above the ray's.
    let wall = |to: f64| {
        let y = third[1];
        rectangle("w", "white", [[-5.0, y, -9.0], [-5.0, to, -9.0], [-5.0, to, 9.0]], "")
    };
    let scene = |to: f64| glass(index) + &slanted_box(45_f64.to_radians(), [1.0, 1.0]) + &wall(to);
    let shot = Shot { fov: 0.01, ..narrow([0.8, -10.0, 0.0], [0.8, 0.0, 0.0]) };
    // x to the right at the entry corresponds to y downward at the wall.
    let picture = shot.take(&scene(3.0));
    let columns = picture.columns(28..36, 0);
    assert_eq!((columns[63], columns[0]), (0.0, 1.0), "{columns:?}");
    let found = columns.iter().sum::<f64>() - 32.0;
    assert!(found.abs() < 0.25, "{found}");
    // In, reflected, out: three bounces.
    let short = Shot { recursion: 2, ..shot };
    short.take(&scene(3.0)).assert_is([0.0; 3], 0.0);
}

#[test]
fn the_window_of_a_diver_has_the_critical_angle() {
    // A camera below the surface of a medium of index 1.5 sees the sky within asin(1 / 1.5), a disc
    // of tangent 1 / sqrt(1.5^2 - 1), and beyond it the mirrored ground.
    let surface = [[-900.0, -900.0, 1.0], [900.0, -900.0, 1.0], [900.0, 900.0, 1.0]];
    let ground = [[-900.0, -900.0, -1.0], [900.0, -900.0, -1.0], [900.0, 900.0, -1.0]];
    let scene = material("water", "refraction 1 refraction_index 1.5")
        + &glow("mud", [0.0, 0.0, 1.0])
        + &rectangle("surface", "water", surface, "")
        + &rectangle("ground", "mud", ground, "");
    let shot = Shot {
        from: vec![[0.0; 3]],
        to: vec![[0.0, 0.0, 1.0]],
        sky: [0.0, 1.0, 0.0],
        fov: 1.2,
        settings: "background { 1 0 0 }".into(),
        ..Shot::default()
    };
    let picture = shot.take(&scene);
    let radius = 32.0 / 1.2 / (1.5_f64 * 1.5 - 1.0).sqrt();
    let area = std::f64::consts::PI * radius * radius;
    assert!((picture.sum(0) / area - 1.0).abs() < 2e-3, "{}, expected {area}", picture.sum(0));
    assert!((picture.sum(0) + picture.sum(2) - 4096.0).abs() < 1e-3);
    let corner = |x: f64, y: f64| f64::hypot(x - 31.5, y - 31.5);
    for (x, y) in (0..64).flat_map(|y| (0..64).map(move |x| (x, y))) {
        let distance = corner(x as f64, y as f64);
        if (distance - radius).abs() > 0.8 {
            assert_eq!(picture.at(x, y)[0], f64::from(distance < radius), "{x} {y}");
        }
    }
}

#[test]
fn a_frosted_slab_passes_a_lobe_about_the_refracted_direction() {
    // Straight on, the ray passes undeflected, with a lobe at the front face and one at the back.
    // With an index of 1, both are about the ray itself. Here only the first surface exists: one
    // rectangle. The share of light farther than angle a from the axis is cos^(n+1) a.
    for sigma in [0.1, 0.3] {
        let n = 1.0 / (sigma * sigma);
        let a = sigma * 0.8;
        let radius = 40.0 * libm::tan(a);
        let phong = format!("refraction 1 diffuse_refraction {sigma} refraction_index 1");
        let scene = material("frosted", &phong)
            + &panel("pane", "frosted", [-9.0, 9.0], 0.0, [-9.0, 9.0])
            + &glow("black", [0.0; 3])
            + &format!(
                "cylinder disc {{ material black base {{ 0 40 0 }} top {{ 0 41 0 }} radius {radius} }}"
            );
        let settings = "background { 1 1 1 }".to_owned();
        let shot = Shot { fov: 5e-4, settings, ..Shot::default() };
        let mean = shot.take(&scene).sum(0) / 4096.0;
        let expected = libm::pow(libm::cos(a), n + 1.0);
        assert!((mean - expected).abs() < 4e-3, "sigma {sigma}: {mean}, expected {expected}");
    }
}
