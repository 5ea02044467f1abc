//! What holds for every structure of the list.

use super::testing::Random;
use super::*;
use crate::isa::Isa;

#[test]
fn accelerators_are_found_by_the_names_that_they_show() {
    for &(name, accelerator) in Accelerator::NAMES {
        assert_eq!(accelerator.to_string(), name);
        assert_eq!(Accelerator::by_name(&name.to_lowercase()), Ok(accelerator));
    }
    assert!(Accelerator::by_name("OCTREE").is_err());
}

/// Triangles and curved surfaces, some of them twice, some without area.
fn primitives(random: &mut Random) -> Primitives {
    let (mut triangles, curved) = (random.triangles(700, 0.3), random.curved(40, 0.1));
    triangles.extend_from_within(..50);
    triangles.push([triangles[0][0]; 3]);
    Primitives { triangles, curved }
}

fn assert_geometry(structure: &Structure, primitives: &Primitives, name: &str) {
    assert_eq!(structure.triangle_count(), primitives.triangles.len(), "{name}");
    for (id, triangle) in (0..).zip(&primitives.triangles) {
        assert_eq!(structure.triangle(id), *triangle, "{name}");
    }
    assert_eq!(structure.curved(), primitives.curved, "{name}");
    assert_eq!(structure.bounds(), primitives.all_bounds(), "{name}");
    assert!(structure.memory() >= primitives.memory(), "{name}");
}

/// Bits of the answers about each ray.
fn ask(
    structure: &Structure,
    rays: &Rays,
    coherence: Coherence,
    scratch: &mut Scratch,
) -> Vec<([u32; 4], bool)> {
    let (mut hits, mut blocked) = (Hits::default(), vec![]);
    structure.intersect(rays, coherence, &mut hits, scratch);
    structure.occluded(rays, coherence, &mut blocked, scratch);
    let bits = |i: usize| {
        [hits.t[i].to_bits(), hits.u[i].to_bits(), hits.v[i].to_bits(), hits.primitive[i]]
    };
    (0..rays.len()).map(|i| (bits(i), blocked[i])).collect()
}

#[test]
fn all_structures_give_the_hits_of_brute_force() {
    let mut random = Random::new(3);
    let primitives = primitives(&mut random);
    // Far more rays than a batch has otherwise.
    let rays = random.rays(12_000, 1.0);
    let mut scratch = Scratch::default();
    let build = |accelerator, isa| Structure::build(accelerator, primitives.clone(), isa);
    let oracle = build(Accelerator::None, Isa::Portable);
    let expected = ask(&oracle, &rays, Coherence::Incoherent, &mut scratch);
    // Rays along axes miss hits in the library's structure, whose own test goes without them.
    let exact = Accelerator::NAMES.iter().filter(|(_, of)| *of != Accelerator::Cwbvh);
    for (&(name, accelerator), isa) in
        exact.flat_map(|way| Isa::available().into_iter().map(move |isa| (way, isa)))
    {
        let structure = build(accelerator, isa);
        assert_geometry(&structure, &primitives, name);
        for coherence in [Coherence::Coherent, Coherence::Incoherent] {
            let answers = ask(&structure, &rays, coherence, &mut scratch);
            for (i, (answer, expected)) in answers.iter().zip(&expected).enumerate() {
                assert_eq!(answer, expected, "{name}, {isa}, {coherence:?}, ray {i}");
            }
        }
    }
}

#[test]
fn nothing_is_hit_where_nothing_is() {
    let rays = Random::new(4).rays(100, 1.0);
    for &(name, accelerator) in Accelerator::NAMES {
        for isa in Isa::available() {
            let empty = Structure::build(accelerator, Primitives::default(), isa);
            assert!(empty.bounds().is_empty(), "{name}");
            let answers = ask(&empty, &rays, Coherence::Coherent, &mut Scratch::default());
            assert!(answers.iter().all(|a| a.0[3] == crate::NO_HIT && !a.1), "{name}, {isa}");
        }
    }
}
