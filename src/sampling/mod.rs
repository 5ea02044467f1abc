//! Named samples: a random number is a pure function of (seed, frame, pixel, sample, dimension).

/// Which points the integral is sampled at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Generator {
    /// Independent uniform numbers.
    Pseudo,
    /// The thesis's XOR-scrambled (0,2)-sequence.
    ZeroTwo,
    /// Owen-scrambled Sobol points.
    #[default]
    Quasi,
}
