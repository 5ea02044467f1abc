//! What hangs in what: groups, and the `parent` of objects, lamps and groups.

use super::{key_frames, repeat};
use crate::attributes::{Fields, References, Referred};
use crate::description::{Camera, KeyFrame, Space, SpaceId};
use crate::diagnostics::{Diagnostic, Diagnostics, Span};
use crate::settings::Repeat;

/// Most members of a ring that are named.
const MOST_NAMED: usize = 8;

/// Most elements that may hang in one another.
const MOST_DEEP: usize = 1000;

/// An element that may hang in another one, and others in it: a group, an object or a light.
#[derive(Clone, Debug)]
pub(super) struct Hanging {
    name: String,
    /// As messages call it.
    title: String,
    place: Span,
    key_frames: Vec<KeyFrame>,
    repeat: Option<Repeat>,
    /// Number of the element that it hangs in, with the place that says so.
    parent: Option<(usize, Span)>,
    is_group: bool,
    /// Whether it takes a parent at all.
    may_hang: bool,
    /// Whether it is a group with all that hangs in it out of the picture.
    is_hidden: bool,
}

impl Hanging {
    /// Reads how an element moves, and in what it hangs.
    pub(super) fn read<'a>(
        fields: &mut Fields<'_, 'a, '_>,
        references: &mut References<'a>,
        is_group: bool,
        camera: Option<&Camera>,
    ) -> Self {
        let key_frames = key_frames::key_frames(fields);
        let repeat = repeat::repeat(fields, &key_frames, camera);
        let parent = fields.word("parent").and_then(|word| {
            Some((references.find_only(Referred::Object, word, fields.diagnostics)?, word.span))
        });
        let is_hidden =
            is_group && fields.count("hidden", 0, 1).is_some_and(|flag| flag.value == 1);
        let element = &fields.element;
        let may_hang = element.schema.attribute("parent").is_some();
        let (name, title) = (element.name.text.to_owned(), element.title());
        let place = element.head();
        Self { name, title, place, key_frames, repeat, parent, is_group, may_hang, is_hidden }
    }

    /// How their motion goes on.
    pub(super) fn repeat(&self) -> Option<Repeat> {
        self.repeat
    }

    /// The key frames, in order of time.
    pub(super) fn key_frames(&self) -> &[KeyFrame] {
        &self.key_frames
    }
}

/// All elements that may hang, by their number in the text; `None` if one was not read.
#[derive(Clone, Debug, Default)]
pub(super) struct Hangings(Vec<Option<Hanging>>);

/// The spaces of a scene, and which of them each element hangs in.
#[derive(Debug, Default)]
pub(super) struct Hung {
    pub(super) spaces: Vec<Space>,
    /// By the number of the element.
    parents: Vec<Option<SpaceId>>,
    /// By the number of the element.
    ids: Vec<Option<SpaceId>>,
}

impl Hung {
    /// What an element hangs in.
    pub(super) fn parent(&self, number: usize) -> Option<SpaceId> {
        self.parents.get(number).copied().flatten()
    }

    /// The space of an element, if others hang in it or it is a group.
    pub(super) fn space(&self, number: usize) -> Option<SpaceId> {
        self.ids.get(number).copied().flatten()
    }
}

impl Hangings {
    /// Adds the element with this number.
    pub(super) fn insert(&mut self, number: usize, hanging: Hanging) {
        if self.0.len() <= number {
            self.0.resize(number + 1, None);
        }
        self.0[number] = Some(hanging);
    }

    /// Number of all elements that may hang.
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    fn get(&self, number: usize) -> Option<&Hanging> {
        self.0.get(number)?.as_ref()
    }

    /// The key frames of an element, in order of time.
    pub(super) fn key_frames(&self, number: usize) -> &[KeyFrame] {
        self.get(number).map_or(&[], |of| &of.key_frames)
    }

    /// How the motion of an element goes on.
    pub(super) fn repeat(&self, number: usize) -> Option<Repeat> {
        self.get(number)?.repeat
    }

    /// Whether an element is a group.
    pub(super) fn is_group(&self, number: usize) -> bool {
        self.get(number).is_some_and(|of| of.is_group)
    }

    /// Whether an element is a group that is out of the picture.
    pub(super) fn is_hidden_group(&self, number: usize) -> bool {
        self.get(number).is_some_and(|of| of.is_hidden)
    }

    /// Whether an element takes a parent at all.
    pub(super) fn may_hang(&self, number: usize) -> bool {
        self.get(number).is_none_or(|of| of.may_hang)
    }

    /// As messages call an element.
    pub(super) fn title(&self, number: usize) -> &str {
        self.get(number).map_or("", |of| &of.title)
    }

    /// Number of the element that one hangs in.
    pub(super) fn parent_of(&self, number: usize) -> Option<usize> {
        self.parent(number).map(|(parent, _)| parent)
    }

    fn parent(&self, number: usize) -> Option<(usize, Span)> {
        self.0.get(number)?.as_ref()?.parent
    }

    /// Reports elements that hang too deep in one another: everything in them moves by the product of all.
    fn report_depth(&self, diagnostics: &mut Diagnostics) -> bool {
        // From 1; 0: not known yet.
        let mut depths = vec![0; self.count()];
        for number in 0..depths.len() {
            let (mut chain, mut next) = (Vec::new(), Some(number));
            while let Some(number) = next.filter(|number| depths[*number] == 0) {
                chain.push(number);
                next = self.parent_of(number);
            }
            let above = next.map_or(0, |number| depths[number]);
            for (number, depth) in chain.into_iter().rev().zip(above + 1..) {
                depths[number] = depth;
            }
        }
        let first = depths.iter().position(|depth| *depth > MOST_DEEP);
        let Some(first) = first.and_then(|number| self.get(number)) else { return false };
        let message = format!("more than {MOST_DEEP} elements hang in one another");
        diagnostics.push(Diagnostic::error(message).at(first.place, "this is too deep"));
        true
    }

    /// Gives each group, and everything that has children, a space. Reports rings.
    pub(super) fn hang(&self, diagnostics: &mut Diagnostics) -> Hung {
        if self.report_rings(diagnostics) || self.report_depth(diagnostics) {
            return Hung::default();
        }
        let mut has_children = vec![false; self.0.len()];
        for number in 0..self.0.len() {
            if let Some((parent, _)) = self.parent(number) {
                has_children[parent] = true;
            }
        }
        let mut count = 0;
        let number_of = |(hanging, has_children): (&Option<Hanging>, bool)| {
            let is_space = has_children || hanging.as_ref().is_some_and(|of| of.is_group);
            is_space.then(|| {
                count += 1;
                SpaceId(count - 1)
            })
        };
        let ids: Vec<_> = self.0.iter().zip(has_children).map(number_of).collect();
        let parent = |number| self.parent(number).and_then(|(parent, _)| *ids.get(parent)?);
        let parents: Vec<_> = (0..self.0.len()).map(parent).collect();
        let space = |(number, of): (usize, &Option<Hanging>)| {
            ids[number]?;
            let of = of.as_ref();
            Some(Space {
                name: of.map_or_else(String::new, |of| of.name.clone()),
                key_frames: of.map_or_else(Vec::new, |of| of.key_frames.clone()),
                repeat: of.and_then(|of| of.repeat),
                parent: parents[number],
                hidden: of.is_some_and(|of| of.is_hidden),
            })
        };
        let spaces = self.0.iter().enumerate().filter_map(space).collect();
        Hung { spaces, parents, ids }
    }

    /// Reports elements that hang in themselves, directly or by others. Returns whether there are any.
    fn report_rings(&self, diagnostics: &mut Diagnostics) -> bool {
        // The walk that came by: from its own start on, each element has one way to go.
        let mut walks = vec![None; self.0.len()];
        let mut any = false;
        for start in 0..self.0.len() {
            let mut at = start;
            while walks[at].is_none() {
                walks[at] = Some(start);
                match self.parent(at) {
                    Some((parent, _)) => at = parent,
                    None => break,
                }
            }
            if walks[at] == Some(start) && self.parent(at).is_some() {
                any = true;
                diagnostics.push(self.ring(at));
            }
        }
        any
    }

    /// The error about the ring that an element is part of.
    fn ring(&self, member: usize) -> Diagnostic {
        let mut ring = vec![member];
        let mut at = member;
        while let Some((parent, _)) = self.parent(at)
            && parent != member
        {
            ring.push(parent);
            at = parent;
        }
        // It begins with what comes first in the text.
        let first = ring.iter().enumerate().min_by_key(|(_, number)| **number);
        let first = first.map_or(0, |(place, _)| place);
        ring.rotate_left(first);
        let named = |number: usize| self.title(number);
        let place = |number: usize| self.parent(number).map(|(_, span)| span);
        let Some(written) = place(ring[0]) else { return Diagnostic::error("a ring of parents") };
        let [only] = ring[..] else {
            let mut names: Vec<_> =
                ring.iter().take(MOST_NAMED).map(|number| named(*number)).collect();
            if ring.len() > MOST_NAMED {
                names.push("...");
            }
            let message = format!("{} hangs in itself", named(ring[0]));
            let help = format!("the ring: {} in {}", names.join(" in "), named(ring[0]));
            let mut error = Diagnostic::error(message).at(written, "its parent").help(help);
            for &number in ring[1..].iter().take(MOST_NAMED - 1) {
                if let Some(span) = place(number) {
                    error = error.also(span, format!("the parent of {}", named(number)));
                }
            }
            return error;
        };
        Diagnostic::error(format!("{} is its own parent", named(only))).at(written, "")
    }

    /// Warns of groups in which nothing hangs.
    pub(super) fn warn_unused(&self, diagnostics: &mut Diagnostics) {
        let mut is_used = vec![false; self.0.len()];
        for number in 0..self.0.len() {
            if let Some((parent, _)) = self.parent(number) {
                is_used[parent] = true;
            }
        }
        for (hanging, is_used) in self.0.iter().zip(is_used) {
            if let Some(hanging) = hanging.as_ref().filter(|of| of.is_group && !is_used) {
                let message = format!("nothing hangs in {}", hanging.title);
                let help = format!("write `parent {}` in what it holds", hanging.name);
                let warning = Diagnostic::warning(message).at(hanging.place, "").help(help);
                diagnostics.push(warning);
            }
        }
    }
}
