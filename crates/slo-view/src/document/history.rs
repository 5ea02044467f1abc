//! Changes of a text, which can be taken back and repeated.

use std::ops::Range;

use crate::sculpting::Sculptures;

/// Most changes that are remembered.
const MOST: usize = 1000;
/// Most bytes that they may take.
const MOST_BYTES: usize = 32 << 20;

/// A change: what stood in a range before it, and what stands there after it.
#[derive(Clone, Debug)]
struct Step {
    start: usize,
    before: String,
    after: String,
    what: String,
    join: bool,
    /// Meshes that were no files yet before it, and after it.
    meshes: [Sculptures; 2],
}

/// What a history is about.
#[derive(Clone, Copy, Debug)]
pub(super) struct State<'a> {
    pub(super) text: &'a str,
    pub(super) meshes: &'a Sculptures,
}

/// Changes of a text.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    steps: Vec<Step>,
    /// Number of steps that have not been taken back.
    done: usize,
    bytes: usize,
}

impl History {
    /// What the next undo takes back, and the next redo repeats.
    pub(super) fn next(&self) -> [Option<&str>; 2] {
        let what = |index: usize| self.steps.get(index).map(|step| &*step.what);
        [self.done.checked_sub(1).and_then(what), what(self.done)]
    }

    /// Remembers a change.
    pub(super) fn add(&mut self, old: State<'_>, new: State<'_>, what: &str, join: bool) {
        self.steps.truncate(self.done);
        if join && let Some(last) = self.steps.last().filter(|last| last.join && last.what == what)
        {
            // Both changes are one: from the text before the first.
            let (mut first, mut meshes) = (old.text.to_owned(), Sculptures::default());
            last.go(&mut first, &mut meshes, true);
            self.steps.pop();
            let first = State { text: &first, meshes: &meshes };
            self.steps.extend(Step::between(first, new, what, join));
        } else {
            self.steps.extend(Step::between(old, new, what, join));
        }
        self.bytes = self.steps.iter().map(Step::bytes).sum();
        while self.steps.len() > MOST || (self.bytes > MOST_BYTES && self.steps.len() > 1) {
            self.bytes -= self.steps.remove(0).bytes();
        }
        self.done = self.steps.len();
    }

    /// No later change joins the last one.
    pub(super) fn seal(&mut self) {
        if let Some(last) = self.steps.last_mut() {
            last.join = false;
        }
    }

    /// Takes a change back; false if there is none.
    pub(super) fn undo(&mut self, text: &mut String, meshes: &mut Sculptures) -> bool {
        let Some(index) = self.done.checked_sub(1) else { return false };
        self.steps[index].go(text, meshes, true);
        self.done = index;
        true
    }

    /// Repeats a change; false if there is none.
    pub(super) fn redo(&mut self, text: &mut String, meshes: &mut Sculptures) -> bool {
        let Some(step) = self.steps.get(self.done) else { return false };
        step.go(text, meshes, false);
        self.done += 1;
        true
    }
}

impl Step {
    /// The change from one text to another; `None` if they are the same.
    fn between(old: State<'_>, new: State<'_>, what: &str, join: bool) -> Option<Self> {
        let meshes = [old.meshes.clone(), new.meshes.clone()];
        let (old, new) = (old.text, new.text);
        let common =
            |pairs: &mut dyn Iterator<Item = (u8, u8)>| pairs.take_while(|(a, b)| a == b).count();
        let mut start = common(&mut old.bytes().zip(new.bytes()));
        while !old.is_char_boundary(start) || !new.is_char_boundary(start) {
            start -= 1;
        }
        let mut end = common(&mut old[start..].bytes().rev().zip(new[start..].bytes().rev()));
        while !old.is_char_boundary(old.len() - end) || !new.is_char_boundary(new.len() - end) {
            end -= 1;
        }
        let part = |text: &str| text[start..text.len() - end].to_owned();
        let (before, after) = (part(old), part(new));
        let differs = before != after || meshes[0] != meshes[1];
        let what = what.to_owned();
        differs.then_some(Self { start, before, after, what, join, meshes })
    }

    fn go(&self, text: &mut String, meshes: &mut Sculptures, back: bool) {
        *meshes = self.meshes[usize::from(!back)].clone();
        let (from, to) =
            if back { (&self.after, &self.before) } else { (&self.before, &self.after) };
        let range: Range<usize> = self.start..self.start + from.len();
        debug_assert_eq!(text.get(range.clone()), Some(from.as_str()));
        text.replace_range(range, to);
    }

    fn bytes(&self) -> usize {
        self.before.len()
            + self.after.len()
            + self.what.len()
            + self.meshes[1].bytes()
            + size_of::<Self>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds a change of the text alone.
    fn add(history: &mut History, old: &str, new: &str, what: &str) {
        let none = Sculptures::default();
        let state = |text| State { text, meshes: &none };
        history.add(state(old), state(new), what, false);
    }

    #[test]
    fn only_so_much_is_remembered() {
        let mut history = History::default();
        let (mut text, mut meshes) = (String::new(), Sculptures::default());
        for i in 0..MOST + 10 {
            let new = format!("{i}");
            add(&mut history, &text, &new, "number");
            text = new;
        }
        let mut count = 0;
        while history.undo(&mut text, &mut meshes) {
            count += 1;
        }
        assert_eq!((count, &*text), (MOST, "9"));
    }

    #[test]
    fn characters_stay_whole() {
        let mut history = History::default();
        let (mut text, mut meshes) = ("ä".to_owned(), Sculptures::default());
        for new in ["ö", "öä", "ä"] {
            add(&mut history, &text, new, "");
            text = new.to_owned();
        }
        for old in ["öä", "ö", "ä"] {
            assert!(history.undo(&mut text, &mut meshes));
            assert_eq!(text, old);
        }
    }
}
