//! Open Inventor.

use glam::DVec3;
use slo_scene::Shape;

use super::{refused, says, scene_of};

fn iv(text: &str) -> (crate::Imported, slo_scene::SceneDescription) {
    scene_of(&[("a.iv", &format!("#Inventor V2.1 ascii\n\n{text}"))])
}

/// A quad in the plane z = 0, and the point that follows it.
const QUAD: &str = "Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 2 0, ] }";

#[test]
fn separators_restore_what_they_change() {
    let text = "Separator {\n Transform { translation 1 2 3 rotation 0 0 1 1.57079632679 scaleFactor 2 2 2 }\n\
                BaseColor { rgb 1 0 0 } DEF ball+3 Sphere { radius 2 }\n\
                TransformSeparator { Translation { translation 5 0 0 } Material { diffuseColor 0 1 0 } }\n\
                Cube { width 1 } }\n Cone { bottomRadius 3 } Group { Scale { scaleFactor 1 1 4 } } USE ball+3";
    let (imported, scene) = iv(text);
    assert_eq!((imported.shapes, imported.materials), ((0, 4), 3));
    assert_eq!(scene.objects.len(), 4);
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    assert_eq!(imported.made_up, ["a camera that sees everything", "a light at the camera"]);
    says(
        &imported,
        "group a {  addKframe { time 0  key { pivot { 0 0 0 }  turn { axis { 1 0 0 } angle_deg 90 } } } }",
    );
    says(
        &imported,
        "pivot { 1 2 3 }  turn { axis { 0 0 1 } angle_deg 90 }  scale { 2 2 2 } } }  parent a }",
    );
    says(&imported, "sphere ball { center { 0 0 0 }  radius 2  material material  parent ");
    says(&imported, "diffuse { 1 0 0 }");
    says(
        &imported,
        "box cube { vertex0 { -0.5 -1 -1 }  vertex1 { 0.5 -1 -1 }  vertex2 { 0.5 1 -1 }  height 2  material material_2",
    );
    says(&imported, "cone cone { base { 0 -1 0 }  apex { 0 1 0 }  radius 3  material material_3");
    says(
        &imported,
        "sphere ball_2 { center { 0 0 0 }  radius 2  material material_3  addKframe { time 0  key { pivot { 0 0 0 }  scale { 1 1 4 } } }",
    );
}

#[test]
fn faces_share_points_and_have_materials() {
    let text = format!(
        "{QUAD} Material {{ diffuseColor [ 1 0 0, 0 1 0 ] transparency .5 }} MaterialBinding {{ value PER_FACE_INDEXED }}\n\
         IndexedFaceSet {{ coordIndex [ 0, 1, 2, 3, -1, 3, 2, 4, -1, 0, 1, -1, 0, 2, 9 ] materialIndex [ 1, 0, 0, 0 ] }}"
    );
    let (imported, scene) = iv(&text);
    assert_eq!(imported.shapes, (3, 0));
    assert_eq!(imported.left_out, ["a face of points that do not exist"]);
    assert_eq!((scene.objects.len(), scene.materials.len()), (2, 2));
    says(
        &imported,
        "phong_info material { ambient { 0.02 0.02 0.02 }  diffuse { 0 0.5 0 }  refraction 0.5 }",
    );
    says(&imported, "diffuse { 0.5 0 0 }  refraction 0.5 }");
    says(&imported, "shadow TRANSPARENT");
}

#[test]
fn strips_turn_every_second_triangle() {
    let text = "IndexedTriangleStripSet { vertexProperty VertexProperty { vertex [ 0 0 0, 1 0 0, 0 1 0, 1 1 0 ] \
                normal [ 0 0 1, 0 1 0 ] normalBinding PER_PART orderedRGBA [ 0xff0000ff, 0x00ff00ff ] materialBinding PER_FACE }\n\
                coordIndex [ 0, 1, 2, 3, -1 ] }";
    let (imported, scene) = iv(text);
    assert_eq!((imported.shapes, scene.objects.len()), ((2, 0), 2));
    for object in &scene.objects {
        let Shape::Mesh(mesh) = &object.shape else { panic!() };
        let [a, b, c] = mesh.mesh.faces[0].map(|corner| mesh.mesh.positions[corner as usize]);
        assert_eq!((b - a).cross(c - a), DVec3::Z);
        assert_eq!((mesh.smooth, mesh.mesh.normals[0]), (true, [0.0, 0.0, 1.0]));
    }
    let text = format!(
        "{QUAD} ShapeHints {{ vertexOrdering CLOCKWISE }} TriangleStripSet {{ numVertices [ 3 ] startIndex 1 }} FaceSet {{ numVertices 4 }}"
    );
    let (imported, scene) = iv(&text);
    assert_eq!((imported.shapes, scene.objects.len()), ((3, 0), 2));
    let Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!() };
    let [a, b, c] = mesh.mesh.faces[0].map(|corner| mesh.mesh.positions[corner as usize]);
    assert_eq!((b - a).cross(c - a).normalize(), DVec3::NEG_Z);
}

#[test]
fn edges_are_smooth_below_the_crease_angle() {
    // Two quads that meet at a right angle.
    let shape = "Coordinate3 { point [ 0 0 0, 1 0 0, 1 1 0, 0 1 0, 0 0 1, 0 1 1 ] }\n\
                 IndexedFaceSet { coordIndex [ 0 1 2 3 -1 0 3 5 4 -1 ] }";
    let normals = |angle: &str| {
        let (_, scene) = iv(&format!("ShapeHints {{ creaseAngle {angle} }} {shape}"));
        let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
        (mesh.smooth, mesh.mesh.positions.len())
    };
    assert_eq!((normals("0").0, normals("1.5"), normals("1.6")), (false, (true, 8), (true, 6)));
}

#[test]
fn quads_of_a_mesh_run_along_rows() {
    let points: Vec<String> = (0..12).map(|i| format!("{} -{} 0", i % 4, i / 4)).collect();
    let text = format!(
        "Coordinate3 {{ point [ {} ] }} NormalBinding {{ value PER_VERTEX }} Normal {{ vector [ {} ] }}\n\
         QuadMesh {{ verticesPerColumn 3 verticesPerRow 4 }}",
        points.join(", "),
        "0 0 2 ".repeat(12)
    );
    let (imported, scene) = iv(&text);
    assert_eq!(imported.shapes, (12, 0));
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    for face in &mesh.mesh.faces {
        let [a, b, c] = face.map(|corner| mesh.mesh.positions[corner as usize]);
        assert_eq!((b - a).cross(c - a), DVec3::Z);
    }
}

#[test]
fn switches_arrays_and_copies() {
    let shapes = "Sphere { radius 1 } Sphere { radius 2 } Sphere { radius 3 }";
    let count = |text: &str| iv(&format!("Cube {{ }} {text}")).1.objects.len() - 1;
    assert_eq!(count(&format!("Switch {{ {shapes} }}")), 0);
    assert_eq!(count(&format!("Switch {{ whichChild 1 {shapes} }}")), 1);
    assert_eq!(count(&format!("Switch {{ whichChild -3 {shapes} }}")), 3);
    assert_eq!(
        count(&format!(
            "Switch {{ whichChild 1 Label {{ }} Switch {{ whichChild -2 {shapes} }} }}"
        )),
        1
    );
    assert_eq!(
        count(&format!("LOD {{ range [ 5, 9 ] {shapes} }} LevelOfDetail {{ {shapes} }}")),
        2
    );
    assert_eq!(count("Array { numElements1 3 numElements2 2 Sphere { } }"), 6);
    assert_eq!(
        count(&format!(
            "MultipleCopy {{ matrix [ {0} {0} ] Sphere {{ }} }}",
            "1 0 0 0 0 1 0 0 0 0 1 0 7 0 0 1 "
        )),
        2
    );
    let (imported, _) = iv("MatrixTransform { matrix 1 0 0 0 0 1 0 0 0 0 1 0 7 8 9 1 } Sphere { }");
    says(&imported, "pivot { 7 8 9 }");
}

#[test]
fn images_lie_on_shapes() {
    let image = "Texture2 { image 2 1 3 0xff0000 0xff wrapS CLAMP wrapT CLAMP }";
    let text = format!(
        "{image} {QUAD} TextureCoordinate2 {{ point [ 0 0, 1 0, 1 1, 0 1 ] }} Texture2Transform {{ scaleFactor 2 3 }}\n\
         FaceSet {{ numVertices 4 }} Separator {{ TextureCoordinateDefault {{ }} IndexedFaceSet {{ coordIndex [ 0 1 2 3 ] }} }} Cylinder {{ parts ( SIDES | TOP ) }}"
    );
    let (imported, scene) = iv(&text);
    assert_eq!((imported.shapes.1, scene.objects.len()), (0, 4));
    says(&imported, "texture texture { filename textures/texture.png  wrap CLAMP }");
    says(&imported, "material_texture material { phong_info material  texture texture }");
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    assert!(mesh.mesh.uvs.contains(&[2.0, 3.0]), "{:?}", mesh.mesh.uvs);
}

#[test]
fn lights_and_cameras_stand_where_they_are() {
    let text = "PerspectiveCamera { position 0 0 5 heightAngle 1.5707963 focalDistance 2 } OrthographicCamera { }\n\
                Translation { translation 0 10 0 } PointLight { intensity .5 color 1 .5 0 location 1 0 0 } PointLight { on FALSE }\n\
                DirectionalLight { direction 0 -1 0 } SpotLight { } Sphere { }";
    let (imported, scene) = iv(text);
    assert_eq!(
        imported.left_out,
        ["a further camera", "that a spot light does not fall off with distance"]
    );
    assert!(imported.made_up.is_empty(), "{:?}", imported.made_up);
    assert_eq!(scene.lights.len(), 3);
    // y of the file is up.
    says(
        &imported,
        "addPosition { 0 -5 0 }  addTarget { 0 -3 0 }  skyStart { 0 0 1 }  fovStart 1 }",
    );
    says(&imported, "light_point light { color { 0.5 0.25 0 }  position { 1 0 10 } }");
    says(&imported, "light_point light_2 { color { 1 1 1 }  position { 0 0 1742.");
}

#[test]
fn other_files_stand_in_place() {
    let main = "#Inventor V2.0 ascii\nFile { name \"b.iv\" } File { name \"../c.iv\" } File { name gone.iv }";
    let b = "#Inventor V1.0 ascii\nSeparator { Label { label \"a } b\" } Cube { } # } \n}";
    let (imported, scene) = scene_of(&[("a.iv", main), ("b.iv", b)]);
    assert_eq!(scene.objects.len(), 1);
    assert_eq!(
        imported.left_out,
        ["the file `../c.iv`, which can't be read", "the file `gone.iv`, which can't be read"]
    );
    assert!(
        refused("a.iv", "#Inventor V2.1 ascii\nFile { name a.iv }").contains("nested more than")
    );
}

#[test]
fn unknown_nodes_are_passed_by() {
    let text = "Foo { fields [ SFFloat a, MFVec3f b ] a 1 b [ 1 2 3 ] c \"} {\" Sphere { } }\n\
                Bar { x ~ y 1 = Foo.a z Cube { width = Foo.a } on TRUE }\n\
                Separator { Text2 { string [ \"a\", \"b \\\" c\" ] } DrawStyle { style LINES } Sphere { } }";
    let (imported, scene) = iv(text);
    assert_eq!(scene.objects.len(), 2);
    assert_eq!(
        imported.left_out,
        [
            "that something is drawn as lines or points: it is hidden",
            "the node `Bar`",
            "the node `Foo`",
            "the node `Text2`"
        ]
    );
    says(&imported, "radius 1  material material  hidden 1");
}

/// Kits say in fields what other nodes say by their order.
#[test]
fn node_kits_have_their_parts_in_fields() {
    let list = |children: &str| {
        format!(
            "NodeKitListPart {{ containerTypeName \"Separator\" childTypeNames [ \"ShapeKit\", \"SeparatorKit\" ] \
             containerNode Separator {{ {children} }} }}"
        )
    };
    let red = "AppearanceKit { material DEF red Material { diffuseColor 1 0 0 } }";
    // The shape stands before its transform and look, which act all the same.
    let ball = format!(
        "DEF ball ShapeKit {{ shape Sphere {{ radius 2 }} appearance {red} transform Transform {{ translation 5 0 0 }} \
         pickStyle NULL }}"
    );
    let inner = format!(
        "SeparatorKit {{ transform Transform {{ scaleFactor 2 2 2 }} childList {} }}",
        list("ShapeKit { shape Cube { } }")
    );
    let text = format!(
        "SceneKit {{ cameraList NodeKitListPart {{ containerNode Switch {{ whichChild 0 CameraKit {{ camera \
         PerspectiveCamera {{ position 0 0 9 }} }} }} }} lightList {} childList {} }} Cube {{ }}",
        list(
            "LightKit { transform Transform { translation 0 7 0 } light PointLight { location 1 0 0 } }"
        ),
        list(&format!("{ball} {inner}"))
    );
    let (imported, scene) = iv(&text);
    assert!(imported.left_out.is_empty() && imported.made_up.is_empty(), "{imported:?}");
    assert_eq!((scene.objects.len(), scene.lights.len()), (3, 1));
    says(&imported, "addPosition { 0 -9 0 }");
    says(&imported, "light_point light { color { 1 1 1 }  position { 1 0 7 } }");
    says(&imported, "sphere ball {");
    says(&imported, "diffuse { 1 0 0 }");
    says(&imported, "scale { 2 2 2 }");
    // What a kit sets ends with it.
    assert_eq!(imported.text.matches("pivot { 5 0 0 }").count(), 1, "{}", imported.text);
}

#[test]
fn patches_are_round() {
    let bump: Vec<String> =
        (0..9).map(|i| format!("{} {} {}", i % 3, i / 3, if i == 4 { 4 } else { 0 })).collect();
    let text = format!(
        "Coordinate3 {{ point [ {} ] }} NurbsSurface {{ numUControlPoints 3 numVControlPoints 3 \
         uKnotVector [ 0 0 0 1 1 1 ] vKnotVector [ 0 0 0 1 1 1 ] }}",
        bump.join(", ")
    );
    let (imported, scene) = iv(&text);
    assert_eq!(imported.shapes, (128, 0));
    let Shape::Mesh(mesh) = &scene.objects[0].shape else { panic!() };
    // A quarter of the way up in each direction: (1 / 2)² 4.
    let top = mesh.mesh.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    assert!((top - 1.0).abs() < 1e-6, "{top}");
}

/// Binary files are units of four bytes.
#[derive(Default)]
struct Binary(Vec<u8>);

impl Binary {
    fn word(mut self, word: u32) -> Self {
        self.0.extend(word.to_be_bytes());
        self
    }

    fn text(mut self, text: &str) -> Self {
        self = self.word(text.len() as u32);
        self.0.extend(text.as_bytes());
        self.0.resize(self.0.len().next_multiple_of(4), 0);
        self
    }

    fn floats(self, floats: &[f32]) -> Self {
        floats.iter().fold(self, |binary, float| binary.word(float.to_bits()))
    }
}

#[test]
fn binary_files_say_the_same() {
    let header = Binary(b"#Inventor V2.1 binary  \n".to_vec());
    let file = header
        .text("Separator")
        .word(2)
        .word(1)
        .text("renderCaching")
        .text("AUTO")
        .word(0)
        .word(3)
        .text("DEF")
        .text("t")
        .text("Translation")
        .word(0)
        .word(1)
        .text("translation")
        .floats(&[1.0, 2.0, 3.0])
        .word(0)
        .text("Cylinder")
        .word(0)
        .word(2)
        .text("radius")
        .floats(&[4.0])
        .word(1)
        .text("parts")
        .text("ALL")
        .text("")
        .word(0)
        .text("USE")
        .text("t");
    let write = |bytes: &[u8]| {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.iv"), bytes).unwrap();
        crate::import(&folder.path().join("a.iv"), false)
    };
    let imported = write(&file.0).unwrap();
    says(&imported, "radius 1  material material  addKframe { time 0  key { pivot { 1 2 3 } } }");
    super::read(&imported);
    for cut in (0..file.0.len() - 4).step_by(4) {
        assert!(write(&file.0[..cut]).is_err() || cut < 24, "{cut}");
    }
    let unknown = Binary(b"#Inventor V2.1 binary  \n".to_vec()).text("Foo").word(0).word(0);
    let message = write(&unknown.0).unwrap_err().to_string();
    assert!(message.contains("the class `Foo` is not known; `ivcat` makes it a text"), "{message}");
}

#[test]
fn binary_files_of_version_2_0_count_no_fields_of_groups() {
    let file = Binary(b"#Inventor V2.0 binary  \n".to_vec())
        .text("Group")
        .word(2)
        .text("Texture2")
        .word(1)
        .text("image")
        .word(2)
        .word(1)
        .word(3)
        .word(0x00ff_0000)
        .word(0xff)
        .word(0)
        .text("Cube")
        .word(0);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.iv"), &file.0).unwrap();
    let imported = crate::import(&folder.path().join("a.iv"), false).unwrap();
    assert_eq!(imported.shapes, (12, 0));
    assert!(imported.left_out.is_empty(), "{:?}", imported.left_out);
    says(&imported, "texture texture { filename textures/texture.png }");
}

#[test]
fn mistakes_in_inventor_have_their_line() {
    for (text, expected) in [
        ("Separator {\nSphere { radius }\n}", "line 3: a field has no value"),
        ("Separator {\nSphere { }", "line 3: `Separator` is not closed at the end"),
        ("Sphere", "line 2: expected `{` behind `Sphere`"),
        ("}", "line 2: expected a node"),
        ("Normal { vector [ 1 2\n", "line 3: a list is not closed at the end"),
    ] {
        let message = refused("a.iv", format!("#Inventor V2.1 ascii\n{text}"));
        assert!(
            message.contains(expected) || message.replace("line 2", "line 3").contains(expected),
            "{message}"
        );
    }
    assert!(refused("a.iv", "Sphere { }").contains("it does not begin with `#Inventor V`"));
    let deep = format!("#Inventor V2.1 ascii\n{}", "Group { ".repeat(100_000));
    assert!(refused("a.iv", deep).contains("nested more than"));
    let bomb: String =
        (1..40).map(|i| format!("DEF a{i} Group {{ USE a{0} USE a{0} }}\n", i - 1)).collect();
    let bomb = format!("#Inventor V2.1 ascii\nDEF a0 Group {{ }}\n{bomb}");
    assert!(refused("a.iv", bomb).contains("it has more than 2000000 nodes"));
}
