//! Warnings that readers of several formats share.

/// Parts of a sentence: "a", "a and b", "a, b and c".
pub(super) fn sentence(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// About faces of fewer than three corners; `place` says where the first one is.
pub(super) fn few_corners(count: usize, place: &str) -> Option<String> {
    match count {
        0 => None,
        1 => Some(format!("1 face has fewer than 3 corners and was left out ({place})")),
        _ => Some(format!(
            "{count} faces have fewer than 3 corners and were left out (the first is {place})"
        )),
    }
}

/// About uvs and normals of faces that are NaN or infinite.
pub(super) fn odd_numbers(uvs: usize, normals: usize) -> Vec<String> {
    let uvs = match uvs {
        0 => None,
        1 => Some("1 uv is not finite and counts as 0 0".to_owned()),
        _ => Some(format!("{uvs} uvs are not finite and count as 0 0")),
    };
    let normals = match normals {
        0 => None,
        1 => Some("1 normal is not finite: it is computed instead".to_owned()),
        _ => Some(format!("{normals} normals are not finite: they are computed instead")),
    };
    [uvs, normals].into_iter().flatten().collect()
}
