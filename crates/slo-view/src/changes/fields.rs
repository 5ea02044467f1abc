//! Attributes of elements, as fields that can be changed.

use serde_json::{Value, json};
use slo_scene::edit::{Edit, Outline, Part};

use super::objects::thing;

/// Most fields of one element.
const MOST: usize = 80;
/// Longest value that is shown or set.
const LONGEST: usize = 200;

/// Where an attribute stands: an element, and the blocks within it by their keywords and numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Place {
    pub(crate) keyword: String,
    pub(crate) name: String,
    pub(crate) blocks: Vec<(String, usize)>,
}

/// An attribute and its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub(crate) place: Place,
    pub(crate) attribute: String,
    pub(crate) value: String,
    /// Whether it stands in braces.
    pub(crate) is_vector: bool,
}

/// Returns the change that gives a field its value.
///
/// # Errors
/// There is no such place, or the value can't stand in a text.
pub(crate) fn set(text: &str, field: &Field) -> Result<Vec<Edit>, String> {
    let Field { place, attribute, value, is_vector } = field;
    check(attribute)?;
    check(value)?;
    if attribute.contains(char::is_whitespace) {
        return Err(format!("`{attribute}` is no attribute"));
    }
    let outline = Outline::new(text);
    let missing = || format!("the text has no `{} {}`", place.keyword, place.name);
    let mut part = outline.element(&place.keyword, &place.name).ok_or_else(missing)?;
    for (keyword, index) in &place.blocks {
        let inner = part.parts(keyword).nth(*index).ok_or_else(missing)?;
        part = inner;
    }
    Ok(if *is_vector { part.set_vector(attribute, value) } else { part.set(attribute, value) })
}

/// Checks that a value is one or more words of one attribute.
fn check(value: &str) -> Result<(), String> {
    let is_comment = |word: &str| word.starts_with('#') || word.starts_with("/*");
    let is_bad = value.trim().is_empty()
        || value.len() > LONGEST
        || value.contains(|c: char| matches!(c, '{' | '}' | '"') || (c.is_control()))
        || value.split_whitespace().any(is_comment);
    if is_bad { Err(format!("`{value}` can't be a value")) } else { Ok(()) }
}

/// Returns the elements that a thing consists of, with their fields: itself, its material, and what that
/// refers to.
pub(crate) fn parts_of(text: &str, object: &str, material: Option<&str>) -> Vec<Value> {
    let outline = Outline::new(text);
    let mut found: Vec<Part<'_, '_>> = thing(&outline, object).into_iter().collect();
    let of_kind = |kind: &dyn Fn(&str) -> bool, name: &str| {
        outline.elements().find(|part| kind(part.keyword()) && part.name() == Some(name))
    };
    if let Some(material) = material {
        found.extend(of_kind(&|keyword| keyword.starts_with("material_"), material));
    }
    let info = found.last().and_then(|part| part.value("phong_info"));
    found.extend(info.and_then(|name| of_kind(&|keyword| keyword == "phong_info", name)));
    found.iter().map(element).collect()
}

fn element(part: &Part<'_, '_>) -> Value {
    let mut fields = Vec::new();
    add_fields(part, &mut Vec::new(), &mut fields);
    json!({
        "keyword": part.keyword(),
        "name": part.name(),
        "line": part.line(),
        "fields": fields,
    })
}

/// Adds the attributes of an element and of the blocks in it.
fn add_fields(part: &Part<'_, '_>, blocks: &mut Vec<(String, usize)>, fields: &mut Vec<Value>) {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for name in part.names() {
        if fields.len() >= MOST {
            return;
        }
        let index = counts.iter().filter(|(known, _)| *known == name).count();
        counts.push((name, index));
        let inner = part.parts(name).nth(index).filter(|inner| inner.names().next().is_some());
        if let Some(inner) = inner {
            blocks.push((name.to_owned(), index));
            add_fields(&inner, blocks, fields);
            blocks.pop();
        } else if index == 0
            && let Some(value) = part.value(name).filter(|value| value.len() <= LONGEST)
        {
            fields.push(json!({
                "blocks": blocks,
                "attribute": name,
                "value": value.split_whitespace().collect::<Vec<_>>().join(" "),
                "vector": part.part(name).is_some(),
                "numbers": part.numbers(name).is_some(),
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use slo_scene::edit::applied;

    use super::*;

    const TEXT: &str = "phong_info red { diffuse { .8 .1 .1 } }
material_phong red { phong_info red } # red
sphere ball { radius 1 material red
    addKframe { time 0 key { pivot { 0 0 0 } } }
    addKframe { time 1 key { pivot { 1 0 0 } } } }
";

    fn field(keyword: &str, blocks: &[(&str, usize)], attribute: &str, value: &str) -> Field {
        let blocks =
            blocks.iter().map(|(keyword, index)| ((*keyword).to_owned(), *index)).collect();
        let name = if keyword == "sphere" { "ball" } else { "red" };
        let place = Place { keyword: keyword.into(), name: name.into(), blocks };
        let (attribute, value) = (attribute.to_owned(), value.to_owned());
        Field { place, attribute, is_vector: value.contains(' '), value }
    }

    #[test]
    fn fields_of_a_thing_and_its_material() {
        let parts = parts_of(TEXT, "ball", Some("red"));
        let titles: Vec<_> = parts.iter().map(|part| part["keyword"].as_str().unwrap()).collect();
        assert_eq!(titles, ["sphere", "material_phong", "phong_info"]);
        assert_eq!(
            (&parts[0]["line"], parts[0]["fields"].as_array().unwrap().len()),
            (&json!(3), 6)
        );
        let pivot = &parts[0]["fields"][5];
        assert_eq!(pivot["blocks"], json!([["addKframe", 1], ["key", 0]]));
        assert_eq!((&pivot["value"], &pivot["vector"]), (&json!("1 0 0"), &json!(true)));
        assert_eq!(parts[2]["fields"][0]["value"], ".8 .1 .1");
    }

    #[test]
    fn fields_can_be_set() {
        for (field, old, new) in [
            (field("phong_info", &[], "diffuse", ".8 .1 .2"), "{ .8 .1 .1 }", "{ .8 .1 .2 }"),
            (field("sphere", &[], "radius", "2"), "radius 1", "radius 2"),
            (
                field("sphere", &[("addKframe", 1), ("key", 0)], "pivot", "3 0 0"),
                "{ 1 0 0 }",
                "{ 3 0 0 }",
            ),
        ] {
            let text = applied(TEXT, set(TEXT, &field).unwrap()).unwrap();
            assert_eq!(text, TEXT.replace(old, new));
        }
    }

    #[test]
    fn nothing_else_can_be_written() {
        for value in ["", " ", "1 }", "# no", "1 /* no", "a\nb", "\"", &"1 ".repeat(200)] {
            assert!(set(TEXT, &field("sphere", &[], "radius", value)).is_err(), "{value}");
            assert!(set(TEXT, &field("sphere", &[], value, "1")).is_err(), "{value}");
        }
        assert!(set(TEXT, &field("sphere", &[], "radius 2 hidden", "1")).is_err());
        assert!(set(TEXT, &field("box", &[], "radius", "1")).is_err());
        assert!(set(TEXT, &field("sphere", &[("addKframe", 2)], "time", "1")).is_err());
    }
}
