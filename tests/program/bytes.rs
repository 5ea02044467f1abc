//! A picture is the same file, byte for byte, however it was made.

use super::{Folder, SCENE};

/// Every effect at once, in a picture whose sides are not multiples of the tile size.
fn scene_text(output: &str) -> String {
    SCENE
        .replace("imageSamples 2", "imageSamples 16 imageMinSamples 4 dofSamples 2 recursion 3")
        .replace("width 16 height 9", "width 61 height 37")
        .replace("PNG_IMAGE", output)
        .replace("fovStart 0.4", "fovStart 0.4 dofStart 5 lensRadiusStart 0.1 blurDuration 0.04")
        + "
light_rectangle window { color { .4 .4 .5 } vertex0 { -3 0 4 } vertex1 { -1 0 4 } vertex2 { -1 2 4 } }
phong_info shiny { specular { .5 .5 .5 } shininess 50 reflectance .5 diffuse_reflection .1
                   refraction .4 diffuse_refraction .05 refraction_index 1.5 }
material_phong shiny { phong_info shiny }
plane floor { normal { 0 0 1 } position { 0 0 -1 } material matte }
box block { vertex0 { 1 0 -1 } vertex1 { 2 0 -1 } vertex2 { 2 1 -1 } height 1.5 material shiny }
cylinder mover { base { 0 0 -1 } top { 0 0 0 } radius 0.4 material shiny
    addKframe { time 0 key { pivot { -1.8 -1 0 } } }
    addKframe { time 1 key { pivot { 3 -1 0 } } } }
"
}

#[test]
fn threads_structures_and_instructions_do_not_show() {
    for output in ["PNG_IMAGE", "EXR_IMAGE"] {
        let folder = Folder::with_scene(&scene_text(output));
        let name = folder.printed("-q -s scene.txt -f 3 --threads 1");
        let expected = folder.read(name.trim_end());
        let check = |typed: &str, isa: &str| {
            let mut command = folder.command(&format!("-q -s scene.txt -f 3 -od again {typed}"));
            let status = command.env("SLO_RT_ISA", isa).status().unwrap();
            assert!(status.success(), "{output} {typed} {isa}");
            let again = folder.read(&format!("again/{}", name.trim_end()));
            assert!(again == expected, "{output} {typed} {isa}: other bytes");
        };
        for threads in [2, 3, 8] {
            check(&format!("--threads {threads}"), "auto");
        }
        check("--accelerator none", "auto");
        check("--spatial-splits", "auto");
        check("--threads 2", "portable");
    }
}
