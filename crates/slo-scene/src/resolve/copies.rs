//! `copy` and `copies`, and whether they come to an end.

use super::spaces::{Hangings, Hung};
use crate::assets::Assets;
use crate::attributes::{Fields, References, Referred};
use crate::description::{Copy, MOST_NESTED, MOST_SHOWN, MaterialId, Object, Original};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};

/// Most members of a ring that are named.
const MOST_NAMED: usize = 8;

/// A copy, before it is known what the numbers of its originals stand for.
pub(super) struct WrittenCopy {
    /// Number among all elements that may hang.
    pub(super) number: usize,
    title: String,
    place: Span,
    /// Numbers of the originals, with the places that name them.
    of: Vec<(usize, Span)>,
    copy: Copy,
}

/// Reads a copy; `None` if something is wrong, which is reported. Its `parent` is not known yet.
pub(super) fn read<'a>(
    number: usize,
    fields: &mut Fields<'_, 'a, '_>,
    hangings: &Hangings,
    references: &mut References<'a>,
    assets: &mut Assets<'_>,
) -> Option<WrittenCopy> {
    let words = fields.words("of")?;
    let of: Vec<_> = words
        .iter()
        .filter_map(|word| {
            let number = references.find_only(Referred::Object, *word, fields.diagnostics)?;
            Some((number, word.span))
        })
        .collect();
    let hidden = fields.count("hidden", 0, 1).is_some_and(|flag| flag.value == 1);
    let material = fields.word("material");
    let material = material.map(|word| references.find(Referred::Material, word));
    let placements = fields.get("placements").map(|_| {
        let path = fields.word("placements")?;
        assets.placements(path, fields.scale, words.len(), fields.diagnostics)
    });
    let placements = match placements {
        Some(loaded) => Some(loaded?),
        None => None,
    };
    if let (Some(places), true) = (&placements, words.len() > 1)
        && places.kinds.is_empty()
    {
        let message = format!("{} shows only the first of its originals", fields.element.title());
        let warning = Diagnostic::warning(message)
            .at(words[1].span, "this is never shown")
            .help("a column `kind` in the file of placements chooses, from 0 on");
        fields.diagnostics.push(warning);
    }
    let copy = Copy {
        name: fields.element.name.text.to_owned(),
        of: Vec::new(),
        key_frames: hangings.key_frames(number).to_vec(),
        repeat: hangings.repeat(number),
        parent: None,
        placements,
        material: match material {
            Some(found) => Some(MaterialId(found? as u32)),
            None => None,
        },
        hidden,
    };
    let (title, place) = (fields.element.title(), fields.element.head());
    Some(WrittenCopy { number, title, place, of, copy })
}

/// All that copies may show, by the number of the element.
pub(super) struct Shown<'s> {
    pub(super) objects: &'s [(Object, Span)],
    pub(super) object_numbers: &'s [usize],
    pub(super) light_numbers: &'s [usize],
    pub(super) hangings: &'s Hangings,
    pub(super) hung: &'s Hung,
}

/// Resolves what copies show. Reports copies that hold themselves, that are nested too deeply, and
/// too many of them.
pub(super) fn copies(
    written: Vec<WrittenCopy>,
    shown: &Shown<'_>,
    diagnostics: &mut Diagnostics,
) -> Vec<Copy> {
    let count = shown.hangings.count();
    let mut originals = vec![None; count];
    let mut elements: Vec<Option<Member>> = (0..count).map(|_| None).collect();
    for (index, number) in shown.object_numbers.iter().enumerate() {
        originals[*number] = Some(Original::Object(index as u32));
        let is_hidden = shown.objects[index].0.hidden;
        elements[*number] = Some(Member { is_hidden, copy: None });
    }
    for (index, number) in shown.light_numbers.iter().enumerate() {
        originals[*number] = Some(Original::Light(index as u32));
        elements[*number] = Some(Member { is_hidden: false, copy: None });
    }
    for (index, of) in written.iter().enumerate() {
        originals[of.number] = Some(Original::Copy(index as u32));
        elements[of.number] = Some(Member { is_hidden: of.copy.hidden, copy: Some(index) });
    }
    for (number, original) in originals.iter_mut().enumerate() {
        if shown.hangings.is_group(number) {
            *original = shown.hung.space(number).map(Original::Group);
        }
    }
    for of in &written {
        for (number, span) in &of.of {
            if !shown.hangings.may_hang(*number) {
                let title = shown.hangings.title(*number);
                let error = Diagnostic::error(format!("{title} can't be copied")).at(*span, "");
                diagnostics.push(error.help("shapes, groups, copies, and lamps that may move can"));
            }
        }
    }
    let walk = Walk { shown, elements, written: &written };
    walk.check(diagnostics);
    let resolved = written.into_iter().map(|of| Copy {
        of: of.of.iter().filter_map(|(number, _)| originals[*number]).collect(),
        parent: shown.hung.parent(of.number),
        ..of.copy
    });
    resolved.collect()
}

/// An object, a light or a copy.
struct Member {
    is_hidden: bool,
    /// Index of the copy.
    copy: Option<usize>,
}

/// What a walk knows of an element by itself (number 2 n), and with all that hangs in it (2 n + 1).
#[derive(Clone, Copy, Default)]
struct Known {
    is_open: bool,
    is_done: bool,
    /// How many copies are nested in it.
    depth: u32,
    /// How many things it shows.
    count: u64,
}

/// A walk from copies to all that they show.
struct Walk<'s> {
    shown: &'s Shown<'s>,
    elements: Vec<Option<Member>>,
    written: &'s [WrittenCopy],
}

impl Walk<'_> {
    fn check(&self, diagnostics: &mut Diagnostics) {
        let mut children = vec![Vec::new(); self.elements.len()];
        for number in 0..self.elements.len() {
            if let Some(parent) = self.shown.hangings.parent_of(number) {
                children[parent].push(number);
            }
        }
        let mut known = vec![Known::default(); 2 * self.elements.len()];
        let mut is_whole = true;
        for of in self.written {
            is_whole &= self.visit(2 * of.number, &children, &mut known, diagnostics);
        }
        if !is_whole {
            return;
        }
        if let Some(deep) =
            self.written.iter().find(|of| known[2 * of.number].depth == MOST_NESTED + 1)
        {
            let message = format!("{} is nested too deeply", deep.title);
            let label = format!("more than {MOST_NESTED} copies in one another");
            let span = deep.of.first().map_or(deep.place, |(_, span)| *span);
            diagnostics.push(Diagnostic::error(message).at(span, label));
            return;
        }
        let mut sum = self.shown.objects.len() as u64;
        for of in self.written.iter().filter(|of| !of.copy.hidden) {
            sum = sum.saturating_add(known[2 * of.number].count);
            if sum > MOST_SHOWN {
                let message = format!("the scene shows more than {MOST_SHOWN} things");
                let count = known[2 * of.number].count;
                let label = format!("this adds {count}");
                diagnostics.push(Diagnostic::error(message).at(of.place, label));
                return;
            }
        }
    }

    /// What an element shows directly.
    fn edges(&self, node: usize, children: &[Vec<usize>]) -> Vec<usize> {
        let number = node / 2;
        let member = self.elements[number].as_ref();
        if node % 2 == 1 {
            let own = member.filter(|member| !member.is_hidden).map(|_| 2 * number);
            let is_shown = |child: &&usize| !self.shown.hangings.is_hidden_group(**child);
            let below = children[number].iter().filter(is_shown).map(|child| 2 * child + 1);
            return own.into_iter().chain(below).collect();
        }
        let Some(copy) = member.and_then(|member| member.copy) else { return Vec::new() };
        let whole = |number: usize| usize::from(self.shown.hangings.is_group(number));
        self.written[copy].of.iter().map(|(number, _)| 2 * number + whole(*number)).collect()
    }

    /// Visits all that a node shows, and all that this shows. Returns whether there is no ring;
    /// reports one.
    fn visit(
        &self,
        start: usize,
        children: &[Vec<usize>],
        known: &mut [Known],
        diagnostics: &mut Diagnostics,
    ) -> bool {
        if known[start].is_done {
            return true;
        }
        let mut is_whole = true;
        let mut stack = vec![(start, self.edges(start, children), 0)];
        known[start].is_open = true;
        while let Some((node, edges, next)) = stack.last_mut() {
            let (node, at) = (*node, *next);
            if let Some(&edge) = edges.get(at) {
                *next += 1;
                if known[edge].is_open {
                    is_whole = false;
                    let ring = stack.iter().map(|(node, ..)| *node);
                    let ring: Vec<_> = ring.skip_while(|node| *node != edge).collect();
                    self.report_ring(&ring, diagnostics);
                } else if !known[edge].is_done {
                    known[edge].is_open = true;
                    let below = self.edges(edge, children);
                    stack.push((edge, below, 0));
                }
                continue;
            }
            let copy = self.elements[node / 2].as_ref().and_then(|member| member.copy);
            let copy = copy.filter(|_| node % 2 == 0).map(|copy| &self.written[copy].copy);
            let deepest = edges.iter().map(|edge| known[*edge].depth).max().unwrap_or(0);
            let counts = edges.iter().map(|edge| known[*edge].count);
            let count = match copy.map(|copy| copy.placements.as_deref()) {
                Some(Some(placements)) => {
                    let counts: Vec<_> = counts.collect();
                    let count = |at| counts.get(placements.kind(at) as usize).copied().unwrap_or(0);
                    (0..placements.len()).map(count).fold(0, u64::saturating_add)
                }
                Some(None) => counts.fold(0, u64::saturating_add),
                None if node % 2 == 0 => 1,
                None => counts.fold(0, u64::saturating_add),
            };
            let depth = deepest.saturating_add(u32::from(copy.is_some()));
            known[node] = Known { is_open: false, is_done: true, depth, count };
            stack.pop();
        }
        is_whole
    }

    fn report_ring(&self, ring: &[usize], diagnostics: &mut Diagnostics) {
        // Only copies and groups lead anywhere.
        let is_named = |node: &&usize| {
            let is_copy = |member: &Member| member.copy.is_some();
            let is_group = self.shown.hangings.is_group(**node / 2);
            match **node % 2 {
                0 => self.elements[**node / 2].as_ref().is_some_and(is_copy),
                _ => is_group,
            }
        };
        let copy = |node: &usize| self.elements[node / 2].as_ref()?.copy;
        let Some(first) = ring.iter().filter(|node| *node % 2 == 0).find_map(copy) else { return };
        let first = &self.written[first];
        let mut named: Vec<_> = ring.iter().filter(is_named).map(|node| node / 2).collect();
        let start = named.iter().position(|number| *number == first.number).unwrap_or(0);
        named.rotate_left(start);
        let more = if named.len() > MOST_NAMED { ", ..." } else { "" };
        let names: Vec<_> = named
            .iter()
            .take(MOST_NAMED)
            .map(|number| self.shown.hangings.title(*number))
            .collect();
        let help = format!("the ring: {}{more}, {}", names.join(", "), first.title);
        let span = first.of.first().map_or(first.place, |(_, span)| *span);
        let error = Diagnostic::error(format!("{} holds itself", first.title)).at(span, "");
        diagnostics.push(error.also(first.place, "this copy").help(help));
    }
}
