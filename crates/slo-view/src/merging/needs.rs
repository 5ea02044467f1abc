//! What things need: materials, textures, what they hang in, and what copies show.

use std::collections::{BTreeMap, BTreeSet};

use slo_scene::edit::{Target, path_in};

use super::catalog::{Catalog, Thing};

/// What is taken over.
#[derive(Debug, Default)]
pub(super) struct Needs {
    /// Indices of the things of the other scene.
    pub(super) taken: BTreeSet<usize>,
    /// Things that are here already, by their indices there.
    pub(super) here: BTreeMap<usize, usize>,
}

/// Returns what a choice of things of another scene needs.
///
/// # Errors
/// Something that is needed is missing.
pub(super) fn needs(own: &Catalog, other: &Catalog, chosen: &[usize]) -> Result<Needs, String> {
    let mut needs = Needs::default();
    let chosen: BTreeSet<usize> = chosen.iter().copied().collect();
    // With whether all that hangs in it is needed too.
    let mut waiting: Vec<(usize, bool)> = chosen.iter().map(|index| (*index, true)).collect();
    let mut filled = BTreeSet::new();
    while let Some((index, is_whole)) = waiting.pop() {
        let thing = other.things.get(index).ok_or("the other scene has changed meanwhile")?;
        if is_whole && thing.keyword == "group" && filled.insert(index) {
            waiting.extend(other.hanging_in(&thing.name).iter().map(|member| (*member, true)));
        }
        if needs.here.contains_key(&index) || !needs.taken.insert(index) {
            continue;
        }
        for link in thing.links.iter().filter(|link| link.target != Target::File) {
            let found = other.find(link.target, &link.word).ok_or_else(|| {
                format!("`{}` refers to `{}`, which is missing", thing.name, link.word)
            })?;
            if needs.here.contains_key(&found) {
                continue;
            }
            let is_settled = needs.taken.contains(&found) || chosen.contains(&found);
            let here = if is_settled { None } else { same(own, other, found) };
            match here {
                Some(here) => _ = needs.here.insert(found, here),
                None => waiting.push((found, link.attribute == "of")),
            }
        }
    }
    Ok(needs)
}

/// Index of the material or texture that is the same here; `None` if there is none.
fn same(own: &Catalog, other: &Catalog, index: usize) -> Option<usize> {
    let mut pairs = BTreeSet::new();
    let theirs = &other.things[index];
    let target = theirs.target.filter(|target| *target != Target::Object)?;
    let ours = own.find(target, &theirs.name)?;
    is_same(own, other, (ours, index), &mut pairs).then_some(ours)
}

fn is_same(
    own: &Catalog,
    other: &Catalog,
    pair: (usize, usize),
    pairs: &mut BTreeSet<(usize, usize)>,
) -> bool {
    // What refers to itself is reported elsewhere.
    if !pairs.insert(pair) {
        return true;
    }
    let (ours, theirs) = (&own.things[pair.0], &other.things[pair.1]);
    let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    if words(own.text_of(ours)) != words(other.text_of(theirs)) {
        return false;
    }
    ours.links.iter().zip(&theirs.links).all(|(a, b)| match a.target {
        Target::File => {
            let path = |of: &Catalog, thing: &Thing, word: &str| {
                path_in(&of.files[thing.file].folder, word)
            };
            path(own, ours, &a.word) == path(other, theirs, &b.word)
        }
        target => match (own.find(target, &a.word), other.find(target, &b.word)) {
            (Some(a), Some(b)) => is_same(own, other, (a, b), pairs),
            _ => false,
        },
    })
}
