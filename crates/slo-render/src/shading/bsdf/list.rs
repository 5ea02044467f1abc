//! Work that is compiled for each kind of lobe, and the list of kinds.

use super::lobe::Lobe;

/// Work for the lobes of one kind.
pub trait WithLobe {
    /// Does the work for a lobe that some hits have.
    fn run<L: Lobe>(&mut self, lobe: &L);
}

/// Work that changes the lobes of one kind.
pub trait WithLobeMut {
    /// Does the work for a lobe that some hits have.
    fn run<L: Lobe>(&mut self, lobe: &mut L);
}

/// Work for the lobes of one kind in two sets.
pub trait WithLobes {
    /// Does the work for a lobe that some hits of the first set have.
    fn run<L: Lobe>(&mut self, lobe: &L, other: &L);
}

/// Defines the struct that holds the columns of every kind of lobe. Each kind is a type that
/// implements [`Lobe`] and `Default`.
macro_rules! lobes {
    (
        $(#[$of:meta])*
        pub struct $Bsdf:ident {
            $( $(#[$about:meta])* pub $lobe:ident: $Type:ty, )+
        }
    ) => {
        $(#[$of])*
        #[derive(Debug, Default)]
        pub struct $Bsdf {
            $( $(#[$about])* pub $lobe: Box<$Type>, )+
        }

        impl $Bsdf {
            /// Marks all lobes as absent.
            pub fn clear(&mut self) {
                $( self.$lobe.share_mut().is_present = false; )+
            }

            /// Calls `work` once for each kind of lobe that is present, in the order of the list.
            #[inline(always)]
            pub fn for_each(&self, work: &mut impl WithLobe) {
                $(
                    if self.$lobe.share().is_present {
                        work.run(&*self.$lobe);
                    }
                )+
            }

            /// Calls `work` once for each kind of lobe that is present here, with that of `other`.
            #[inline(always)]
            pub fn for_each_with(&self, other: &Self, work: &mut impl WithLobes) {
                $(
                    if self.$lobe.share().is_present {
                        work.run(&*self.$lobe, &*other.$lobe);
                    }
                )+
            }

            /// Calls `work` once for each kind of lobe that is present, in the order of the list.
            #[inline(always)]
            pub fn for_each_mut(&mut self, work: &mut impl WithLobeMut) {
                $(
                    if self.$lobe.share().is_present {
                        work.run(&mut *self.$lobe);
                    }
                )+
            }
        }
    };
}
pub(super) use lobes;
