//! Which materials are mixed from which.

use crate::material::{Material, MaterialKind};

/// How far the search has come with a material.
#[derive(Clone, Copy, PartialEq)]
enum State {
    New,
    Open,
    Done,
}

/// The indices of all materials, each after those that it is mixed from.
///
/// # Errors
/// Materials of which each is mixed from the next, and the last from the first.
pub(crate) fn mix_order(materials: &[Material]) -> Result<Vec<usize>, Vec<usize>> {
    let part = |index: usize, number: usize| match &materials[index].kind {
        MaterialKind::Mix(mix) => Some(*[mix.first.0, mix.second.0].get(number)? as usize),
        _ => None,
    };
    let mut states = vec![State::New; materials.len()];
    let mut order = Vec::with_capacity(materials.len());
    for start in 0..materials.len() {
        // Materials from `start` on, each a part of the one before it, with how many of their own
        // parts were visited.
        let mut path = Vec::new();
        if states[start] == State::New {
            states[start] = State::Open;
            path.push((start, 0));
        }
        while let Some((index, visited)) = path.last_mut() {
            let Some(next) = part(*index, *visited) else {
                states[*index] = State::Done;
                order.push(*index);
                path.pop();
                continue;
            };
            *visited += 1;
            match states[next] {
                State::New => {
                    states[next] = State::Open;
                    path.push((next, 0));
                }
                State::Open => {
                    let circle = path.iter().map(|(index, _)| *index);
                    return Err(circle.skip_while(|index| *index != next).collect());
                }
                State::Done => {}
            }
        }
    }
    Ok(order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::MaterialId;
    use crate::material::{Mix, Phong, PhongInfo, Varying};

    /// Materials by their parts; without parts, a plain one.
    fn materials(parts: &[Option<[u32; 2]>]) -> Vec<Material> {
        let kind = |parts: &Option<[u32; 2]>| match parts.map(|parts| parts.map(MaterialId)) {
            None => MaterialKind::Phong(Phong { info: PhongInfo::default(), texture: None }),
            Some([first, second]) => {
                MaterialKind::Mix(Mix { first, second, factor: Varying::constant(0.5) })
            }
        };
        let material = |parts| Material { name: String::new(), kind: kind(parts) };
        parts.iter().map(material).collect()
    }

    #[test]
    fn parts_come_first() {
        let order = mix_order(&materials(&[Some([2, 1]), None, Some([1, 3]), Some([1, 1])]));
        assert_eq!(order, Ok(vec![1, 3, 2, 0]));
        assert_eq!(mix_order(&[]), Ok(vec![]));
    }

    #[test]
    fn circles_are_found() {
        let circle = |parts: &[_]| mix_order(&materials(parts)).unwrap_err();
        assert_eq!(circle(&[Some([0, 0])]), [0]);
        assert_eq!(circle(&[None, Some([0, 2]), Some([3, 0]), Some([0, 2])]), [2, 3]);
    }

    #[test]
    fn deep_and_doubled_mixes_take_no_time() {
        let last = 100_000_u32;
        let doubled = |i: u32| (i < last).then_some([i + 1, i + 1]);
        let parts: Vec<_> = (0..=last).map(doubled).collect();
        let order = mix_order(&materials(&parts)).unwrap();
        assert_eq!((order.len(), order[0]), (parts.len(), last as usize));
    }
}
