//! The whole reader and writer.

use std::io::{self, Read};

use glam::DVec3;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

use super::{read, write_slo};
use crate::format::FileError;
use crate::mesh::data::Mesh;

const TETRAHEDRON: &str = "slo_mesh 1
vertices { 0 0 0  1 0 0  0 1 0  0 0 1 }
faces { 0 2 1  0 1 3  1 2 3  2 0 3 }
";

/// Hands out a few bytes at a time.
struct Trickle<'a> {
    bytes: &'a [u8],
    step: usize,
}

impl Read for Trickle<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let len = self.step.min(buffer.len());
        self.bytes.read(&mut buffer[..len])
    }
}

fn mesh_of(text: &str) -> Mesh {
    read(&mut text.as_bytes()).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn error_of(text: &str) -> FileError {
    read(&mut text.as_bytes()).expect_err(text)
}

/// A mesh with numbers of every size, whose faces are in range but make no sense.
fn random_mesh(rng: &mut StdRng) -> Mesh {
    let vertices = rng.random_range(3..40);
    let faces = rng.random_range(1..60);
    let uvs = if rng.random() { rng.random_range(1..40) } else { 0 };
    let with_normals: bool = rng.random();
    let mut triples = |count: usize, below: u32| -> Vec<[u32; 3]> {
        (0..count).map(|_| [(); 3].map(|()| rng.random_range(0..below))).collect()
    };
    let faces = triples(faces, vertices);
    let face_uvs = if uvs > 0 { triples(faces.len(), uvs) } else { Vec::new() };
    Mesh {
        positions: (0..vertices)
            .map(|_| DVec3::from_array([(); 3].map(|()| any_f64(rng))))
            .collect(),
        faces,
        normals: (0..if with_normals { vertices } else { 0 })
            .map(|_| [(); 3].map(|()| any_f32(rng)))
            .collect(),
        uvs: (0..uvs).map(|_| [(); 2].map(|()| any_f32(rng))).collect(),
        face_uvs,
        ..Mesh::default()
    }
}

/// A finite number: any bits, or a short decimal.
fn any_f64(rng: &mut StdRng) -> f64 {
    if rng.random() {
        return f64::from(rng.random_range(-999_999..999_999)) / 1000.0;
    }
    loop {
        let number = f64::from_bits(rng.random());
        if number.is_finite() {
            return number;
        }
    }
}

/// As [`any_f64`].
fn any_f32(rng: &mut StdRng) -> f32 {
    loop {
        let number = f32::from_bits(rng.random());
        if number.is_finite() {
            return number;
        }
    }
}

/// The bits of every number, so that -0 is not 0.
fn bits(mesh: &Mesh) -> (Vec<u64>, Vec<u32>) {
    let singles = mesh.normals.iter().flatten().chain(mesh.uvs.iter().flatten());
    (
        mesh.positions.iter().flat_map(|p| p.to_array()).map(f64::to_bits).collect(),
        singles.map(|x| x.to_bits()).collect(),
    )
}

#[test]
fn what_is_written_is_read_again_bit_for_bit() {
    let mut rng = StdRng::seed_from_u64(1);
    for _ in 0..300 {
        let mesh = random_mesh(&mut rng);
        let mut file = Vec::new();
        write_slo(&mesh, &mut file).expect("memory can be written");
        let again = read(&mut file.as_slice()).expect("what was written can be read");
        assert_eq!(again, mesh);
        assert_eq!(bits(&again), bits(&mesh));
    }
}

#[test]
fn numbers_are_written_as_short_as_they_can_be() {
    let p = DVec3::new(1.0, -0.1, 1e300);
    let q = DVec3::new(1e-7, 123456.789, 0.1 + 0.2);
    let mesh = Mesh {
        positions: vec![p, q, DVec3::ZERO],
        faces: vec![[0, 1, 2]],
        uvs: vec![[0.1, 1e-30]],
        face_uvs: vec![[0, 0, 0]],
        ..Mesh::default()
    };
    let mut file = Vec::new();
    write_slo(&mesh, &mut file).expect("memory can be written");
    let expected = "slo_mesh 1\nvertices {\n1 -0.1 1e300\n1e-7 123456.789 0.30000000000000004\n0 0 0\n}\n\
        faces {\n0 1 2\n}\nuvs {\n0.1 1e-30\n}\nface_uvs {\n0 0 0\n}\n";
    assert_eq!(String::from_utf8_lossy(&file), expected);
}

#[test]
fn a_number_that_is_not_finite_is_not_written() {
    let mesh = Mesh { positions: vec![DVec3::NAN], ..Mesh::default() };
    let error = write_slo(&mesh, io::sink()).expect_err("NaN");
    assert_eq!(error.kind(), io::ErrorKind::InvalidData);
}

#[test]
fn sections_come_in_any_order_with_comments_and_without_spaces() {
    let text = "\u{feff}# tetraëdr {}\n/* of \n * four */slo_mesh\t1 faces{0 2 1\r\n0 1 3 # here\n\
        1 2 /**//* } */ 3\x0c 2 0 3}vertices{0 0 0 1 0 0 0 1 0 0 0 1}#end";
    assert_eq!(mesh_of(text), mesh_of(TETRAHEDRON));
}

#[test]
fn uvs_without_face_uvs_belong_to_the_vertices() {
    let mesh = mesh_of(&format!("{TETRAHEDRON} uvs {{ 0 0  1 0  0 1  1 1 }}"));
    assert_eq!(mesh.face_uvs, mesh.faces);
    assert_eq!(mesh.uvs[3], [1.0, 1.0]);
}

#[test]
fn the_size_of_the_pieces_does_not_matter() {
    let mut rng = StdRng::seed_from_u64(2);
    let mut file = Vec::new();
    // Longer than the window, so that words are cut in every way.
    let positions = (0..20_000).map(|_| DVec3::from_array([(); 3].map(|()| any_f64(&mut rng))));
    let mesh = Mesh {
        positions: positions.collect(),
        faces: (0..20_000).map(|i| [i, 7, 8]).collect(),
        ..Mesh::default()
    };
    write_slo(&mesh, &mut file).expect("memory can be written");
    for step in [1000, 4096, 65_537] {
        let again = read(&mut Trickle { bytes: &file, step }).expect("the same file");
        assert_eq!(again, mesh, "{step} bytes at a time");
    }
    let small = TETRAHEDRON.replace("faces", "/* a ** b */ faces # c\n");
    let again = read(&mut Trickle { bytes: small.as_bytes(), step: 1 }).expect("the same file");
    assert_eq!(again, mesh_of(TETRAHEDRON));
}

/// The error as a terminal would show it.
fn shown(error: &FileError) -> String {
    let underline =
        "^".repeat(error.line_text[error.span_start..][..error.span_len].chars().count());
    let before = error.line_text[..error.span_start].chars().count();
    let place = match error.line {
        0 => String::new(),
        line => format!(
            "\n{line}:{} | {}\n    | {}{underline} {}",
            error.column,
            error.line_text,
            " ".repeat(before),
            error.label
        ),
    };
    let help = error.help.iter().map(|help| format!("\nhelp: {help}")).collect::<String>();
    format!("{}{place}{help}", error.message)
}

#[test]
fn errors_say_what_where_and_what_to_write() {
    let faulty = [
        "",
        "ply\nformat ascii 1.0",
        "slo_mesh 2 vertices { }",
        "slo_mesh 1\nvertces { 1 2 3 }",
        "slo_mesh 1\ncolours { 1 2 3 }",
        "slo_mesh 1\n1 2 3",
        "slo_mesh 1 }",
        "slo_mesh 1 vertices 1 2 3",
        "slo_mesh 1 vertices { 1 2 3 } vertices { }",
        "slo_mesh 1\nvertices { 0,5 1 2 }",
        "slo_mesh 1\nvertices { 1,2,3 }",
        "slo_mesh 1\nvertices { 1 2 NaN }",
        "slo_mesh 1\nvertices { 1 2 -inf }",
        "slo_mesh 1\nvertices { 1 2 1e999 }",
        "slo_mesh 1\nvertices { 1 2 žluťoučký }",
        "slo_mesh 1\nvertices { 1 2 3# }",
        "slo_mesh 1\nvertices {\n 1 2 3 4\n}",
        "slo_mesh 1\nvertices {\n 1 2 3\nfaces { 0 1 2 }",
        "slo_mesh 1\nvertices { 1 2 { 3 } }",
        "slo_mesh 1\n\nvertices { 1 2",
        "slo_mesh 1 vertices { /* 1 2 3 }",
        "slo_mesh 1 faces { 0 1 2 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 } faces { 0 1 1 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 }\nfaces { 0 1 2\n  0 1 3 }",
        "slo_mesh 1\nfaces { 0 1 2 0 7 1 1 1 2 } vertices { 0 0 0 1 0 0 0 1 0 }",
        "slo_mesh 1 faces { -1 0 1 }",
        "slo_mesh 1 faces { 0 0.5 1 }",
        "slo_mesh 1 faces { 0 4294967295 1 }",
        "slo_mesh 1 faces { 0 1,2 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }\nnormals { 0 0 1 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }\nuvs { 0 0 0 1 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }\nface_uvs { 0 0 0 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }\nuvs { 1 1 } face_uvs { 0 0 1 }",
        "slo_mesh 1 vertices { 0 0 0 1 0 0 0 1 0 } faces { 0 1 2 }\nface_uvs { 0 0 0 0 0 0 } uvs { 1 1 }",
        "slo_mesh 1 uvs { 0 1e39 }",
    ];
    let shown = faulty.map(|text| format!("---- {text}\n{}\n", shown(&error_of(text)))).concat();
    insta::assert_snapshot!(shown);
}

#[test]
fn a_file_may_end_before_its_version() {
    for text in ["slo_mesh", "slo_mesh  # 1\n"] {
        let error = error_of(text);
        assert_eq!(error.message, "the file ends before the version of the .slo mesh");
        assert_eq!(error.label, "expected `1`");
    }
}

#[test]
fn places_are_right_far_into_a_large_file() {
    let mut text = String::from("slo_mesh 1\nvertices {\n");
    for i in 0..100_000 {
        text.push_str(&format!("{i} 0 1 # ř{i}\n"));
    }
    let error = error_of(&format!("{text}  0 ř 1"));
    assert_eq!((error.line, error.column), (100_003, 5));
    assert_eq!(error.line_text, "  0 ř 1");
    let in_one_line = text.replace('\n', " ").replace('#', "");
    let error = error_of(&in_one_line);
    let column = in_one_line.chars().take_while(|&c| c != 'ř').count() + 1;
    assert_eq!((error.line, error.column), (1, column));
    let late = format!("{text}}} faces {{ 0 1 2 9 100000 8 }}");
    assert_eq!((error_of(&late).line, error_of(&late).column), (100_003, 19));
}

#[test]
fn an_index_is_found_again_when_the_vertices_come_late() {
    let mut text = String::from("slo_mesh 1\nfaces {\n0 1 77\n");
    text.push_str(&"0 1 2\n".repeat(200_000));
    text.push_str("}\nvertices { 0 0 0 1 0 0 0 1 0 }");
    let error = error_of(&text);
    assert_eq!((error.line, error.column), (3, 5));
    assert_eq!(error.line_text, "0 1 77");
    assert_eq!(&error.line_text[error.span_start..][..error.span_len], "77");
    let lost_comment = format!("slo_mesh 1\n  /* {}", "lost ".repeat(200_000));
    let error = error_of(&lost_comment);
    assert_eq!((error.line, error.column), (2, 3));
}

#[test]
fn long_lines_are_shown_in_part() {
    let line = format!("{} ořech {}", "1 ".repeat(500), "2 ".repeat(500));
    let error = error_of(&format!("slo_mesh 1\nvertices {{\n{line}"));
    assert_eq!((error.line, error.column), (3, 1002));
    assert!(error.line_text.starts_with('…') && error.line_text.ends_with('…'));
    assert!(error.line_text.chars().count() < 250, "{}", error.line_text);
    assert_eq!(&error.line_text[error.span_start..][..error.span_len], "ořech");
}

#[test]
fn a_reader_that_fails_is_an_error_with_a_place() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("the disk is gone"))
        }
    }
    let text = "slo_mesh 1\nvertices { 1 2";
    let error = read(&mut text.as_bytes().chain(Failing)).expect_err("fails");
    assert!(error.message.contains("the disk is gone"), "{error}");
    assert_eq!(error.line, 2);
}

#[test]
fn mutated_files_never_panic_and_faults_lie_in_their_excerpt() {
    let mut rng = StdRng::seed_from_u64(4);
    let mut file = Vec::new();
    for round in 0..20_000 {
        if round % 100 == 0 {
            file.clear();
            write_slo(&random_mesh(&mut rng), &mut file).expect("memory can be written");
        }
        let bytes = mutated(&file, &mut rng);
        if let Err(error) = read(&mut bytes.as_slice()) {
            let fault = error.line_text.get(error.span_start..error.span_start + error.span_len);
            assert!(fault.is_some(), "{error:?}");
            assert!(!error.message.is_empty());
        }
    }
}

/// The file with a few bytes changed, taken out, or doubled.
fn mutated(file: &[u8], rng: &mut StdRng) -> Vec<u8> {
    const LIKELY: &[u8] = b" \n{}#/*0123456789.,-+eE\xC5\x99\xFF\0vertices";
    let mut bytes = file.to_vec();
    for _ in 0..rng.random_range(1..5) {
        let at = rng.random_range(0..bytes.len());
        match rng.random_range(0..4) {
            0 => bytes[at] = LIKELY[rng.random_range(0..LIKELY.len())],
            1 => bytes[at] = rng.random(),
            2 => bytes.truncate(at.max(1)),
            _ => {
                let end = (at + rng.random_range(0..30)).min(bytes.len());
                let piece = bytes[at..end].to_vec();
                let to = rng.random_range(0..bytes.len());
                bytes.splice(to..to, piece);
            }
        }
    }
    bytes
}
