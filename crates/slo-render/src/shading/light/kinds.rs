//! Work that is compiled for each kind of light, and the list of kinds.

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
    /// the table, and `place` returns its index there; `place` may be called for any light of the
    /// frame.
    fn run<L: Lamp>(
        &mut self,
        lamps: &[L],
        mine: impl Fn(u32) -> bool,
        place: impl Fn(u32) -> usize,
    );
}

/// Defines an enum of lights, and a collection of them that also has a table for each kind.
///
/// The kinds have the same names as in slo-scene. Each is a type that implements [`Lamp`], with a
/// function `new` that takes the light of the scene and the origin of render space.
macro_rules! lamps {
    (
        $(#[$of:meta])*
        pub enum $Light:ident, all in $Lights:ident {
            $( $(#[$about:meta])* $Kind:ident($Type:ty) in $table:ident, )+
        }
    ) => {
        $(#[$of])*
        #[derive(Clone, Copy, Debug)]
        pub enum $Light {
            $( $(#[$about])* $Kind($Type), )+
        }

        impl $Light {
            /// Converts a light of the scene; `origin` is the origin of render space in scene
            /// space.
            pub fn new(light: &slo_scene::Light, origin: glam::DVec3) -> Option<Self> {
                match &light.kind {
                    $( slo_scene::LightKind::$Kind(light) => Some(Self::$Kind(<$Type>::new(light, origin))), )+
                    _ => None,
                }
            }

            /// Does work for this light.
            #[inline(always)]
            pub fn with<W: WithLamp>(&self, work: W) -> W::Output {
                match *self {
                    $( Self::$Kind(lamp) => work.run(lamp), )+
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
            $( $table: Vec<$Type>, )+
        }

        /// The tables.
        enum Table {
            $( $Kind, )+
        }

        impl $Lights {
            /// Calls `work` once for each kind that the frame has lights of.
            pub fn for_each_kind(&self, work: &mut impl WithLamps) {
                $( self.for_kind(Table::$Kind as u32, &self.$table, work); )+
            }

            fn for_kind<L: Lamp>(&self, table: u32, lamps: &[L], work: &mut impl WithLamps) {
                if lamps.len() == self.all.len() {
                    work.run(lamps, |_| true, |light| light as usize);
                } else if !lamps.is_empty() {
                    let mine = |light: u32| self.table[light as usize] == table;
                    let place =
                        |light: u32| (self.place[light as usize] as usize).min(lamps.len() - 1);
                    work.run(lamps, mine, place);
                }
            }
        }

        impl FromIterator<$Light> for $Lights {
            fn from_iter<I: IntoIterator<Item = $Light>>(lights: I) -> Self {
                let mut to = Self::default();
                for light in lights {
                    to.all.push(light);
                    match light {
                        $( $Light::$Kind(lamp) => {
                            to.table.push(Table::$Kind as u32);
                            to.place.push(to.$table.len() as u32);
                            to.$table.push(lamp);
                        } )+
                    }
                }
                to
            }
        }
    };
}
pub(super) use lamps;
