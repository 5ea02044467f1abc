//! What the program knows of one setting.

use std::marker::PhantomData;

use super::choice::Choice;
use super::value::{Bound, Form, Value};

/// What of a picture depends on a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Nothing: only how fast the picture is made, or where it goes. Recipes do not hold it.
    Nothing,
    /// What a sample brings: pictures with different values have no sample in common.
    Samples,
    /// How many samples a pixel takes, and nothing about any of them.
    Count,
    /// How samples become the values of a file. The samples, and states of them, serve any value.
    Display,
}

/// Whether a recipe holds a setting that the picture depends on.
#[derive(Clone, Copy, Debug)]
enum Recorded<S> {
    Always,
    /// Left out at its default: settings that came later than pictures without them.
    UnlessDefault,
    /// Left out where the picture is the same as with the default.
    If(fn(&S) -> bool),
}

/// Where in a recipe a setting stands: the first recipes had another order than the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    First,
    InOrder,
    Last,
}

/// A setting: a field of `S` by its name in the language.
#[derive(Debug)]
pub struct Entry<S> {
    /// The name in scenes and in recipes.
    pub name: &'static str,
    /// Which values it takes.
    pub form: Form,
    /// Whether a scene must have it.
    pub is_required: bool,
    /// What of a picture depends on it.
    pub effect: Effect,
    recorded: Recorded<S>,
    place: Place,
    /// The value that applies if none is set.
    otherwise: Option<fn(&S) -> Value>,
    get: fn(&S) -> Value,
    set: fn(&mut S, Value),
}

/// An element of the language whose attributes are [`Entry`]s.
pub trait Entries: Default + 'static {
    /// All, in the order of messages.
    const ENTRIES: &'static [Entry<Self>];
}

impl<S: Entries> Entry<S> {
    /// The value that is set.
    pub fn get(&self, of: &S) -> Value {
        (self.get)(of)
    }

    /// The value that applies: if none is set, other settings may say which.
    pub fn applied(&self, of: &S) -> Value {
        match (self.get(of), self.otherwise) {
            (Value::Absent, Some(otherwise)) => otherwise(of),
            (value, _) => value,
        }
    }

    /// Sets the value, if it is one that the setting takes.
    #[must_use]
    pub fn set(&self, of: &mut S, value: Value) -> bool {
        let is_taken = self.form.takes(&value);
        if is_taken {
            (self.set)(of, value);
        }
        is_taken
    }

    /// Whether recipes hold the setting with its present value.
    fn is_recorded(&self, of: &S) -> bool {
        self.effect != Effect::Nothing
            && match self.recorded {
                Recorded::Always => true,
                Recorded::UnlessDefault => self.get(of) != self.get(&S::default()),
                Recorded::If(is_recorded) => is_recorded(of),
            }
    }

    /// Reads the setting back from a recipe: `found` is what stands there. `None` where it can't be.
    fn restore(&self, of: &mut S, found: Option<Value>) -> Option<()> {
        match (found, &self.recorded) {
            (_, _) if self.effect == Effect::Nothing => {}
            (Some(value), _) => return self.set_back(of, value),
            (None, Recorded::Always) => return None,
            // Any value that would not stand there makes the same picture.
            (None, _) if self.is_recorded(of) => (self.set)(of, self.get(&S::default())),
            (None, _) => {}
        }
        Some(())
    }

    /// Sets the value that a recipe holds, or none if that value applies anyway.
    fn set_back(&self, of: &mut S, value: Value) -> Option<()> {
        self.form.takes(&value).then_some(())?;
        let applies = self.otherwise.is_some_and(|otherwise| otherwise(of) == value);
        (self.set)(of, if applies { Value::Absent } else { value });
        Some(())
    }
}

/// The settings that a recipe holds, in its order.
pub fn recorded<S: Entries>(of: &S) -> Vec<(&'static str, Value)> {
    let mut entries: Vec<_> = S::ENTRIES.iter().filter(|entry| entry.is_recorded(of)).collect();
    entries.sort_by_key(|entry| entry.place);
    entries.into_iter().map(|entry| (entry.name, entry.applied(of))).collect()
}

/// The name of the first setting whose value is not one that it takes; `None` if all are.
pub fn invalid<S: Entries>(of: &S) -> Option<&'static str> {
    let is_invalid = |entry: &&Entry<S>| match entry.get(of) {
        Value::Absent => false,
        value => !entry.form.takes(&value),
    };
    S::ENTRIES.iter().find(is_invalid).map(|entry| entry.name)
}

/// Sets the settings with certain effects as a recipe has them; the others stay. `find` gives what stands
/// there for a setting: `Ok(None)` for nothing. `None` where a value can't be, or is missing.
pub fn restore<S: Entries>(
    of: &mut S,
    effects: &[Effect],
    find: impl Fn(&Entry<S>) -> Result<Option<Value>, ()>,
) -> Option<()> {
    let mut entries = S::ENTRIES.iter().filter(|entry| effects.contains(&entry.effect));
    entries.try_for_each(|entry| entry.restore(of, find(entry).ok()?))
}

/// An entry as it is written in the list, before it is tied to its field of type `T`.
pub(super) struct Row<S, T> {
    name: &'static str,
    form: Form,
    is_required: bool,
    effect: Effect,
    recorded: Recorded<S>,
    place: Place,
    otherwise: Option<fn(&S) -> Value>,
    field: PhantomData<fn() -> T>,
}

/// A field that holds a `T`, or may hold one.
pub(super) trait Of<T> {}
impl<T> Of<T> for T {}
impl<T> Of<T> for Option<T> {}

/// 0 or 1.
pub(super) const fn flag<S, T: Of<bool>>(name: &'static str, effect: Effect) -> Row<S, T> {
    Row::new(name, Form::Flag, effect)
}

/// A whole number in a range.
pub(super) const fn count<S, T: Of<u32>>(
    name: &'static str,
    [least, most]: [u32; 2],
    effect: Effect,
) -> Row<S, T> {
    Row::new(name, Form::Count(least, most), effect)
}

/// A whole number of 64 bits.
pub(super) const fn whole<S, T: Of<u64>>(name: &'static str, effect: Effect) -> Row<S, T> {
    Row::new(name, Form::Whole, effect)
}

/// A number that is kept in f32.
pub(super) const fn single<S, T: Of<f32>>(
    name: &'static str,
    bound: Bound,
    effect: Effect,
) -> Row<S, T> {
    Row::new(name, Form::Single(bound), effect)
}

/// A number that is kept in f64.
pub(super) const fn double<S, T: Of<f64>>(
    name: &'static str,
    bound: Bound,
    effect: Effect,
) -> Row<S, T> {
    Row::new(name, Form::Double(bound), effect)
}

/// Red, green, blue.
pub(super) const fn color<S, T: Of<[f32; 3]>>(name: &'static str, effect: Effect) -> Row<S, T> {
    Row::new(name, Form::Color, effect)
}

/// One of the words of a type.
pub(super) const fn choice<S, C: Choice>(name: &'static str, effect: Effect) -> Row<S, C> {
    Row::new(name, Form::Word(C::WORDS), effect)
}

/// One of the words of a type; without one, other settings decide.
pub(super) const fn optional_choice<S, C: Choice>(
    name: &'static str,
    effect: Effect,
) -> Row<S, Option<C>> {
    Row::new(name, Form::Word(C::WORDS), effect)
}

/// A word of the user's own; `what` is how messages call it.
pub(super) const fn text<S, T: Of<String>>(
    name: &'static str,
    what: &'static str,
    effect: Effect,
) -> Row<S, T> {
    Row::new(name, Form::Text(what), effect)
}

impl<S, T> Row<S, T> {
    const fn new(name: &'static str, form: Form, effect: Effect) -> Self {
        let (recorded, place) = (Recorded::Always, Place::InOrder);
        let (otherwise, field) = (None, PhantomData);
        Self { name, form, is_required: false, effect, recorded, place, otherwise, field }
    }

    /// A scene must have it.
    pub(super) const fn required(mut self) -> Self {
        self.is_required = true;
        self
    }

    /// Recipes leave it out at its default.
    pub(super) const fn unless_default(mut self) -> Self {
        self.recorded = Recorded::UnlessDefault;
        self
    }

    /// Recipes leave it out where `is_recorded` is false: the picture is the same as with the default.
    pub(super) const fn recorded_if(mut self, is_recorded: fn(&S) -> bool) -> Self {
        self.recorded = Recorded::If(is_recorded);
        self
    }

    /// It stands before the others in recipes.
    pub(super) const fn first(mut self) -> Self {
        self.place = Place::First;
        self
    }

    /// It stands behind the others in recipes.
    pub(super) const fn last(mut self) -> Self {
        self.place = Place::Last;
        self
    }

    /// If it is not set, `otherwise` gives the value that applies. It may look at settings that stand
    /// before this one in the list.
    pub(super) const fn otherwise(self, otherwise: fn(&S) -> Value) -> Row<S, Option<T>> {
        let Self { name, form, is_required, effect, recorded, place, .. } = self;
        let (otherwise, field) = (Some(otherwise), PhantomData);
        Row { name, form, is_required, effect, recorded, place, otherwise, field }
    }

    /// Ties the row to its field.
    pub(super) const fn entry(self, get: fn(&S) -> Value, set: fn(&mut S, Value)) -> Entry<S> {
        let Self { name, form, is_required, effect, recorded, place, otherwise, .. } = self;
        Entry { name, form, is_required, effect, recorded, place, otherwise, get, set }
    }
}

/// Defines a struct of settings: each line is a field, its type, its default and its row. Fields that
/// are no attributes of the language stand behind `beside`, without a row.
macro_rules! entries {
    (
        $(#[$of:meta])*
        pub struct $Name:ident {
            $( $(#[$about:meta])* $field:ident: $type:ty = $default:expr, $row:expr; )+
        }
        $( beside { $( $(#[$more:meta])* $other:ident: $other_type:ty = $other_default:expr; )+ } )?
    ) => {
        $(#[$of])*
        pub struct $Name {
            $( $(#[$about])* pub $field: $type, )+
            $( $( $(#[$more])* pub $other: $other_type, )+ )?
        }

        impl Default for $Name {
            fn default() -> Self {
                Self {
                    $( $field: $default, )+
                    $( $( $other: $other_default, )+ )?
                }
            }
        }

        impl $crate::settings::entry::Entries for $Name {
            const ENTRIES: &'static [$crate::settings::entry::Entry<Self>] = &[$({
                let row: $crate::settings::entry::Row<$Name, $type> = $row;
                row.entry(
                    |of| $crate::settings::value::Held::value(&of.$field),
                    |of, value| $crate::settings::value::Held::hold(&mut of.$field, value),
                )
            }),+];
        }
    };
}
pub(super) use entries;
