//! Files as exporters write them, and broken ones.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::read;
use crate::mesh::data::LoadedMesh;
use crate::mesh::data::Mesh;

fn mesh_of(text: &str, smooth: bool) -> Mesh {
    read(&mut text.as_bytes(), smooth).unwrap_or_else(|e| panic!("{e}\n{text}")).mesh
}

/// The error, with its place if it has one.
fn error_of(text: &str) -> String {
    let error = read(&mut text.as_bytes(), true).expect_err(text);
    if error.line == 0 { error.message } else { error.to_string() }
}

/// Position, uv and normal.
type Corner = ([f64; 3], Option<[f32; 2]>, Option<[f32; 3]>);

/// The corners of every triangle with all that belongs to them, whatever their indices.
fn corners(mesh: &Mesh) -> Vec<[Corner; 3]> {
    (0..mesh.faces.len())
        .map(|face| {
            [0, 1, 2].map(|corner| {
                let vertex = mesh.faces[face][corner] as usize;
                let uv = mesh.face_uvs.get(face).map(|uvs| mesh.uvs[uvs[corner] as usize]);
                let normal = mesh.normals.get(vertex).copied();
                (mesh.positions[vertex].to_array(), uv, normal)
            })
        })
        .collect()
}

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn polygons_become_fans_and_negative_indices_count_back() {
    let by_number = mesh_of(&format!("{QUAD}f 1 2 3 4\n"), false);
    assert_eq!(by_number.faces, [[0, 1, 2], [0, 2, 3]]);
    let backwards = mesh_of(&format!("{QUAD}f -4 -3 -2 -1\n"), false);
    assert_eq!(backwards, by_number);
    let pentagon = mesh_of(&format!("{QUAD}v 0.5 2 0\nf 1 2 3 5 4\n"), false);
    assert_eq!(pentagon.faces.len(), 3);
    let faces_first = mesh_of(&format!("f 1 2 3 4\n{QUAD}"), false);
    assert_eq!(faces_first, by_number);
}

#[test]
fn groups_materials_and_other_statements_do_not_matter() {
    let plain = mesh_of(&format!("{QUAD}f 1 2 3\nf 1 3 4\n"), false);
    let decorated = "# made by hand \\\nmtllib missing.mtl\no čtverec\nv 0 0 0 # corner\n\
        v 1 0 0 1\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0 0.5 0.5 0.5 1\nvp 1 2\ns off\nusemtl red\n\
        l 1 2 3\np 1\nf 1 2 \\\r\n3\ng second\nusemtl\nf 1 3 4 # last";
    assert_eq!(mesh_of(decorated, false), plain);
    let in_latin_2 = [b"o \xE8tverec\n".as_slice(), QUAD.as_bytes(), b"f 1 2 3\nf 1 3 4"].concat();
    assert_eq!(read(&mut in_latin_2.as_slice(), false).map(|loaded| loaded.mesh), Ok(plain));
}

#[test]
fn positions_keep_the_precision_of_f64() {
    let mesh = mesh_of("v 1000000.001 0 0.1\nv 1 0 0\nv 0 1 0\nf 1 2 3", false);
    assert_eq!(mesh.positions[0].to_array(), [1000000.001, 0.0, 0.1]);
}

#[test]
fn uv_seams_leave_vertices_shared() {
    let text =
        format!("{QUAD}vt 0 0\nvt 1\nvt 1 1\nvt 0 1 0\nvt 0.5 0.5\nf 1/1 2/2 3/3\nf 1/5 3/3 4/4\n");
    let mesh = mesh_of(&text, true);
    assert_eq!(mesh.positions.len(), 4);
    let uvs: Vec<_> =
        corners(&mesh).iter().map(|f| f.map(|(_, uv, _)| uv.expect("a uv"))).collect();
    assert_eq!(uvs, [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.5, 0.5], [1.0, 1.0], [0.0, 1.0]]]);
}

#[test]
fn several_normals_split_a_vertex() {
    let normals = "vn 0 0 1\nvn 0 1 0\nvn 0 0 5\n";
    let hard = format!("{QUAD}{normals}f 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
    let mesh = mesh_of(&hard, true);
    assert_eq!((mesh.positions.len(), mesh.normals.len()), (6, 6));
    for (face, normal) in corners(&mesh).iter().zip([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]) {
        assert!(face.iter().all(|corner| corner.2 == Some(normal)));
    }
    // The same direction under another index does not split, and neither does a flat mesh.
    let soft = format!("{QUAD}{normals}f 1//1 2//1 3//1\nf 1//3 3//3 4//3\n");
    assert_eq!(mesh_of(&soft, true).positions.len(), 4);
    assert_eq!(mesh_of(&hard, false).positions.len(), 4);
    assert!(mesh_of(&hard, false).normals.is_empty());
}

#[test]
fn faces_without_uvs_or_normals_may_stand_beside_others() {
    let text = format!("{QUAD}vt 1 1\nvn 0 1 0\nf 1/1/1 2/1/1 3/1/1\nf 1 3/1 4//1\n");
    let mesh = mesh_of(&text, true);
    let faces = corners(&mesh);
    assert!(faces[0].iter().all(|c| c.1 == Some([1.0, 1.0]) && c.2 == Some([0.0, 1.0, 0.0])));
    // No normal is zero: the loader computes one for it.
    assert!(faces[1].iter().all(|c| c.1 == Some([0.0, 0.0]) && c.2 == Some([0.0; 3])));
}

/// Random faces over random vertices, uvs and normals come back corner by corner.
#[test]
fn corners_survive_whatever_they_share() {
    let mut rng = StdRng::seed_from_u64(8);
    for _ in 0..300 {
        let counts = [rng.random_range(3..12), rng.random_range(1..12), rng.random_range(1..6)];
        let number = |rng: &mut StdRng| f64::from(rng.random_range(-50..50)) / 8.0;
        let mut text = String::new();
        let mut point = |name: &str, count: usize, size: usize| -> Vec<Vec<f64>> {
            let points = (0..count).map(|_| (0..size).map(|_| number(&mut rng)).collect());
            let points: Vec<Vec<f64>> = points.collect();
            for p in &points {
                let words: Vec<_> = p.iter().map(f64::to_string).collect();
                text.push_str(&format!("{name} {}\n", words.join(" ")));
            }
            points
        };
        let vertices = point("v", counts[0], 3);
        let uvs = point("vt", counts[1], 2);
        let axes = ["1 0 0", "0 1 0", "0 0 1", "-1 0 0", "0 -1 0"];
        for i in 0..counts[2] {
            text.push_str(&format!("vn {}\n", axes[i % 5]));
        }
        let mut expected = Vec::new();
        for _ in 0..rng.random_range(1..20) {
            let corner = [(); 3].map(|()| counts.map(|count| rng.random_range(0..count)));
            let words = corner.map(|[v, t, n]| {
                let back = counts[1] - t;
                format!("{}/-{back}/{}", v + 1, n + 1)
            });
            text.push_str(&format!("f {}\n", words.join(" ")));
            expected.push(corner.map(|[v, t, n]| {
                let normal: Vec<f32> =
                    axes[n % 5].split(' ').map(|w| w.parse().expect("a number")).collect();
                (
                    [vertices[v][0], vertices[v][1], vertices[v][2]],
                    Some([uvs[t][0] as f32, uvs[t][1] as f32]),
                    Some([normal[0], normal[1], normal[2]]),
                )
            }));
        }
        assert_eq!(corners(&mesh_of(&text, true)), expected, "{text}");
    }
}

#[test]
fn faults_have_places() {
    let after_quad = |line: &str| error_of(&format!("{QUAD}{line}\nf 1 2 3\n"));
    assert_eq!(error_of("# nothing\n"), "the mesh has no faces");
    assert_eq!(error_of(QUAD), "the mesh has no faces");
    assert_eq!(after_quad("f 1 2 7"), "5:7: a face refers to vertex 7, but there are 4 vertices");
    assert_eq!(after_quad("f 1 2 0"), "5:7: there is no vertex 0, the first one is 1");
    assert_eq!(
        after_quad("f 1 -5 3"),
        "5:5: vertex -5 is too far back: there are 4 vertices so far"
    );
    assert_eq!(
        after_quad("vt 0 0\nf 1/2 2/1 3/1"),
        "6:3: a face refers to uv 2, but there is 1 uv"
    );
    assert_eq!(
        after_quad("vn 0 0 1\nvn 0 0 1\nf 1//9 2//9 3//9"),
        "7:3: a face refers to normal 9, but there are 2 normals"
    );
    assert_eq!(
        after_quad("f 1//-1 2 3\nvn 0 0 1"),
        "5:3: normal -1 is too far back: there are no normals so far"
    );
    assert_eq!(after_quad("f 1 2 x"), "5:7: `x` is not the index of a vertex");
    assert_eq!(after_quad("f 1 2 /1"), "5:7: `` is not the index of a vertex");
    assert_eq!(after_quad("f 1 2 1/2/3/4"), "5:7: `1/2/3/4` has more parts than vertex/uv/normal");
    assert_eq!(
        after_quad("f 1 2 99999999999999999999"),
        "5:7: `99999999999999999999` is not the index of a vertex"
    );
    assert_eq!(after_quad("v 1 2"), "5:6: a vertex has 3 numbers or more, this one has 2");
    assert_eq!(after_quad("  v 1 nan 3\nf 1 2 5"), "5:7: `nan` is not a finite number");
    assert_eq!(after_quad("f 1 2 5\nv 1 1e999 3"), "6:5: the number `1e999` is too large");
    assert_eq!(after_quad("v 1 2,5 3"), "5:5: `2,5` is not a number: the decimal sign is a point");
    assert_eq!(after_quad("v 1 2 3 0"), "5:9: a vertex can't have the weight 0");
    assert_eq!(after_quad("vn 1 \\\n 2 z"), "6:4: `z` is not a number");
}

fn warnings_of(text: &str, smooth: bool) -> Vec<String> {
    read(&mut text.as_bytes(), smooth).unwrap_or_else(|e| panic!("{e}\n{text}")).warnings
}

#[test]
fn what_shows_and_is_left_out_is_named_once() {
    let plain = format!("o a\ng b c\ns 1\n{QUAD}f 1 2 3 # usemtl\n");
    assert_eq!(warnings_of(&plain, true), [""; 0]);
    let with = |more: &str| warnings_of(&format!("{more}\n{plain}{more}\n"), true);
    assert_eq!(with("mtllib a.mtl\nusemtl red"), ["left out: materials (`mtllib a.mtl`)"]);
    assert_eq!(with("usemtl red"), ["left out: materials (`usemtl red`)"]);
    assert_eq!(with("v 0 0 0 1 0 0"), ["left out: colours of vertices"]);
    assert_eq!(with("vp 0 0\ncurv2 1 2"), ["left out: free-form curves and surfaces"]);
    let many = ["left out: materials (`usemtl a`), 4 lines and 2 points"];
    assert_eq!(with("usemtl a\nl 1 2\nl 2 3\np 1"), many);
    let unknown = ["left out: statements of an unknown kind (the first is `vertex` in line 1)"];
    assert_eq!(with("vertex 1 2 3"), unknown);
}

#[test]
fn references_to_what_no_file_has_are_left_out() {
    let whole = mesh_of(&format!("{QUAD}f 1 2 3\n"), true);
    let cases = [
        ("f 1//1 2//2 3//3", "normals"),
        ("f 1//-1 2//-1 3//-1", "normals"),
        ("f 1/1 2/2 3/3", "uvs"),
        ("f 1/-1 2/-2 3/-3", "uvs"),
    ];
    for (face, what) in cases {
        let text = format!("{QUAD}{face}\n");
        assert_eq!(mesh_of(&text, true), whole, "{face}");
        let warning =
            format!("faces refer to {what}, but the file has none (the first is in line 5)");
        assert_eq!(warnings_of(&text, true), [warning], "{face}");
    }
    assert_eq!(warnings_of(&format!("{QUAD}f 1/1/1 2/2/2 3/3/3\n"), false).len(), 2);
}

#[test]
fn faces_without_an_inside_are_left_out() {
    let one = "1 face has fewer than 3 corners and was left out (in line 5)";
    assert_eq!(warnings_of(&format!("{QUAD}f 1 2\nf 1 2 3\n"), false), [one]);
    let two = "2 faces have fewer than 3 corners and were left out (the first is in line 6)";
    assert_eq!(warnings_of(&format!("{QUAD}f 1 2 3\nf 1\nf\n"), false), [two]);
    assert_eq!(error_of(&format!("{QUAD}f 1 2\n")), "the mesh has no faces");
    assert_eq!(
        error_of(&format!("{QUAD}f 1 9\nf 1 2 3\n")),
        "5:5: a face refers to vertex 9, but there are 4 vertices"
    );
}

#[test]
fn numbers_that_nothing_uses_may_be_anything() {
    let whole = mesh_of(&format!("{QUAD}f 1 2 3\n"), true);
    for word in ["nan", "-nan(ind)", "-1.#IND00", "1.#QNAN", "1.#INF", "inf", "1e999"] {
        let lone = format!("v {word} 0 0\nvt {word}\nvn 0 {word} 1\n{QUAD}f 2 3 4\n");
        assert_eq!(mesh_of(&lone, true), whole, "{word}");
        assert_eq!(warnings_of(&lone, true), [""; 0], "{word}");
        let normals = format!("{QUAD}vn {word} 0 1 # x\nf 1//1 2//1 3//1\n");
        assert_eq!(mesh_of(&normals, false), mesh_of(&format!("{QUAD}f 1 2 3"), false), "{word}");
        assert_eq!(warnings_of(&normals, false), [""; 0], "{word}");
        let computed = "3 normals are not finite: they are computed instead";
        assert_eq!(warnings_of(&normals, true), [computed], "{word}");
        let uv = format!("{QUAD}vt {word} 1\nf 1/1 2/1 3/1\n");
        assert_eq!(mesh_of(&uv, true).uvs, [[0.0; 2]], "{word}");
        assert_eq!(warnings_of(&uv, true), ["1 uv is not finite and counts as 0 0"], "{word}");
    }
    let commented =
        QUAD.replace("0 1 0\n", "0 1 0#IND\n").replace("1 1 0\n", "1 1 0.#c\n") + "f 1 2 3";
    assert_eq!(mesh_of(&commented, true), whole);
}

/// Bytes are looked at a bounded number of times, however many lines are joined.
#[test]
fn joined_lines_take_linear_time() {
    let joined = |lines: usize| format!("{QUAD}f 1 2 3 {}\n", "\\\n".repeat(lines));
    assert_eq!(mesh_of(&joined(1_000_000), false), mesh_of(&joined(0), false));
    let forward = format!("f{}\n{QUAD}", " 1 2 \\\n 3 4".repeat(100_000));
    assert_eq!(mesh_of(&forward, false).faces.len(), 400_000 - 2);
    let numbers: String = (1..=300_000).map(|i| format!(" {i}")).collect();
    assert!(error_of(&format!("f{numbers}\n{QUAD}")).contains("a face refers to vertex 300000"));
    let endless = "f 1 \\\n".repeat(3 << 20);
    assert_eq!(error_of(&endless), "1:1: a line of more than 16777216 bytes");
}

#[test]
fn mutated_files_never_panic() {
    const LIKELY: &[u8] = b" \n\r\\/#-0123456789.vtnfeE\xFF";
    let whole =
        format!("{QUAD}vt 0 0\nvt 1 0\nvn 0 0 1\nvn 0 1 0\nf 1/1/1 2/2/1 3/-1/-1 4//2\nf 1 2 -3\n");
    let mut rng = StdRng::seed_from_u64(7);
    let mut read_well = 0;
    for _ in 0..30_000 {
        let mut bytes = whole.clone().into_bytes();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..3) {
                0 => bytes[at] = LIKELY[rng.random_range(0..LIKELY.len())],
                1 => bytes.insert(at, LIKELY[rng.random_range(0..LIKELY.len())]),
                _ => bytes.truncate(at.max(1)),
            }
        }
        match read(&mut bytes.as_slice(), true) {
            Ok(LoadedMesh { mesh, .. }) => {
                read_well += 1;
                let vertices = mesh.positions.len() as u32;
                assert!(mesh.faces.iter().flatten().all(|&i| i < vertices));
                assert!(mesh.face_uvs.iter().flatten().all(|&i| (i as usize) < mesh.uvs.len()));
            }
            Err(error) => assert!(error.line_text.get(error.span_start..).is_some()),
        }
    }
    assert!(read_well > 1000, "only {read_well} files survived");
}
