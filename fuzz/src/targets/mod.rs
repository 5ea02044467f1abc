//! The fuzzers. Each is a function `run` from bytes to nothing, which panics if a promise is broken, or to
//! whether the bytes are worth keeping.

use crate::Worth;

/// What a fuzzer does with an input.
pub type Run = fn(&[u8]) -> Worth;

macro_rules! targets {
    ($($name:ident)*) => {
        $(mod $name;)*

        /// All fuzzers, by name.
        pub const ALL: &[(&str, Run)] =
            &[$((stringify!($name), |data| $name::run(data).into())),*];
    };
}

targets! {
    cache
    claim
    edit
    import_aff
    import_glb
    import_gltf
    import_iv
    import_nff
    import_obj
    import_ply
    mesh_obj
    mesh_ply
    mesh_slo
    picture
    placements
    recipe
    render
    scene
    sculpt
    splits
    state
    structures
    texture_exr
    texture_hdr
    texture_jpeg
    texture_png
    view
}
