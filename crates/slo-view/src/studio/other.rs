//! Another scene, of which things are taken over.

use serde_json::{Value, json};

use super::{Effects, Studio};
use crate::merging::{Catalog, Merged, Sort, merge};

/// Most things of another scene that the page lists.
const MOST_LISTED: usize = 1000;

/// Most new names that the page lists.
const MOST_RENAMED: usize = 8;

/// Another scene, as it was when it was opened.
#[derive(Debug)]
pub(super) struct Other {
    path: String,
    catalog: Catalog,
    /// What was taken over last.
    note: Option<String>,
}

impl Other {
    /// What the page shows of it.
    pub(super) fn to_json(&self) -> Value {
        let of = |sort: Sort| -> Vec<Value> {
            let things = self.catalog.things.iter().enumerate();
            let things = things.filter(|(_, thing)| thing.sort == sort).take(MOST_LISTED);
            let value = |(index, thing): (usize, &crate::merging::Thing)| json!({ "index": index, "keyword": thing.keyword, "name": thing.name });
            things.map(value).collect()
        };
        let listed = [
            ("Objects", Sort::Object),
            ("Lamps", Sort::Lamp),
            ("Materials", Sort::Material),
            ("Camera", Sort::Camera),
        ];
        let lists = listed.map(|(title, sort)| json!({ "title": title, "things": of(sort) }));
        let count =
            |sort: Sort| self.catalog.things.iter().filter(|thing| thing.sort == sort).count();
        let unlisted: usize =
            listed.iter().map(|(_, sort)| count(*sort).saturating_sub(MOST_LISTED)).sum();
        json!({ "path": self.path, "lists": lists, "unlisted": unlisted, "note": self.note })
    }
}

impl Studio {
    /// Opens another scene, whose things the page lists.
    pub(super) fn open_other(&mut self, path: &str) -> Result<Effects, String> {
        self.other = None;
        let open = |path: &str| self.loading.open(path);
        let text = open(path)?;
        let folder = &path[..path.rfind('/').map_or(0, |i| i + 1)];
        let catalog = Catalog::of(text, folder, &open)?;
        if catalog.things.is_empty() {
            return Err(format!("`{path}` is no scene, or holds nothing that can be taken over"));
        }
        self.other = Some(Other { path: path.to_owned(), catalog, note: None });
        Ok(Effects::default())
    }

    /// Takes things of the other scene over, at the end of the text.
    pub(super) fn take(&mut self, chosen: &[usize]) -> Result<Effects, String> {
        self.settle();
        if self.loading.diagnostics().has_errors() {
            return Err("the scene has errors".into());
        }
        let other = self.other.as_ref().ok_or("open the other scene first")?;
        let text = self.loading.document().text().to_owned();
        let own = Catalog::of(text, "", &|path| self.loading.open(path))?;
        let merged = merge(&own, &other.catalog, &other.path, chosen)?;
        let what = format!("things of {}", other.path);
        let note = note(&merged);
        self.loading.change(merged.edits, &what, false)?;
        if let Some(other) = &mut self.other {
            other.note = Some(note);
        }
        Ok(self.load_again())
    }
}

/// Says what was taken over.
fn note(merged: &Merged) -> String {
    let [chosen, needed] = merged.counts;
    let mut note = format!("Added {chosen}");
    if needed > 0 {
        note +=
            &format!(", and {needed} more that {} need", if chosen == 1 { "it" } else { "they" });
        if chosen == 1 {
            note.push('s');
        }
    }
    // A material and its phong_info may have the same name.
    let mut renamed = merged.renamed.clone();
    renamed.dedup();
    let named: Vec<_> =
        renamed.iter().take(MOST_RENAMED).map(|[old, new]| format!("{old} is now {new}")).collect();
    if !named.is_empty() {
        note += &format!("; {}", named.join(", "));
        if renamed.len() > named.len() {
            note += &format!(", and {} more", renamed.len() - named.len());
        }
    }
    note
}
