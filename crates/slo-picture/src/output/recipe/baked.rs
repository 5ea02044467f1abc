//! Recipes of light maps.

use super::relit::ascii;

/// The recipe of a picture -> the recipe of the light map of an object. No rendered picture has such a
/// recipe.
pub fn with_light_map(recipe: &str, object: &str) -> String {
    let whole = recipe.strip_suffix("\n}").unwrap_or(recipe);
    format!("{whole},\n  \"lightMap\": {}\n}}", ascii(object))
}

/// Whether a recipe belongs to a light map.
pub fn is_light_map(recipe: &serde_json::Value) -> bool {
    recipe.get("lightMap").is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_light_map_is_no_rendered_picture() {
        let recipe = "{\n  \"frame\": 5\n}";
        let light_map = with_light_map(recipe, "Küche");
        assert!(light_map.is_ascii(), "{light_map}");
        let parsed: serde_json::Value = serde_json::from_str(&light_map).unwrap();
        assert_eq!((&parsed["frame"], &parsed["lightMap"]), (&5.into(), &"Küche".into()));
        assert!(is_light_map(&parsed));
        assert!(!is_light_map(&serde_json::from_str(recipe).unwrap()));
    }
}
