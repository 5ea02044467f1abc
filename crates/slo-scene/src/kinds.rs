//! One list for the kinds of a thing: shapes, lights, materials.

use crate::attributes::schema::{Attribute, Schema};

/// An element of the language that gives a thing of some kind.
#[derive(Debug)]
pub(crate) struct Keyword {
    /// The first word of the element.
    pub(crate) keyword: &'static str,
    /// What it takes beside what all elements of its sort take.
    pub(crate) attributes: &'static [Attribute],
}

impl Keyword {
    /// The schema of the element, with what all elements of its sort take.
    pub(crate) const fn schema(&self, common: &'static [Attribute]) -> Schema {
        Schema::new(self.keyword, self.attributes).with(common)
    }
}

/// How things of a kind are written, and read.
#[derive(Debug)]
pub(crate) struct Kind<R: 'static> {
    /// The elements that give them.
    pub(crate) keywords: &'static [Keyword],
    /// Reads one; `None` if something is wrong, which was reported.
    pub(crate) read: R,
}

/// Defines an enum of kinds, what all of them have in common, and how each is read. The list of kinds
/// stands in this enum and nowhere else.
///
/// Each kind is a type that implements the trait `$Common`, and has a constant `KEYWORDS` (a slice of
/// [`Keyword`]s) and a function `read`.
macro_rules! kinds {
    (
        $(#[$of:meta])*
        pub enum $Kinds:ident: dyn $Common:ident, read by $Read:ident {
            $( $(#[$about:meta])* $Kind:ident($Type:ty), )+
        }
    ) => {
        $(#[$of])*
        #[derive(Clone, Debug)]
        pub enum $Kinds {
            $( $(#[$about])* $Kind($Type), )+
        }

        impl $Kinds {
            /// How each kind is written and read, in the order of messages.
            pub(crate) const KINDS: &'static [$crate::kinds::Kind<$Read>] = &[
                $( $crate::kinds::Kind {
                    keywords: <$Type>::KEYWORDS,
                    read: |fields, with| <$Type>::read(fields, with).map(Self::$Kind),
                }, )+
            ];

            /// What all kinds have in common.
            fn common(&self) -> &dyn $Common {
                match self {
                    $( Self::$Kind(kind) => kind, )+
                }
            }
        }
    };
}
pub(crate) use kinds;
