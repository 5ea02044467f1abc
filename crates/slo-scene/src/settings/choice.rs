//! Settings whose values are words.

/// A type whose values are words of the scene language.
pub trait Choice: Copy + PartialEq + 'static {
    /// All words, in the order of messages.
    const WORDS: &'static [&'static str];

    /// The word of the scene language.
    fn name(self) -> &'static str;

    /// The value of a word.
    fn by_name(name: &str) -> Option<Self>;
}

/// Defines an enum with a word for each value.
macro_rules! choices {
    ($(#[$of:meta])* pub enum $Name:ident {
        $( $(#[$about:meta])* $Value:ident = $word:literal, )+
    }) => {
        $(#[$of])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $Name {
            $( $(#[$about])* $Value, )+
        }

        impl $Name {
            /// All values, in the order of messages.
            pub const ALL: [Self; [$($word),+].len()] = [$( Self::$Value ),+];

            /// All values with their words, in the order of messages.
            pub const NAMES: [(&'static str, Self); [$($word),+].len()] =
                [$( ($word, Self::$Value) ),+];

            /// The word of the scene language.
            pub const fn name(self) -> &'static str {
                match self {
                    $( Self::$Value => $word, )+
                }
            }

            /// The value of a word.
            pub fn by_name(name: &str) -> Option<Self> {
                match name {
                    $( $word => Some(Self::$Value), )+
                    _ => None,
                }
            }
        }

        impl $crate::settings::choice::Choice for $Name {
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn name(self) -> &'static str {
                self.name()
            }

            fn by_name(name: &str) -> Option<Self> {
                Self::by_name(name)
            }
        }

        impl $crate::settings::value::Held for $Name {
            fn value(&self) -> $crate::settings::value::Value {
                $crate::settings::value::Value::Word(self.name())
            }

            fn hold(&mut self, value: $crate::settings::value::Value) {
                if let $crate::settings::value::Value::Word(word) = value
                    && let Some(found) = Self::by_name(word)
                {
                    *self = found;
                }
            }
        }

        impl std::fmt::Display for $Name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}
pub(super) use choices;
