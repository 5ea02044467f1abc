//! Files of every encoding, written here.

use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::read;
use crate::format::FileError;
use crate::mesh::data::LoadedMesh;
use crate::mesh::data::Mesh;

/// A quad and a triangle with everything that is read, and some things that are not.
const ASCII: &str = "ply
format ascii 1.0
comment žluťoučký kůň
obj_info made by hand
element vertex 5
property float x
property double y
property float z
property uchar red
property float s
property float t
property list uchar float weights
property float nx
property float ny
property float nz
element face 2
property list uchar int vertex_indices
property short group
element edge 1
property int vertex1
property int vertex2
end_header
0 0 0  255 0 0 0  0 0 1
1 0 0  255 1 0 1 0.5  0 0 1
1 1 0  255 1 1 2 0.5 nan  0 0 1
0 1 0  255 0 1 0  0 0 1
0.5 0.5 1e0  0 .5 .5 0  0 0 2
4 0 1 2 3 7
3 0 1 4 -1
0 1
";

fn mesh_of(bytes: &[u8]) -> Mesh {
    read(&mut &*bytes, true).unwrap_or_else(|e| panic!("{e}")).mesh
}

/// The error, with its place if it has one.
fn error_of(text: &str) -> String {
    let FileError { line, column, message, .. } = read(&mut text.as_bytes(), true).expect_err(text);
    if line > 0 { format!("{line}:{column}: {message}") } else { message }
}

/// The same file in binary.
fn binary(little: bool) -> Vec<u8> {
    let (header, body) = ASCII.split_once("end_header\n").expect("the end of the header");
    let name = if little { "binary_little_endian" } else { "binary_big_endian" };
    let mut bytes = header.replace("ascii", name).into_bytes();
    bytes.extend(b"end_header\n");
    let mut push = |size: usize, integer: bool, word: &str| {
        let value: f64 = word.parse().expect("a number");
        let bits = match (size, integer) {
            (_, true) => value as i64 as u64,
            (4, _) => u64::from((value as f32).to_bits()),
            _ => value.to_bits(),
        };
        let number = &bits.to_le_bytes()[..size];
        if little { bytes.extend(number) } else { bytes.extend(number.iter().rev()) }
    };
    for line in body.lines() {
        let words: Vec<_> = line.split_ascii_whitespace().collect();
        for (i, word) in words.iter().enumerate() {
            match (words.len(), i) {
                (10.., 1) => push(8, false, word),
                (10.., 3 | 6) => push(1, true, word),
                (10.., _) => push(4, false, word),
                (5 | 6, 0) => push(1, true, word),
                (5 | 6, i) if i + 1 == words.len() => push(2, true, word),
                _ => push(4, true, word),
            }
        }
    }
    bytes
}

#[test]
fn ascii_and_both_byte_orders_give_the_same_mesh() {
    let mesh = mesh_of(ASCII.as_bytes());
    assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [0, 1, 4]]);
    assert_eq!(mesh.positions[4].to_array(), [0.5, 0.5, 1.0]);
    assert_eq!(mesh.normals[4], [0.0, 0.0, 2.0]);
    assert_eq!(mesh.uvs[2], [1.0, 1.0]);
    assert_eq!(mesh.face_uvs, mesh.faces);
    assert_eq!(mesh_of(&binary(true)), mesh);
    assert_eq!(mesh_of(&binary(false)), mesh);
    assert_eq!(mesh_of(ASCII.replace('\n', "\r\n").as_bytes()), mesh);
}

#[test]
fn faults_of_text_have_places() {
    let faulty = |from: &str, to: &str| error_of(&ASCII.replace(from, to));
    assert_eq!(
        faulty("3 0 1 4 -1", "3 0 1 5 -1"),
        "29:7: `vertex_indices` of face 1 refers to vertex 5, but there are 5 vertices, from 0 on"
    );
    assert_eq!(faulty("0.5 0.5 1e0", "0.5 0,5 1e0"), "27:5: `y` of vertex 4 is not a number");
    for word in ["nan", "-inf", "-1.#IND00", "1e999"] {
        let line = format!("0.5 {word} 1e0");
        assert_eq!(faulty("0.5 0.5 1e0", &line), "27:5: `y` of vertex 4 is not finite", "{word}");
    }
    let cut = &ASCII[..ASCII.len() - 3];
    assert_eq!(error_of(cut), "30:2: the file ends before `vertex2` of edge 0");
    let cut = &ASCII[..ASCII.find("1e0").expect("1e0")];
    assert_eq!(error_of(cut), "27:9: the file ends before `z` of vertex 4");
}

#[test]
fn faults_of_headers_have_places() {
    let faulty = |from: &str, to: &str| error_of(&ASCII.replace(from, to));
    assert_eq!(error_of("plyr\n"), "this is not a .ply file: its first line is not `ply`");
    assert_eq!(error_of(""), "this is not a .ply file: its first line is not `ply`");
    assert_eq!(faulty("ascii 1.0", "ascii 2.0"), "2:1: the header of a .ply file has no such line");
    assert_eq!(faulty("ascii", "text"), "2:1: `text` is no known format of a .ply file");
    assert_eq!(
        faulty("format ascii 1.0\n", ""),
        "21:1: the header ends without a line `format ascii 1.0` or the like"
    );
    assert_eq!(faulty("vertex 5", "vertex five"), "5:1: `five` is no number of elements");
    assert_eq!(faulty("double y", "decimal y"), "7:1: `decimal` is no type of a property");
    assert_eq!(faulty("double y", "double x"), "7:1: the property `x` is there twice");
    assert_eq!(faulty("double y", "double w"), "a vertex has no property `y`");
    assert_eq!(
        faulty("uchar int vertex_indices", "float int vertex_indices"),
        "17:1: the length of a list must have an integer type"
    );
    assert_eq!(faulty("vertex_indices", "indices"), "a face has no list `vertex_indices`");
    assert_eq!(faulty("element face", "element strip"), "the mesh has no element `face`");
    assert_eq!(faulty("element edge", "element face"), "the element `face` is there twice");
    assert_eq!(faulty("end_header\n", ""), "22:1: the header of a .ply file has no such line");
    assert_eq!(
        error_of("ply\nformat ascii 1.0\nelement vertex 3"),
        "3:1: the file ends inside of its header"
    );
    let many = "ply\nformat ascii 1.0\nelement vertex 4294967295\n";
    assert_eq!(error_of(many), "3:1: 4294967295 is more than 32-bit indices can count");
}

#[test]
fn faults_of_binary_files_name_the_item() {
    let mut bytes = binary(true);
    let y = bytes.windows(8).position(|w| w == 0.5_f64.to_le_bytes()).expect("y of vertex 4");
    bytes[y..y + 8].copy_from_slice(&f64::NAN.to_le_bytes());
    let error = read(&mut bytes.as_slice(), true).expect_err("NaN");
    assert_eq!(error.message, "`y` of vertex 4 is not finite");
    let cut = &binary(false)[..binary(false).len() - 1];
    let error = read(&mut &*cut, true).expect_err("cut");
    assert_eq!(error.message, "the file ends before `vertex2` of edge 0");
}

fn warnings_of(text: &str, smooth: bool) -> Vec<String> {
    read(&mut text.as_bytes(), smooth).unwrap_or_else(|e| panic!("{e}\n{text}")).warnings
}

const LEFT_OUT: &str = "left out: colours of vertices and the element `edge`";

#[test]
fn numbers_that_nothing_uses_may_be_anything() {
    let mut bytes = binary(true);
    let nz = bytes.windows(4).position(|w| w == 2.0_f32.to_le_bytes()).expect("the last normal");
    bytes[nz..nz + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let computed = "1 normal is not finite: it is computed instead";
    let smooth = read(&mut bytes.as_slice(), true).expect("a mesh");
    assert_eq!(smooth.warnings, [LEFT_OUT, computed]);
    assert_eq!(smooth.mesh.normals[4], [0.0; 3]);
    assert_eq!(read(&mut bytes.as_slice(), false).expect("a mesh").warnings, [LEFT_OUT]);
    for word in ["nan", "1.#QNAN", "-1.#IND00", "inf", "1e39"] {
        let normal = ASCII.replace("0 0 2\n", &format!("0 0 {word}\n"));
        assert_eq!(warnings_of(&normal, true), [LEFT_OUT, computed], "{word}");
        let uv = ASCII.replace(".5 .5 0  0 0 2", &format!(".5 {word} 0  0 0 2"));
        let expected = "1 uv is not finite and counts as 0 0";
        assert_eq!(warnings_of(&uv, true), [LEFT_OUT, expected], "{word}");
    }
    let lone = ASCII.replace("0.5 0.5 1e0", "0.5 nan 1e0").replace("3 0 1 4", "3 0 1 2");
    assert_eq!(warnings_of(&lone, true), [LEFT_OUT]);
}

#[test]
fn faces_without_an_inside_are_left_out() {
    let small = ASCII.replace("3 0 1 4 -1", "2 0 1 -1");
    let expected = "1 face has fewer than 3 corners and was left out (face 1)";
    assert_eq!(warnings_of(&small, true), [expected, LEFT_OUT]);
    let smaller = small.replace("4 0 1 2 3 7", "0 7");
    assert_eq!(error_of(&smaller), "the mesh has no faces");
}

#[test]
fn what_shows_and_is_left_out_is_named() {
    let plain = ASCII.replace("uchar red", "float confidence").replace("edge 1", "edge 0");
    let plain = plain.strip_suffix("0 1\n").expect("an edge");
    assert_eq!(warnings_of(plain, true), [""; 0]);
    let textured = plain.replace("comment ", "comment TextureFile skin 1.jpg\ncomment ");
    assert_eq!(warnings_of(&textured, true), ["left out: the texture `skin 1.jpg`"]);
}

/// Two triangles whose corners have texture coordinates of their own, as MeshLab writes them.
const CORNER_UVS: &str = "ply
format ascii 1.0
comment VCGLIB generated
element vertex 4
property float x
property float y
property float z
element face 2
property list uchar int vertex_indices
property list uchar float texcoord
property int texnumber
end_header
0 0 0
1 0 0
1 1 0
0 1 0
3 0 1 2 6 0 0 1 0 1 1 0
3 0 2 3 6 .5 .5 .25 .25 0 .75 0
";

#[test]
fn corners_of_faces_have_their_own_uvs() {
    let uvs = |text: &str| {
        let mesh = mesh_of(text.as_bytes());
        let uv = |i: u32| mesh.uvs[i as usize];
        mesh.face_uvs.iter().map(|face| face.map(uv)).collect::<Vec<_>>()
    };
    let first = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert_eq!(uvs(CORNER_UVS), [first, [[0.5, 0.5], [0.25, 0.25], [0.0, 0.75]]]);
    // A face without any.
    let without = CORNER_UVS.replace("6 .5 .5 .25 .25 0 .75", "0");
    assert_eq!(uvs(&without), [first, [[0.0; 2]; 3]]);
    // The uvs of vertices are for faces that have none of their own.
    let both = without
        .replace("float z", "float z\nproperty float u\nproperty float v")
        .replace("0 0 0\n", "0 0 0 .1 .1\n")
        .replace("1 0 0\n", "1 0 0 .2 .2\n")
        .replace("\n1 1 0\n", "\n1 1 0 .3 .3\n")
        .replace("\n0 1 0\n", "\n0 1 0 .4 .4\n");
    assert_eq!(uvs(&both), [first, [[0.1, 0.1], [0.3, 0.3], [0.4, 0.4]]]);
    // A polygon with an inner corner keeps each uv at its corner.
    let arrow = CORNER_UVS.replace("face 2", "face 1").replace("\n1 1 0\n", "\n.2 .2 0\n").replace(
        "3 0 1 2 6 0 0 1 0 1 1 0\n3 0 2 3 6 .5 .5 .25 .25 0 .75 0",
        "4 1 2 3 0 8 1 0 .2 .2 0 1 0 0 0",
    );
    let mesh = mesh_of(arrow.as_bytes());
    assert_eq!(mesh.faces.len(), 2);
    for (face, uvs) in mesh.faces.iter().zip(&mesh.face_uvs) {
        for (&vertex, &uv) in face.iter().zip(uvs) {
            let position = mesh.positions[vertex as usize].as_vec3();
            assert_eq!(mesh.uvs[uv as usize], [position.x, position.y]);
        }
    }
}

#[test]
fn a_header_of_many_properties_is_refused_soon() {
    let mut text = String::from("ply\nformat ascii 1.0\nelement vertex 3\n");
    (0..5000).for_each(|i| text.push_str(&format!("property float p{i}\n")));
    assert_eq!(error_of(&text), "4099:1: more than 4096 elements and properties");
}

/// The lines of the header end as its first one does, whatever the bytes behind it are.
#[test]
fn headers_of_binary_files_may_have_old_line_ends() {
    let bytes = binary(true);
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header: Vec<u8> =
        bytes[..end].iter().map(|&b| if b == b'\n' { b'\r' } else { b }).collect();
    let old = [&header, &bytes[end..]].concat();
    assert_eq!(mesh_of(&old), mesh_of(&bytes));
}

#[test]
fn a_count_on_paper_takes_no_memory_and_no_time() {
    let huge = "ply\nformat binary_little_endian 1.0\nelement nothing 18446744073709551615\n\
        element vertex 4294967294\nproperty float x\nproperty float y\nproperty float z\n\
        element face 4294967294\nproperty list uint uint vertex_index\nend_header\n";
    assert_eq!(error_of(huge), "the file ends before `x` of vertex 0");
}

#[test]
fn mutated_files_never_panic() {
    let mut rng = StdRng::seed_from_u64(6);
    let files = [ASCII.as_bytes().to_vec(), binary(true), binary(false)];
    let mut read_well = 0;
    for round in 0..30_000 {
        let mut bytes = files[round % 3].clone();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(0..bytes.len());
            match rng.random_range(0..3) {
                0 => bytes[at] = rng.random(),
                1 => bytes[at] ^= 1 << rng.random_range(0..8),
                _ => bytes.truncate(at.max(1)),
            }
        }
        match read(&mut bytes.as_slice(), true) {
            Ok(LoadedMesh { mesh, .. }) => {
                read_well += 1;
                let vertices = mesh.positions.len() as u32;
                assert!(mesh.faces.iter().flatten().all(|&i| i < vertices));
            }
            Err(error) => assert!(error.line_text.get(error.span_start..).is_some()),
        }
    }
    assert!(read_well > 1000, "only {read_well} files survived");
}
