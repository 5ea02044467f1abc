//! Order in which the frames of a sequence are rendered.

use clap::ValueEnum;

/// Distance between the frames that come first in [`Order::Coarse`].
const COARSEST: usize = 16;

/// `--order`
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Order {
    /// As they were asked for.
    #[default]
    Forward,
    /// The last one first.
    Reverse,
    /// Every 16th, then every 8th, ... then all: what is wrong all along shows early.
    Coarse,
}

impl Order {
    /// Returns `frames` in this order.
    pub(crate) fn of(self, frames: &[i64]) -> Vec<i64> {
        match self {
            Self::Forward => frames.to_vec(),
            Self::Reverse => frames.iter().rev().copied().collect(),
            Self::Coarse => coarse(frames),
        }
    }
}

fn coarse(frames: &[i64]) -> Vec<i64> {
    let mut numbered: Vec<_> = frames.iter().copied().enumerate().collect();
    // Positions that are multiples of 16 come first, then the other multiples of 8, and so on.
    let rank = |position: usize| {
        let steps = std::iter::successors(Some(COARSEST), |step| (*step > 1).then_some(step / 2));
        steps.take_while(|step| !position.is_multiple_of(*step)).count()
    };
    numbered.sort_by_key(|&(position, _)| rank(position));
    numbered.into_iter().map(|(_, frame)| frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders() {
        assert_eq!(Order::Forward.of(&[3, 1, 2]), [3, 1, 2]);
        assert_eq!(Order::Reverse.of(&[3, 1, 2]), [2, 1, 3]);
        let frames: Vec<i64> = (100..118).collect();
        let coarse = Order::Coarse.of(&frames);
        assert_eq!(
            coarse,
            [
                100, 116, 108, 104, 112, 102, 106, 110, 114, 101, 103, 105, 107, 109, 111, 113,
                115, 117
            ]
        );
        assert_eq!(Order::Coarse.of(&[5]), [5]);
    }
}
