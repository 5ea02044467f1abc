//! How far which frame goes next, so that all are equally clean when the time is over.
//!
//! Frames are numbered by their place in the run, times are in seconds.

use slo_picture::film::Steps;

/// The step that each frame is taken to first: fewer samples do not show what more would take.
const FIRST: u32 = 4;
/// The first steps together take this share of the time at most.
const FIRST_SHARE: f64 = 0.5;
/// A step takes as many samples as all before it, at most.
const MOST_GROWTH: f64 = 2.0;
/// Several steps at once are taken if they are expected to need at most this share of the time that
/// is left.
const SURE: f64 = 0.7;
/// What is left over of the span, as a share of it, for what nobody foresees.
const RESERVE: f64 = 0.005;
/// Share of a visit's time besides the samples that is left over, in case the last one takes longer.
const SLACK: f64 = 0.5;
/// A round for less than this share of the span is not worth it.
const WORTH: f64 = 0.01;

/// What came of a visit: a frame was built, took samples, and was written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// The step that all tiles are at.
    pub(super) done: u32,
    /// The share of them that is one further.
    pub(super) further: f64,
    /// Samples per pixel, all that there are.
    pub(super) samples: f64,
    /// Those that this visit took.
    pub(super) taken: f64,
    /// What these took.
    pub(super) sampling: f64,
    /// Time before the first sample.
    pub(super) before: f64,
    /// Time after the last.
    pub(super) after: f64,
}

/// What is known of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    done: u32,
    further: f64,
    samples: f64,
    /// Samples whose time was measured, and that time.
    measured: f64,
    sampling: f64,
    /// Of the last visit.
    before: f64,
    after: f64,
    /// All visits.
    spent: f64,
    /// How many times the samples of one step the next one has.
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

    /// Steps, a part of one by the samples that it takes.
    fn position(&self) -> f64 {
        f64::from(self.done) + libm::log2(1.0 + self.further)
    }

    /// Time of a visit besides its samples.
    fn fixed(&self) -> f64 {
        self.before + self.after
    }

    /// Samples that are missing to a step.
    fn missing(&self, step: u32, growth: f64) -> f64 {
        let steps = (f64::from(step) - self.position()).max(0.0);
        self.samples * (libm::pow(growth, steps) - 1.0)
    }

    /// All that is known, as numbers.
    pub(super) fn to_numbers(self) -> [f64; 9] {
        let Self { done, further, samples, measured, sampling, before, after, spent, growth } =
            self;
        [f64::from(done), further, samples, measured, sampling, before, after, spent, growth]
    }

    /// The same from numbers; `None` if one of them can't be.
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
    /// It is left out.
    Failed,
}

/// The frames of a run, and the span that they have together.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    span: f64,
    frames: Vec<Frame>,
}

/// Frames that are to be visited, and the step that none of them passes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Round {
    pub(super) goal: u32,
    pub(super) frames: Vec<usize>,
}

impl Schedule {
    /// For frames of which something is known or nothing.
    pub(super) fn new(span: f64, frames: impl IntoIterator<Item = Option<Known>>) -> Self {
        let frames = frames.into_iter().map(|known| known.map_or(Frame::New, Frame::Known));
        Self { span, frames: frames.collect() }
    }

    /// What was spent on all frames.
    pub(super) fn spent(&self) -> f64 {
        self.known().map(|(_, known)| known.spent).sum()
    }

    /// What is known, by frame.
    pub(super) fn known(&self) -> impl Iterator<Item = (usize, &Known)> {
        self.frames.iter().enumerate().filter_map(|(i, frame)| match frame {
            Frame::Known(known) => Some((i, known)),
            _ => None,
        })
    }

    /// A frame was visited; false if it came no further.
    pub(super) fn visited(&mut self, i: usize, visit: &Visit) -> bool {
        let earlier = match self.frames[i] {
            Frame::Known(known) => Some(known),
            _ => None,
        };
        let known = Known::of(earlier, visit);
        self.frames[i] = Frame::Known(known);
        earlier.is_none_or(|earlier| known.position() > earlier.position())
    }

    /// A visit ended early, after so much time.
    pub(super) fn broken_off(&mut self, i: usize, seconds: f64) {
        if let Frame::Known(known) = &mut self.frames[i] {
            known.spent += seconds;
        }
    }

    /// The last visit to a frame took so much more in the end.
    pub(super) fn took_more(&mut self, i: usize, seconds: f64) {
        if let Frame::Known(known) = &mut self.frames[i] {
            known.after += seconds;
            known.spent += seconds;
        }
    }

    /// A frame can't be had.
    pub(super) fn failed(&mut self, i: usize) {
        self.frames[i] = Frame::Failed;
    }

    /// The next round, `passed` of the span; `None` if no time is left for one, or nothing to do.
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

    /// How far frame number `at` of a round goes: the last step, and seconds from the beginning of
    /// the visit to its last sample.
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

    /// The step that all known frames are at.
    fn level(&self) -> Option<u32> {
        self.known().map(|(_, known)| known.done).min()
    }

    fn left(&self, passed: f64) -> f64 {
        self.span * (1.0 - RESERVE) - SLACK * self.mean(Known::fixed) - passed
    }

    /// Frames that are not at a step yet.
    fn below(&self, step: u32) -> impl Iterator<Item = usize> {
        self.known().filter(move |(_, known)| known.done < step).map(|(i, _)| i)
    }

    /// Visits without their samples.
    fn fixed(&self, frames: impl Iterator<Item = usize>) -> f64 {
        let usual = self.mean(Known::fixed);
        let fixed = |i: usize| match &self.frames[i] {
            Frame::Known(known) => known.fixed(),
            _ => usual,
        };
        frames.map(fixed).sum()
    }

    /// Time before the first sample of a frame, as a rule.
    fn before(&self) -> f64 {
        self.mean(|known| known.before)
    }

    fn mean(&self, of: impl Fn(&Known) -> f64) -> f64 {
        self.known().map(|(_, known)| of(known)).sum::<f64>() / self.known().count().max(1) as f64
    }

    fn growth(&self, i: usize) -> f64 {
        if let Frame::Known(known) = &self.frames[i] { known.growth } else { MOST_GROWTH }
    }

    /// Time for the samples that a frame lacks to a step.
    fn needs(&self, i: usize, step: u32, growth: f64) -> f64 {
        let Frame::Known(known) = &self.frames[i] else { return 1.0 };
        let is_measured = known.measured >= 0.01 * known.samples && known.sampling > 0.0;
        let rate = if is_measured { known.sampling / known.measured } else { self.usual_rate() };
        known.missing(step, growth) * rate
    }

    /// Time for a sample per pixel, as a rule: a second if nothing was measured.
    fn usual_rate(&self) -> f64 {
        let (sampling, measured) = (self.mean(|k| k.sampling), self.mean(|k| k.measured));
        if measured > 0.0 && sampling > 0.0 { sampling / measured } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles of a made-up frame.
    const TILES: f64 = 20.0;

    /// A made-up frame: its samples at step 4, how they grow from there, and what they and a visit
    /// take.
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

        /// Tile after tile, as long as there is time.
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

    /// What is passed at the end, and how many rounds there were.
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

    /// All of the span is used, and no more, for frames that are equally clean.
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
