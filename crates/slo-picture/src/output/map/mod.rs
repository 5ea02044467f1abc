//! Pictures beside the pictures: maps and contact sheets.

mod companion;
mod write;

pub use companion::{check_companion, is_companion, map_format, write_sheet};
pub use write::{
    ERRORS, map_color, write_cost_map, write_difference_map, write_error_map, write_sample_map,
};
