//! What an element refers to: other elements by their names, and files by their paths.

use std::ops::Range;

use super::part::{Part, whole};
use crate::assets::path_from;
use crate::format::syntax::{Block, Entry, Form};
use crate::resolve::{Referred, referred};

/// What a word of a scene can lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Target {
    /// A `phong_info`.
    PhongInfo,
    /// A material of any kind.
    Material,
    /// A `texture`.
    Texture,
    /// An object, a light, a group or a copy.
    Object,
    /// A file.
    File,
}

/// A word that leads to another element, or to a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link<'a> {
    /// The attribute that it is the value of.
    pub attribute: &'a str,
    /// What it leads to.
    pub target: Target,
    /// The name or the path, without quotes.
    pub word: &'a str,
    /// The bytes of the word, with its quotes.
    pub range: Range<usize>,
}

impl<'a> Part<'_, 'a> {
    /// What words lead to this element; `None` if none do.
    pub fn target(&self) -> Option<Target> {
        Some(match referred(self.keyword())? {
            Referred::PhongInfo => Target::PhongInfo,
            Referred::Material => Target::Material,
            Referred::Texture => Target::Texture,
            Referred::Object => Target::Object,
        })
    }

    /// All that it refers to, in order.
    pub fn links(&self) -> Vec<Link<'a>> {
        let mut links = Vec::new();
        add_links(self.text(), self.keyword(), self.block(), &mut links);
        links
    }
}

/// Adds what the block of an owner refers to.
fn add_links<'a>(text: &'a str, owner: &str, block: &Block<'a>, links: &mut Vec<Link<'a>>) {
    for entry in &block.entries {
        let Entry::Item(item) = entry else { continue };
        match &item.form {
            Form::Value(word) => {
                let attribute = item.keyword.text;
                links.extend(target_of(owner, attribute).map(|target| Link {
                    attribute,
                    target,
                    word: word.text,
                    range: whole(text, *word),
                }));
            }
            Form::Element(_, block) | Form::Block(block) => {
                add_links(text, item.keyword.text, block, links);
            }
            Form::Nothing | Form::Broken => {}
        }
    }
}

/// What the word of an attribute of an owner leads to.
fn target_of(owner: &str, attribute: &str) -> Option<Target> {
    Some(match attribute {
        "phong_info" => Target::PhongInfo,
        // The `first` of `shapes` is a number.
        "first" | "second" if owner != "material_mix" => return None,
        "material" | "first" | "second" => Target::Material,
        "parent" | "of" => Target::Object,
        "filename" | "placements" => Target::File,
        _ if attribute == "texture" || attribute.ends_with("_texture") => Target::Texture,
        _ => return None,
    })
}

/// Returns a path that starts in a folder as it is written where the folder's own path starts. Absolute
/// paths stay as they are.
pub fn path_in(folder: &str, path: &str) -> String {
    path_from(Some(folder), path).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::attributes::schema::Kind;
    use crate::edit::Outline;
    use crate::resolve::LANGUAGE;

    #[test]
    fn every_name_and_path_of_the_language_is_known() {
        for schema in LANGUAGE.all() {
            for attribute in schema.attributes() {
                let found = target_of(schema.keyword, attribute.name);
                let where_ = format!("{} {}", schema.keyword, attribute.name);
                match attribute.kind {
                    // A light group is a name of its own, and so is the beginning of a file's name.
                    _ if ["light_group", "prefix"].contains(&attribute.name) => {
                        assert_eq!(found, None, "{where_}");
                    }
                    Kind::Word("PATH") => assert_eq!(found, Some(Target::File), "{where_}"),
                    Kind::Word(_) | Kind::WordOrBlock(..) => assert!(found.is_some(), "{where_}"),
                    _ => assert_eq!(found, None, "{where_}"),
                }
            }
        }
    }

    #[test]
    fn links_of_elements() {
        let text = "mesh \"a b\" { filename \"x y.slo\" filename z.slo material red parent g }
material_principled red { roughness_texture { texture t channel G } normal_texture n }
texture t { filename t.png }
copies wood { of oak of elm placements wood.ply }";
        let outline = Outline::new(text);
        let found: Vec<_> = outline
            .elements()
            .flat_map(|part| part.links())
            .map(|link| (link.attribute, link.target, link.word, &text[link.range]))
            .collect();
        assert_eq!(
            found,
            [
                ("filename", Target::File, "x y.slo", "\"x y.slo\""),
                ("filename", Target::File, "z.slo", "z.slo"),
                ("material", Target::Material, "red", "red"),
                ("parent", Target::Object, "g", "g"),
                ("texture", Target::Texture, "t", "t"),
                ("normal_texture", Target::Texture, "n", "n"),
                ("filename", Target::File, "t.png", "t.png"),
                ("of", Target::Object, "oak", "oak"),
                ("of", Target::Object, "elm", "elm"),
                ("placements", Target::File, "wood.ply", "wood.ply"),
            ]
        );
        let targets: Vec<_> = outline.elements().map(|part| part.target()).collect();
        let [object, material, texture] = [Target::Object, Target::Material, Target::Texture];
        assert_eq!(targets, [Some(object), Some(material), Some(texture), Some(object)]);
    }

    #[test]
    fn paths_move_with_their_files() {
        for (folder, path, expected) in [
            ("", "a.slo", "a.slo"),
            ("sets/old/", "a.slo", "sets/old/a.slo"),
            ("sets", "../a.slo", "a.slo"),
            ("../up", "b/./c.ply", "../up/b/c.ply"),
            ("sets", "/tmp/a.slo", "/tmp/a.slo"),
        ] {
            assert_eq!(path_in(folder, path), expected);
        }
    }
}
