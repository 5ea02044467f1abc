//! What holds for every structure of the list.

use rand::RngExt;

use super::testing::Random;
use super::*;
use crate::isa::Isa;

#[test]
fn accelerators_are_found_by_the_names_that_they_show() {
    for &(name, accelerator) in Accelerator::NAMES {
        assert_eq!(accelerator.to_string(), name);
        assert_eq!(Accelerator::by_name(&name.to_lowercase()), Ok(accelerator));
    }
    assert!(Accelerator::by_name("QUADTREE").is_err());
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

/// Rays that are counted find what the others find, whatever they visit.
#[test]
fn counted_rays_find_the_hits_of_brute_force() {
    let mut random = Random::new(7);
    let primitives = primitives(&mut random);
    let rays = random.rays(1500, 1.0);
    let mut scratch = Scratch::default();
    let oracle = Structure::build(Accelerator::None, primitives.clone(), Isa::Portable);
    let expected = ask(&oracle, &rays, Coherence::Incoherent, &mut scratch);
    for &(name, accelerator) in Accelerator::NAMES {
        let mut sums = vec![];
        for isa in Isa::available() {
            let structure = Structure::build(accelerator, primitives.clone(), isa);
            assert_eq!(structure.can_count(), accelerator != Accelerator::Cwbvh);
            if !structure.can_count() {
                continue;
            }
            let mut sum = [study::Counts::default(); 2];
            for (i, ([t, ..], blocked)) in expected.iter().enumerate() {
                let found = structure.count(&rays, i, false, &mut scratch, &mut sum[0]);
                assert_eq!(found.to_bits(), *t, "{name}, {isa}, ray {i}");
                let any = structure.count(&rays, i, true, &mut scratch, &mut sum[1]);
                assert_eq!(any < f32::INFINITY, *blocked, "{name}, {isa}, ray {i}");
            }
            assert!(sum[0].tests > sum[1].tests && sum[1].tests > 0, "{name}: {sum:?}");
            let of_all = 1500 * primitives.len() as u64;
            let saves = accelerator != Accelerator::None;
            assert_eq!(saves, sum[0].tests < of_all / 10, "{name}: {sum:?}");
            sums.push(sum);
        }
        assert!(sums.iter().all(|sum| *sum == sums[0]), "{name}: the same on every machine");
        let structure = Structure::build(accelerator, primitives.clone(), Isa::Portable);
        if let Some(of) = structure.statistics() {
            assert!(of.references >= 750 && of.sah > 1.0 && of.bytes > 0, "{name}: {of:?}");
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

/// Sections in memory.
impl Sections for Vec<Vec<u8>> {
    fn length(&self, section: usize) -> Option<usize> {
        self.get(section).map(Vec::len)
    }

    fn read(&self, section: usize, to: &mut [u8]) -> bool {
        to.copy_from_slice(&self[section]);
        true
    }
}

/// What is kept of a structure over primitives; `None` if it can't be kept.
fn kept(accelerator: Accelerator, primitives: &Primitives, splits: bool) -> Option<Vec<Vec<u8>>> {
    let options = BuildOptions::new(Isa::best()).with_spatial_splits(splits);
    let structure = Structure::build(accelerator, primitives.clone(), options);
    let sections = structure.kept()?;
    Some(sections.into_iter().map(Cow::into_owned).collect())
}

#[test]
fn a_restored_structure_is_the_one_that_was_built() {
    let mut random = Random::new(5);
    let rays = random.rays(2000, 1.0);
    let mut scratch = Scratch::default();
    let scenes = [primitives(&mut random), Primitives::default(), random.triangles(3, 0.5).into()];
    for (primitives, splits) in scenes.iter().flat_map(|of| [(of, false), (of, true)]) {
        for &(name, accelerator) in Accelerator::NAMES {
            let Some(kept) = kept(accelerator, primitives, splits) else {
                assert_ne!(accelerator, Accelerator::Bvh);
                continue;
            };
            let built = Structure::build(accelerator, primitives.clone(), Isa::best());
            let expected = ask(&built, &rays, Coherence::Coherent, &mut scratch);
            for isa in Isa::available() {
                let restored = Structure::restore(accelerator, primitives.clone(), isa, &kept);
                let restored = restored.unwrap_or_else(|_| panic!("{name}"));
                assert_geometry(&restored, primitives, name);
                assert_eq!(restored.kept().expect("kept again"), kept, "{name}");
                let answers = ask(&restored, &rays, Coherence::Coherent, &mut scratch);
                assert!(answers == expected, "{name}, {isa}");
            }
        }
    }
}

/// Whatever sections hold, they give no structure, or one that answers and finds only what is there.
#[test]
fn damaged_and_hostile_sections_do_no_harm() {
    let mut random = Random::new(6);
    let primitives = primitives(&mut random);
    let rays = random.rays(64, 1.0);
    let mut scratch = Scratch::default();
    let oracle = Structure::build(Accelerator::None, primitives.clone(), Isa::Portable);
    let expected = ask(&oracle, &rays, Coherence::Incoherent, &mut scratch);
    let sound = kept(Accelerator::Bvh, &primitives, false).expect("it can be kept");
    let (mut refused, mut restored) = (0, 0);
    for round in 0..600 {
        let mut sections = sound.clone();
        let section = random.0.random_range(0..sections.len());
        let words = sections[section].len() / 4;
        for _ in 0..1 + round % 3 {
            let at = 4 * random.0.random_range(0..words);
            let other = 4 * random.0.random_range(0..words);
            let old = u32::from_le_bytes(sections[section][at..at + 4].try_into().expect("four"));
            let word = match round % 6 {
                0 => random.0.random(),
                1 => u32::MAX,
                2 => old ^ 1 << random.0.random_range(0..32),
                3 => f32::NAN.to_bits(),
                4 => old.wrapping_add(1),
                _ => u32::from_le_bytes(sections[section][other..other + 4].try_into().expect("4")),
            };
            sections[section][at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        match round % 50 {
            0 => sections[section].truncate(4 * (words - 1)),
            1 => sections[section].extend([0; 256]),
            2 => sections.truncate(1),
            3 => sections.swap(0, 1),
            _ => {}
        }
        for isa in Isa::available() {
            let structure =
                Structure::restore(Accelerator::Bvh, primitives.clone(), isa, &sections);
            let Ok(structure) = structure else {
                refused += 1;
                continue;
            };
            restored += 1;
            assert_geometry(&structure, &primitives, "restored");
            for coherence in [Coherence::Coherent, Coherence::Incoherent] {
                let answers = ask(&structure, &rays, coherence, &mut scratch);
                for (answer, expected) in answers.iter().zip(&expected) {
                    let t = |bits: u32| f32::from_bits(bits);
                    assert!(t(answer.0[0]) >= t(expected.0[0]));
                    assert!(expected.1 || !answer.1);
                }
            }
        }
    }
    assert!(refused > 200 && restored > 20, "{refused} refused, {restored} restored");
}
