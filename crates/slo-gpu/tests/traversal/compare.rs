//! Both sides of a comparison.

use std::sync::OnceLock;

use slo_accel::math::Bounds;
use slo_accel::study::{Answer, Counts, Memory, Parameters, Ray, Study};
use slo_accel::triangle::{self, ShearedRay, TriangleHit};
use slo_accel::{Device, NO_HIT, Rays, Triangle};
use slo_gpu::Gpu;

/// The GPU of all tests; `None` if there is none and none is asked for.
pub(crate) fn gpu() -> Option<Gpu> {
    static GPU: OnceLock<Result<Gpu, String>> = OnceLock::new();
    let opened = GPU.get_or_init(|| {
        let opened = Gpu::open(std::env::var("SLO_GPU").ok().as_deref());
        match &opened {
            Ok(gpu) => eprintln!("on {}", gpu.adapter()),
            Err(reason) => eprintln!("SKIPPED: {reason}"),
        }
        opened
    });
    let is_asked_for = std::env::var_os("SLO_REQUIRE_GPU").is_some_and(|value| value == "1");
    assert!(opened.is_ok() || !is_asked_for, "SLO_REQUIRE_GPU=1: {opened:?}");
    opened.clone().ok()
}

/// What is compared.
pub(crate) struct Compared<'a> {
    pub(crate) name: &'a str,
    pub(crate) triangles: &'a [Triangle],
    pub(crate) rays: &'a Rays,
    pub(crate) any: bool,
}

/// The CPU's answer about a ray, by the traversal that `slo-accel` has.
fn by_cpu<S: Study>(
    study: &S,
    triangles: &[Triangle],
    ray: Ray,
    any: bool,
    memory: &mut Memory,
) -> (Option<(u32, TriangleHit)>, Counts) {
    let sheared = ShearedRay::new(ray.origin, ray.direction);
    let (mut best, mut counts) = (None, Counts::default());
    study.walk(&ray, memory, &mut counts, |object, t_max| {
        let is_lower = best.is_some_and(|(lowest, _)| object < lowest);
        let limit = if is_lower { t_max.next_up() } else { t_max };
        match triangle::intersect(&sheared, &triangles[object as usize], limit) {
            Some(hit) => {
                best = Some((object, hit));
                if any { f32::NEG_INFINITY } else { hit.t }
            }
            None => t_max,
        }
    });
    (best, counts)
}

/// How a GPU's answers differ from the CPU's.
///
/// Software must agree in every bit and counter. Hardware divides numbers of 64 bits with an error of a
/// few last bits, so it may come to another triangle at the same distance, or miss an edge, for one ray
/// in 100 000; its counters may be 0.1 % off in sum.
#[derive(Debug, Default)]
struct Verdict {
    rays: usize,
    hits: usize,
    uncertain: usize,
    /// Another triangle, at a distance that is the same but for 1e-5 of it.
    ties: usize,
    /// A hit on one side, a miss on the other.
    lost: usize,
    /// All else.
    wrong: usize,
    /// Other bits, or other counters.
    unequal: usize,
    work: [u64; 2],
}

impl Compared<'_> {
    /// Builds a structure, and compares both traversals of it.
    pub(crate) fn check<S: Study>(&self, gpu: &Gpu, parameters: Parameters) {
        let Self { name, rays, any, .. } = *self;
        let all = self.triangles.iter().copied();
        let solid: Vec<Triangle> = all.filter(|one| !triangle::is_degenerate(one)).collect();
        let boxes: Vec<Bounds> = solid.iter().map(|&one| Bounds::of_points(one)).collect();
        let study = S::build(&boxes, &parameters);
        let layout = study.layout().expect("it can be given to a device");
        let uploaded = gpu.upload(&layout, &solid).expect("it fits");
        let mut answers = vec![];
        uploaded.trace(rays, any, &mut answers).expect("it answers");
        assert_eq!(answers.len(), rays.len());
        let (mut memory, mut verdict) = (Memory::default(), Verdict::default());
        for (i, answer) in answers.iter().enumerate() {
            let (origin, direction) = (rays.origin(i), rays.direction(i));
            let ray = Ray { origin, direction, t_max: rays.t_max[i] };
            let expected = by_cpu(&study, &solid, ray, any, &mut memory);
            let is_equal = verdict.add(answer, &expected);
            let must_be = gpu.adapter().is_software && answer.is_certain;
            assert!(
                is_equal || !must_be,
                "{name}, {parameters}, any {any}, ray {i}: {ray:?}: {answer:?} {expected:?}"
            );
        }
        let Verdict { rays, uncertain, ties, lost, wrong, work, .. } = verdict;
        let told = format!(
            "{name}, {layout_name} {parameters}, any {any}: {verdict:?}",
            layout_name = std::any::type_name::<S>()
        );
        eprintln!("{told}");
        assert!(
            wrong == 0
                && ties.max(lost) <= rays / 100_000 + usize::from(!gpu.adapter().is_software),
            "{told}"
        );
        assert!(work[0].abs_diff(work[1]) <= work[0] / 1000, "{told}");
        assert!(uncertain <= rays / 20, "{told}");
        assert_eq!(gpu.failure(), None);
    }
}

impl Verdict {
    /// Adds a ray; returns whether everything is equal.
    fn add(&mut self, answer: &Answer, expected: &(Option<(u32, TriangleHit)>, Counts)) -> bool {
        self.rays += 1;
        if !answer.is_certain {
            self.uncertain += 1;
            return false;
        }
        let (hit, counts) = expected;
        self.hits += usize::from(hit.is_some());
        self.work[0] += counts.steps + counts.tests;
        self.work[1] += answer.counts.steps + answer.counts.tests;
        let bits = |object: u32, t: f32, u: f32, v: f32| (object, [t, u, v].map(f32::to_bits));
        let same_hit = match *hit {
            Some((object, hit)) => {
                bits(object, hit.t, hit.u, hit.v)
                    == bits(answer.object, answer.t, answer.u, answer.v)
            }
            None => answer.object == NO_HIT,
        };
        match *hit {
            Some((object, hit)) if answer.object != NO_HIT => {
                let is_near = (hit.t - answer.t).abs() <= 1e-5 * hit.t;
                self.ties += usize::from(object != answer.object && is_near);
                self.wrong += usize::from(!is_near);
            }
            hit => self.lost += usize::from(hit.is_some() != (answer.object != NO_HIT)),
        }
        let is_equal = same_hit && *counts == answer.counts;
        self.unequal += usize::from(!is_equal);
        is_equal
    }
}
