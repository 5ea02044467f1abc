//! Work that is compiled for each kind of light, and the list of kinds.

use super::environment::{ImageSky, ImageView};
use super::lamp::Lamp;

/// Work for one light, compiled for each kind, so that it handles a whole column of hits without
/// branching on the kind.
pub trait WithLamp {
    /// Result of the work.
    type Output;

    /// Does the work.
    fn run<L: Lamp>(self, lamp: L) -> Self::Output;
}

/// Work for all lights of one kind, compiled for each kind.
pub trait WithLamps {
    /// Does the work for the lights of one table. `mine` tells whether light `i` of the frame is in
    /// the table, and `place` returns its index there, or any number if it is not. Both may be called
    /// with any number.
    fn run<L: Lamp>(
        &mut self,
        lamps: &[L],
        mine: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> usize,
    );
}

/// A light as a frame keeps it. Most are what loops use; one that owns a table lends it.
pub(super) trait Kept {
    /// What loops use: numbers and references, so that a copy costs little.
    type Lamp<'a>: Lamp
    where
        Self: 'a;

    /// Returns the light as loops use it.
    fn lamp(&self) -> Self::Lamp<'_>;

    /// Calls `work` with lights as loops use them.
    fn lend(lights: &[Self], work: impl FnOnce(&[Self::Lamp<'_>]))
    where
        Self: Sized;
}

impl<L: Lamp> Kept for L {
    type Lamp<'a>
        = L
    where
        L: 'a;

    #[inline(always)]
    fn lamp(&self) -> L {
        *self
    }

    #[inline(always)]
    fn lend(lights: &[L], work: impl FnOnce(&[L])) {
        work(lights);
    }
}

impl Kept for ImageSky {
    type Lamp<'a> = ImageView<'a>;

    fn lamp(&self) -> ImageView<'_> {
        self.view()
    }

    fn lend(lights: &[Self], work: impl FnOnce(&[ImageView<'_>])) {
        let views: Vec<_> = lights.iter().map(Self::view).collect();
        work(&views);
    }
}

/// Defines an enum of lights, and a collection of them that also has a table for each kind.
///
/// Each kind is a type that implements [`Kept`], as all do that implement [`Lamp`].
macro_rules! lamps {
    (
        $(#[$of:meta])*
        pub enum $Light:ident, all in $Lights:ident {
            $( $(#[$about:meta])* $Kind:ident($Type:ty) in $table:ident, )+
        }
    ) => {
        $(#[$of])*
        #[derive(Clone, Debug)]
        pub enum $Light {
            $( $(#[$about])* $Kind($Type), )+
        }

        impl $Light {
            /// Does work for this light.
            #[inline(always)]
            pub fn with<W: WithLamp>(&self, work: W) -> W::Output {
                match self {
                    $( Self::$Kind(light) => work.run($crate::shading::light::kinds::Kept::lamp(light)), )+
                }
            }
        }

        /// The lights of a frame. They also lie in one table for each kind, for loops in which
        /// every lane has a light of its own.
        #[derive(Clone, Debug, Default)]
        pub struct $Lights {
            all: Vec<$Light>,
            /// For each light, the number of its table.
            table: Vec<u32>,
            /// For each light, its index in its table.
            place: Vec<u32>,
            poses: $crate::shading::light::moving::Poses,
            $( $table: Vec<$Type>, )+
        }

        /// The tables.
        enum Table {
            $( $Kind, )+
        }

        impl $Lights {
            /// Calls `work` once for each kind that the frame has lights of.
            pub fn for_each_kind(&self, work: &mut impl WithLamps) {
                $(
                    if !self.$table.is_empty() {
                        <$Type as $crate::shading::light::kinds::Kept>::lend(&self.$table, |lamps| {
                            self.for_kind(Table::$Kind as u32, lamps, work);
                        });
                    }
                )+
            }

            fn for_kind<L: Lamp>(&self, table: u32, lamps: &[L], work: &mut impl WithLamps) {
                if lamps.len() == self.all.len() {
                    work.run(lamps, |_| true, |light| light as usize);
                } else {
                    // The compiler sees that the places lie inside the lists.
                    let last = |list: &[u32]| list.len().checked_sub(1);
                    let (Some(tables), Some(places)) = (last(&self.table), last(&self.place))
                    else {
                        return;
                    };
                    let mine = |light: u32| self.table[(light as usize).min(tables)] == table;
                    let place = |light: u32| self.place[(light as usize).min(places)] as usize;
                    work.run(lamps, mine, place);
                }
            }
        }

        impl FromIterator<$Light> for $Lights {
            fn from_iter<I: IntoIterator<Item = $Light>>(lights: I) -> Self {
                let mut to = Self::default();
                for light in lights {
                    match &light {
                        $( $Light::$Kind(lamp) => {
                            to.table.push(Table::$Kind as u32);
                            to.place.push(to.$table.len() as u32);
                            to.$table.push(lamp.clone());
                        } )+
                    }
                    to.all.push(light);
                }
                to
            }
        }
    };
}
pub(super) use lamps;
