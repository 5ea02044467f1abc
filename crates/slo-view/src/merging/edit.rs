//! The change of the text that takes things over.

use std::collections::{BTreeMap, BTreeSet};

use slo_scene::edit::{Edit, Outline, Part, Target, append, applied, numbers, path_in};
use slo_scene::format::written;

use super::catalog::{Catalog, Sort, Thing};
use super::needs::{Needs, needs};

/// Significant digits of times.
const DIGITS: usize = 9;

/// What a merge changes.
#[derive(Debug)]
pub(crate) struct Merged {
    pub(crate) edits: Vec<Edit>,
    /// How many things were chosen, and how many more they need.
    pub(crate) counts: [usize; 2],
    /// Old and new names of those whose names were taken.
    pub(crate) renamed: Vec<[String; 2]>,
}

/// Returns the change of a scene's text that takes things of another scene over, with all that they need,
/// at its end. `own` is the catalog of the text; `path` is what a comment calls the other scene.
///
/// # Errors
/// Something that is needed is missing, or the two scenes do not fit each other.
pub(crate) fn merge(
    own: &Catalog,
    other: &Catalog,
    path: &str,
    chosen: &[usize],
) -> Result<Merged, String> {
    let text = own.files.first().map_or("", |file| &file.text);
    let all = needs(own, other, chosen)?;
    let things: Vec<(usize, &Thing)> =
        all.taken.iter().map(|index| (*index, &other.things[*index])).collect();
    if things.is_empty() {
        return Err("choose what to take over".into());
    }
    check(own, other, &things)?;
    let names = names(own, &things);
    let mut lines = vec![format!("# From {}", path.replace(char::is_control, " "))];
    let (segments, elements): (Vec<_>, Vec<_>) =
        things.iter().copied().partition(|(_, thing)| thing.sort == Sort::Camera);
    for (index, thing) in elements {
        lines.push(rewritten(own, other, (index, thing), &all, &names)?);
    }
    let mut edits = segments_added(text, other, &segments, own, &names)?;
    if lines.len() > 1 {
        edits.push(append(text, &lines.join("\n")));
    }
    let renamed = things.iter().filter(|(index, thing)| names[index] != thing.name);
    let renamed = renamed.map(|(index, thing)| [thing.name.clone(), names[index].clone()]);
    let is_chosen = things.iter().filter(|(index, _)| chosen.contains(index)).count();
    Ok(Merged { edits, counts: [is_chosen, things.len() - is_chosen], renamed: renamed.collect() })
}

/// Checks that what is taken over means the same here.
fn check(own: &Catalog, other: &Catalog, things: &[(usize, &Thing)]) -> Result<(), String> {
    let has_lengths = |(_, thing): &(usize, &Thing)| {
        matches!(thing.sort, Sort::Object | Sort::Lamp | Sort::Camera)
    };
    if own.scaling != other.scaling && things.iter().any(has_lengths) {
        let (here, there) = (own.scaling, other.scaling);
        return Err(format!(
            "the other scene has `Scaling {{ {there} }}` and this one `Scaling {{ {here} }}`: \
             only materials can be taken over"
        ));
    }
    let is_sky = |thing: &&Thing| thing.keyword == "environment";
    let here = own.things.iter().find(is_sky);
    let mut there = things.iter().map(|(_, thing)| *thing).filter(is_sky);
    match (here, there.next()) {
        (Some(here), Some(_)) => {
            Err(format!("the scene has an environment already, `{}`", here.name))
        }
        _ if there.next().is_some() => Err("a scene has at most one environment".into()),
        _ => Ok(()),
    }
}

/// Returns the new names of things: their own as far as they are free. Elements of different kinds, and
/// segments, may share a name.
fn names(own: &Catalog, things: &[(usize, &Thing)]) -> BTreeMap<usize, String> {
    let mut used: BTreeSet<(Option<Target>, String)> =
        own.things.iter().map(|thing| (thing.target, thing.name.clone())).collect();
    // The next number of each name that is taken.
    let mut numbers = BTreeMap::new();
    let mut names = BTreeMap::new();
    for (index, thing) in things {
        let mut name = thing.name.clone();
        if !used.insert((thing.target, name.clone())) {
            let number = numbers.entry((thing.target, &thing.name)).or_insert(2u64);
            let next = |number: &mut u64| {
                *number += 1;
                format!("{}_{}", thing.name, *number - 1)
            };
            name = next(number);
            while !used.insert((thing.target, name.clone())) {
                name = next(number);
            }
        }
        names.insert(*index, name);
    }
    names
}

/// Returns the text of a thing with its new name, and with what it refers to as it is called here.
fn rewritten(
    own: &Catalog,
    other: &Catalog,
    (index, thing): (usize, &Thing),
    needs: &Needs,
    names: &BTreeMap<usize, String>,
) -> Result<String, String> {
    let file = &other.files[thing.file];
    let mut words = Vec::new();
    let mut put = |range: &std::ops::Range<usize>, old: &str, new: &str| {
        if old != new {
            words.push(Edit { range: range.clone(), text: written(new).to_string() });
        }
    };
    put(&thing.name_range, &thing.name, &names[&index]);
    for link in &thing.links {
        let new = match link.target {
            Target::File => path_in(&file.folder, &link.word),
            target => {
                let found = other.find(target, &link.word).ok_or("something is missing")?;
                let here = needs.here.get(&found).map(|here| &own.things[*here].name);
                names.get(&found).or(here).ok_or("something is missing")?.clone()
            }
        };
        // Nobody can write this path in a scene.
        if new.contains('"') {
            return Err(format!("`{new}` can't be written as a path"));
        }
        put(&link.range, &link.word, &new);
    }
    cut(&file.text, thing, words).ok_or_else(|| format!("`{}` can't be read", thing.name))
}

/// Returns the text of a thing with its comments, and with changes of the whole text.
fn cut(text: &str, thing: &Thing, mut words: Vec<Edit>) -> Option<String> {
    for word in &mut words {
        word.range = word.range.start.checked_sub(thing.whole.start)?
            ..word.range.end.checked_sub(thing.whole.start)?;
    }
    applied(text.get(thing.whole.clone())?, words)
}

/// Adds segments of another camera behind the last one here, one after the other.
fn segments_added(
    text: &str,
    other: &Catalog,
    segments: &[(usize, &Thing)],
    own: &Catalog,
    names: &BTreeMap<usize, String>,
) -> Result<Vec<Edit>, String> {
    if segments.is_empty() {
        return Ok(Vec::new());
    }
    let outline = Outline::new(text);
    let last = outline.first("Camera").and_then(|camera| camera.parts("CamSegment").last());
    let last = last.ok_or("the camera of this scene stands in a file that it includes")?;
    let ends = own.files.iter().flat_map(|file| {
        let outline = Outline::new(&file.text);
        let cameras: Vec<Vec<f64>> = outline
            .elements()
            .filter(|part| part.keyword() == "Camera")
            .map(|camera| {
                camera.parts("CamSegment").filter_map(|of| time(&of, "videoEnd")).collect()
            })
            .collect();
        cameras.into_iter().flatten()
    });
    let mut end = ends.fold(0.0, f64::max);
    let mut edits = Vec::new();
    for (index, thing) in segments {
        let text = &other.files[thing.file].text;
        let outline = Outline::new(text);
        let is_it = |part: &Part<'_, '_>| part.range() == thing.range;
        let part = outline
            .elements()
            .filter(|part| part.keyword() == "Camera")
            .find_map(|camera| camera.parts("CamSegment").find(is_it));
        let unread = || format!("the times of `{}` can't be read", thing.name);
        let part = part.ok_or_else(unread)?;
        let time = |name| time(&part, name).ok_or_else(unread);
        let [start, stop] = [time("videoStart")?, time("videoEnd")?];
        let number = |of: f64| numbers(&[of], DIGITS);
        let mut words = part.set("videoStart", &number(end));
        words.extend(part.set("videoEnd", &number(end + stop - start)));
        // Scene time is what it was.
        if part.value("sceneStart").is_none() {
            words.push(part.add(&format!("sceneStart {}", number(start))));
        }
        if names[index] != thing.name {
            let name = written(&names[index]).to_string();
            words.push(Edit { range: thing.name_range.clone(), text: name });
        }
        let segment = cut(text, thing, words).ok_or_else(unread)?;
        edits.push(last.follow(segment.trim_start()));
        end += stop - start;
    }
    Ok(edits)
}

fn time(segment: &Part<'_, '_>, name: &str) -> Option<f64> {
    segment.numbers(name)?.first().copied()
}
