//! Values of settings, and which values a setting takes.

/// The value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// The setting is off, or left to the program.
    Absent,
    /// 0 or 1 in the text.
    Flag(bool),
    /// A whole number of 32 bits.
    Count(u32),
    /// A whole number of 64 bits.
    Whole(u64),
    /// A number that is kept in f32.
    Single(f32),
    /// A number that is kept in f64.
    Double(f64),
    /// Red, green, blue.
    Color([f32; 3]),
    /// One of several words.
    Word(&'static str),
    /// A word of the user's own.
    Text(String),
}

/// Which values a setting takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// 0 or 1.
    Flag,
    /// A whole number, with the least and the largest.
    Count(u32, u32),
    /// A whole number of 64 bits.
    Whole,
    /// A number that is kept in f32.
    Single(Bound),
    /// A number that is kept in f64.
    Double(Bound),
    /// Red, green, blue; none below 0.
    Color,
    /// One of these words.
    Word(&'static [&'static str]),
    /// A word of the user's own; how messages call it.
    Text(&'static str),
}

impl Form {
    /// Whether a setting may have this value, [`Value::Absent`] aside.
    pub fn takes(&self, value: &Value) -> bool {
        match (*self, value) {
            (Self::Flag, Value::Flag(_))
            | (Self::Whole, Value::Whole(_))
            | (Self::Text(_), Value::Text(_)) => true,
            (Self::Count(least, most), Value::Count(count)) => (least..=most).contains(count),
            (Self::Single(bound), Value::Single(x)) => {
                x.is_finite() && bound.broken_by(f64::from(*x)).is_none()
            }
            (Self::Double(bound), Value::Double(x)) => {
                x.is_finite() && bound.broken_by(*x).is_none()
            }
            (Self::Color, Value::Color(rgb)) => rgb.iter().all(|c| c.is_finite() && *c >= 0.0),
            (Self::Word(words), Value::Word(word)) => words.contains(word),
            _ => false,
        }
    }
}

/// What a number must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Any finite number.
    Any,
    /// 0 or more.
    NotNegative,
    /// More than 0.
    Positive,
    /// Other than 0.
    NotZero,
    /// More than 0, and at most the range from black to white.
    Error,
    /// Doublings of light, or halvings, that a screen may need.
    Stops,
    /// From 0 to 1.
    Share,
    /// 1 or more.
    AtLeastOne,
    /// From 0 to 100: things of which a sample takes a few.
    PerSample,
}

impl Bound {
    /// The rule that `value` breaks, in words for the user.
    pub fn broken_by(self, value: f64) -> Option<&'static str> {
        let (is_kept, rule) = match self {
            Self::Any => (true, ""),
            Self::NotNegative => (value >= 0.0, "must be 0 or more"),
            Self::Positive => (value > 0.0, "must be more than 0"),
            Self::NotZero => (value != 0.0, "must not be 0"),
            Self::Error => (value > 0.0 && value <= 1.0, "must be more than 0 and at most 1"),
            Self::Stops => (value.abs() <= 32.0, "must be from -32 to 32"),
            Self::Share => ((0.0..=1.0).contains(&value), "must be from 0 to 1"),
            Self::AtLeastOne => (value >= 1.0, "must be 1 or more"),
            Self::PerSample => ((0.0..=100.0).contains(&value), "must be from 0 to 100"),
        };
        (!is_kept).then_some(rule)
    }
}

/// The type of a setting's field.
pub(super) trait Held {
    /// The value of the field.
    fn value(&self) -> Value;

    /// Sets the field. A value of another type changes nothing; rows tie forms to types, so that
    /// there is none.
    fn hold(&mut self, value: Value);
}

macro_rules! held {
    ($($type:ty => $Kind:ident),+ $(,)?) => {
        $(
            impl Held for $type {
                fn value(&self) -> Value {
                    Value::$Kind(self.clone())
                }

                fn hold(&mut self, value: Value) {
                    if let Value::$Kind(value) = value {
                        *self = value;
                    }
                }
            }
        )+
    };
}

held! {
    bool => Flag,
    u32 => Count,
    u64 => Whole,
    f32 => Single,
    f64 => Double,
    [f32; 3] => Color,
    String => Text,
}

impl<T: Held + Default> Held for Option<T> {
    fn value(&self) -> Value {
        self.as_ref().map_or(Value::Absent, Held::value)
    }

    fn hold(&mut self, value: Value) {
        match value {
            Value::Absent => *self = None,
            value => self.get_or_insert_default().hold(value),
        }
    }
}
