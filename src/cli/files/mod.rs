//! Files that commands read and write: scenes, pictures, states, and where they may lie.

pub(crate) mod built_in;
pub(crate) mod checkpoint;
pub(crate) mod load;
pub(crate) mod new_folders;
pub(crate) mod paths;
pub(crate) mod pictures;
pub(crate) mod scene_file;
