//! Decides how far each frame goes next, so that all are equally clean when the time is up.
//!
//! Frames are numbered by their place in the run. Times are in seconds.

use slo_picture::film::Steps;

/// Step to which each frame is taken first. Fewer samples do not show how long more would take.
const FIRST: u32 = 4;
/// Maximum share of the time that the first steps take together.
const FIRST_SHARE: f64 = 0.5;
/// Maximum growth of the number of samples in a step: a step takes at most as many samples as all
/// steps before it.
const MOST_GROWTH: f64 = 2.0;
/// Several steps are taken at once if they are expected to need at most this share of the time
/// that is left.
const SURE: f64 = 0.7;
/// Share of the span that is held back for the unforeseen.
const RESERVE: f64 = 0.005;
/// Share of a visit's time besides sampling that is held back, in case the last visit takes
/// longer.
const SLACK: f64 = 0.5;
/// Smallest share of the span that makes a round worthwhile.
const WORTH: f64 = 0.01;

/// Result of a visit, in which a frame was built, took samples, and was written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// Step that all tiles have reached.
    pub(super) done: u32,
    /// Share of the tiles that are one step further.
    pub(super) further: f64,
    /// Samples per pixel in total.
    pub(super) samples: f64,
    /// Samples per pixel that this visit took.
    pub(super) taken: f64,
    /// Time that these samples took.
    pub(super) sampling: f64,
    /// Time before the first sample.
    pub(super) before: f64,
    /// Time after the last sample.
    pub(super) after: f64,
}

/// What is known about a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    done: u32,
    further: f64,
    samples: f64,
    /// Samples per pixel whose time was measured, and that time.
    measured: f64,
    sampling: f64,
    /// Times before and after the samples of the last visit.
    before: f64,
    after: f64,
    /// Time of all visits.
    spent: f64,
    /// Ratio of the samples at the next step to the samples at this one.
    growth: f64,
}

impl Known {
    fn of(earlier: Option<Self>, visit: &Visit) -> Self {
        let Visit { done, further, samples, taken, sampling, before, after } = *visit;
        let (old_measured, old_sampling, spent) =
            earlier.map_or((0.0, 0.0, 0.0), |known| (known.measured, known.sampling, known.spent));
        let known = Self {
            done,
            further,
            samples,
            measured: old_measured + taken,
            sampling: old_sampling + sampling,
            before,
            after,
            spent: spent + before + sampling + after,
            growth: MOST_GROWTH,
        };
        let growth = earlier.map_or(MOST_GROWTH, |earlier| known.growth_since(&earlier));
        Self { growth, ..known }
    }

    fn growth_since(&self, earlier: &Self) -> f64 {
        let steps = self.position() - earlier.position();
        if steps < 0.75 || earlier.samples <= 0.0 || earlier.done < FIRST {
            return earlier.growth;
        }
        libm::pow(self.samples / earlier.samples, 1.0 / steps).clamp(1.1, MOST_GROWTH)
    }

    /// Returns the number of steps. A part of a step counts by its samples.
    fn position(&self) -> f64 {
        f64::from(self.done) + libm::log2(1.0 + self.further)
    }

    /// Returns the time of a visit besides its samples.
    fn fixed(&self) -> f64 {
        self.before + self.after
    }

    /// Returns the samples per pixel that are missing to reach a step.
    fn missing(&self, step: u32, growth: f64) -> f64 {
        let steps = (f64::from(step) - self.position()).max(0.0);
        self.samples * (libm::pow(growth, steps) - 1.0)
    }

    /// Returns all that is known, as numbers.
    pub(super) fn to_numbers(self) -> [f64; 9] {
        let Self { done, further, samples, measured, sampling, before, after, spent, growth } =
            self;
        [f64::from(done), further, samples, measured, sampling, before, after, spent, growth]
    }

    /// Restores what is known from numbers. Returns `None` if a number is impossible.
    pub(super) fn from_numbers(numbers: [f64; 9]) -> Option<Self> {
        let [done, further, samples, measured, sampling, before, after, spent, growth] = numbers;
        let is_sound = numbers.iter().all(|number| *number >= 0.0 && *number < 1e15)
            && done <= f64::from(Steps::LAST)
            && further <= 1.0
            && (1.0..=MOST_GROWTH).contains(&growth);
        let done = done as u32;
        is_sound.then_some(Self {
            done,
            further,
            samples,
            measured,
            sampling,
            before,
            after,
            spent,
            growth,
        })
    }
}

#[derive(Clone, Copy, Debug)]
enum Frame {
    New,
    Known(Known),
    /// The frame is left out.
    Failed,
}

/// The frames of a run, and the time span that they share.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    span: f64,
    frames: Vec<Frame>,
}

/// Frames to visit, and the step that none of them passes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Round {
    pub(super) goal: u32,
    pub(super) frames: Vec<usize>,
}

impl Schedule {
    /// Makes a schedule for frames, each with what is known about it, if anything.
    pub(super) fn new(span: f64, frames: impl IntoIterator<Item = Option<Known>>) -> Self {
        let frames = frames.into_iter().map(|known| known.map_or(Frame::New, Frame::Known));
        Self { span, frames: frames.collect() }
    }

    /// Returns the time spent on all frames.
    pub(super) fn spent(&self) -> f64 {
        self.known().map(|(_, known)| known.spent).sum()
    }

    /// Returns what is known, by frame.
    pub(super) fn known(&self) -> impl Iterator<Item = (usize, &Known)> {
        self.frames.iter().enumerate().filter_map(|(i, frame)| match frame {
            Frame::Known(known) => Some((i, known)),
            _ => None,
        })
    }

    /// Records a visit to a frame. Returns false if the frame got no further.
    pub(super) fn visited(&mut self, i: usize, visit: &Visit) -> bool {
        let earlier = match self.frames[i] {
            Frame::Known(known) => Some(known),
            _ => None,
        };
        let known = Known::of(earlier, visit);
        self.frames[i] = Frame::Known(known);
        earlier.is_none_or(|earlier| known.position() > earlier.position())
    }

    /// Records a visit that ended early, after `seconds`.
    pub(super) fn broken_off(&mut self, i: usize, seconds: f64) {
        if let Frame::Known(known) = &mut self.frames[i] {
            known.spent += seconds;
        }
    }

    /// Records that the last visit to a frame took `seconds` more.
    pub(super) fn took_more(&mut self, i: usize, seconds: f64) {
        if let Frame::Known(known) = &mut self.frames[i] {
            known.after += seconds;
            known.spent += seconds;
        }
    }

    /// Records that a frame failed.
    pub(super) fn failed(&mut self, i: usize) {
        self.frames[i] = Frame::Failed;
    }

    /// Returns the next round when `passed` of the span is over. Returns `None` if no time is left
    /// for a round, or nothing is left to do.
    pub(super) fn round(&self, passed: f64) -> Option<Round> {
        let is_new = |i: &usize| matches!(self.frames[*i], Frame::New);
        let new: Vec<usize> = (0..self.frames.len()).filter(is_new).collect();
        if !new.is_empty() {
            return Some(Round { goal: FIRST, frames: new });
        }
        let level = self.level().filter(|level| *level < Steps::LAST)?;
        let left = self.left(passed);
        let is_sure = |goal: &u32| {
            let samples: f64 = self.below(*goal).map(|i| self.needs(i, *goal, MOST_GROWTH)).sum();
            samples + self.fixed(self.below(*goal)) <= SURE * left
        };
        let goal = (level + 2..=Steps::LAST).take_while(is_sure).last().unwrap_or(level + 1);
        let frames: Vec<usize> = self.below(goal).collect();
        let is_worth_it = left - self.fixed(frames.iter().copied()) >= WORTH * self.span;
        is_worth_it.then_some(Round { goal, frames })
    }

    /// Returns how far frame number `at` of a round goes: the last step, and the seconds from the
    /// beginning of the visit to its last sample.
    pub(super) fn limit(&self, round: &Round, at: usize, passed: f64) -> (u32, f64) {
        let i = round.frames[at];
        let todo = || round.frames[at..].iter().copied();
        let left = (self.left(passed) - self.fixed(todo())).max(0.0);
        let all: f64 = todo().map(|i| self.needs(i, round.goal, self.growth(i))).sum();
        match &self.frames[i] {
            Frame::Known(known) => {
                let share = self.needs(i, round.goal, known.growth) / all.max(1e-12);
                (round.goal, known.before + left * share.min(1.0))
            }
            _ => {
                let first = FIRST_SHARE * self.span / round.frames.len() as f64;
                let share = left / todo().count() as f64;
                let step = self.level().map_or(round.goal, |level| level.min(round.goal));
                (step, self.before() + share.min(first))
            }
        }
    }

    /// Returns the step that all known frames have reached.
    fn level(&self) -> Option<u32> {
        self.known().map(|(_, known)| known.done).min()
    }

    fn left(&self, passed: f64) -> f64 {
        self.span * (1.0 - RESERVE) - SLACK * self.mean(Known::fixed) - passed
    }

    /// Returns the frames that have not reached a step yet.
    fn below(&self, step: u32) -> impl Iterator<Item = usize> {
        self.known().filter(move |(_, known)| known.done < step).map(|(i, _)| i)
    }

    /// Returns the time of visits to frames besides their samples.
    fn fixed(&self, frames: impl Iterator<Item = usize>) -> f64 {
        let usual = self.mean(Known::fixed);
        let fixed = |i: usize| match &self.frames[i] {
            Frame::Known(known) => known.fixed(),
            _ => usual,
        };
        frames.map(fixed).sum()
    }

    /// Returns the usual time before the first sample of a frame.
    fn before(&self) -> f64 {
        self.mean(|known| known.before)
    }

    fn mean(&self, of: impl Fn(&Known) -> f64) -> f64 {
        self.known().map(|(_, known)| of(known)).sum::<f64>() / self.known().count().max(1) as f64
    }

    fn growth(&self, i: usize) -> f64 {
        if let Frame::Known(known) = &self.frames[i] { known.growth } else { MOST_GROWTH }
    }

    /// Returns the time for the samples that a frame lacks to reach a step.
    fn needs(&self, i: usize, step: u32, growth: f64) -> f64 {
        let Frame::Known(known) = &self.frames[i] else { return 1.0 };
        let is_measured = known.measured >= 0.01 * known.samples && known.sampling > 0.0;
        let rate = if is_measured { known.sampling / known.measured } else { self.usual_rate() };
        known.missing(step, growth) * rate
    }

    /// Returns the usual time for one sample per pixel: a second if nothing was measured.
    fn usual_rate(&self) -> f64 {
        let (sampling, measured) = (self.mean(|k| k.sampling), self.mean(|k| k.measured));
        if measured > 0.0 && sampling > 0.0 { sampling / measured } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of tiles of a made-up frame.
    const TILES: f64 = 20.0;

    /// A made-up frame: its samples at step 4, their growth from there, and the times of a sample
    /// and of a visit.
    #[derive(Clone, Copy)]
    struct Made {
        samples: f64,
        growth: f64,
        rate: f64,
        fixed: f64,
        at: (u32, f64),
    }

    impl Made {
        fn samples_at(&self, step: u32) -> f64 {
            match step {
                0..=3 => f64::from(1u32 << step),
                _ => (self.samples * libm::pow(self.growth, f64::from(step - 4))).min(1e9),
            }
        }

        fn samples(&self, (done, further): (u32, f64)) -> f64 {
            let next = self.samples_at((done + 1).min(Steps::LAST));
            self.samples_at(done) + further * (next - self.samples_at(done))
        }

        /// Takes tile after tile as long as there is time.
        fn visit(&mut self, (last, seconds): (u32, f64)) -> Visit {
            let (half, before) = (self.fixed / 2.0, self.samples(self.at));
            let before = if self.at == (0, -1.0) { 0.0 } else { before };
            let mut at = if self.at.1 < 0.0 { (0, 0.0) } else { self.at };
            let time = |at| half + (self.samples(at) - before) * self.rate;
            while at.0 < last.min(Steps::LAST) {
                let tiles = (at.1 * TILES).round() + 1.0;
                let next = if tiles >= TILES { (at.0 + 1, 0.0) } else { (at.0, tiles / TILES) };
                if time(next) > seconds {
                    break;
                }
                at = next;
            }
            let samples = self.samples(at);
            self.at = at;
            Visit {
                done: at.0,
                further: at.1,
                samples,
                taken: samples - before,
                sampling: (samples - before) * self.rate,
                before: half,
                after: half,
            }
        }
    }

    /// Returns the time that has passed at the end, and the number of rounds.
    fn run(span: f64, made: &mut [Made]) -> (f64, usize) {
        let mut schedule = Schedule::new(span, made.iter().map(|_| None));
        let (mut passed, mut rounds) = (0.0, 0);
        while let Some(round) = schedule.round(passed) {
            rounds += 1;
            let mut moved = false;
            for (at, &i) in round.frames.iter().enumerate() {
                let visit = made[i].visit(schedule.limit(&round, at, passed));
                passed += visit.before + visit.sampling + visit.after;
                moved |= schedule.visited(i, &visit);
            }
            assert!(moved && rounds < 40, "{rounds}");
        }
        assert!((schedule.spent() - passed).abs() < 1e-6 * passed);
        (passed, rounds)
    }

    fn frame(samples: f64, growth: f64, rate: f64) -> Made {
        Made { samples, growth, rate, fixed: 0.1, at: (0, -1.0) }
    }

    /// Checks that frames use all of the span and no more, and come out equally clean.
    #[track_caller]
    fn check(span: f64, frames: &[Made]) {
        let mut made = frames.to_vec();
        let (passed, rounds) = run(span, &mut made);
        let steps: Vec<_> = made.iter().map(|made| made.at).collect();
        assert!(passed <= span, "{passed} of {span}: {steps:?}");
        assert!(passed >= 0.95 * span, "{passed} of {span}: {steps:?}");
        assert!(rounds <= 12, "{rounds}");
        let (least, most) = (made.iter().map(|m| m.at.0).min(), made.iter().map(|m| m.at.0).max());
        assert!(most.unwrap() <= least.unwrap() + 1, "{steps:?}");
    }

    #[test]
    fn frames_that_are_alike_use_the_span() {
        for span in [20.0, 50.0, 300.0, 3000.0, 30_000.0] {
            check(span, &[frame(20.0, 1.9, 0.01); 10]);
        }
    }

    #[test]
    fn frames_that_differ_come_out_equally_clean() {
        let growth = [1.3, 1.6, 1.9, 2.0, 1.5];
        let frames: Vec<Made> = (0..40u32)
            .map(|i| {
                let (samples, rate) = (16.0 + f64::from(i * i % 97), 0.002 * f64::from(1 + i % 7));
                frame(samples, growth[i as usize % 5], rate)
            })
            .collect();
        for span in [60.0, 200.0, 1000.0, 10_000.0] {
            check(span, &frames);
        }
    }

    #[test]
    fn one_hard_frame_gets_its_time() {
        let mut frames = [frame(16.0, 1.8, 0.002); 12];
        frames[7] = frame(300.0, 2.0, 0.02);
        for span in [30.0, 100.0, 1000.0] {
            check(span, &frames);
        }
    }

    #[test]
    fn without_enough_time_every_frame_has_a_picture() {
        let mut made = [frame(20.0, 2.0, 0.1); 5];
        run(0.01, &mut made);
        assert!(made.iter().all(|made| made.at == (0, 0.0)));
    }

    #[test]
    fn a_run_ends_where_frames_are_as_clean_as_can_be() {
        let mut made = [frame(16.0, 1.2, 1e-5); 3];
        let (passed, _) = run(1000.0, &mut made);
        assert!(passed < 10.0);
        assert!(made.iter().all(|made| made.at == (Steps::LAST, 0.0)));
    }

    #[test]
    fn failed_frames_are_left_out() {
        let mut schedule = Schedule::new(10.0, [None, None]);
        assert_eq!(schedule.round(0.0), Some(Round { goal: FIRST, frames: vec![0, 1] }));
        schedule.failed(0);
        schedule.visited(1, &frame(16.0, 2.0, 0.01).visit((4, 1.0)));
        assert_eq!(schedule.round(1.0).unwrap().frames, [1]);
        schedule.failed(1);
        assert_eq!(schedule.round(1.0), None);
    }

    #[test]
    fn what_is_known_goes_through_numbers() {
        let known = Known::of(None, &frame(16.0, 2.0, 0.01).visit((4, 1.0)));
        assert_eq!(Known::from_numbers(known.to_numbers()), Some(known));
        for (i, bad) in [(0, 99.0), (1, 2.0), (3, -1.0), (4, f64::NAN), (8, 0.0)] {
            let mut numbers = known.to_numbers();
            numbers[i] = bad;
            assert_eq!(Known::from_numbers(numbers), None, "{i}");
        }
    }
}
