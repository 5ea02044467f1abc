//! From a frame's number to its shutter, and from shutter time to scene time.

use std::fmt;

use crate::description::{CamSegment, Camera};
use crate::format::Short;

use super::mix::mix;

/// How near, in frames, a frame must be to the border of a segment to count as lying on it.
///
/// Borders are decimal seconds: a border that falls on a frame may miss it by the rounding of its
/// digits (`0.333333333` at 3 frames per second) and of `border * fps`. A millionth of a frame is
/// far above the second, and below any intended difference.
const BORDER_TOLERANCE_FRAMES: f64 = 1e-6;

/// Finds the camera segment of a frame, and the times at which its shutter is open.
#[derive(Clone, Debug)]
pub struct Clock {
    fps: f64,
    segments: Vec<Segment>,
}

/// The times of a camera segment.
#[derive(Clone, Debug)]
struct Segment {
    video: [f64; 2],
    scene: [f64; 2],
    blur_duration: f64,
    frames: SegmentFrames,
}

/// The frames that open their shutter in a camera segment.
#[derive(Clone, Debug, PartialEq)]
pub struct SegmentFrames {
    /// The segment's name in the text.
    pub name: String,
    /// Seconds of the finished video.
    pub video: [f64; 2],
    /// First frame; larger than `last` if no frame falls into the segment.
    pub first: i64,
    /// Last frame.
    pub last: i64,
}

/// A frame whose time lies in no camera segment.
#[derive(Clone, Debug, PartialEq)]
pub struct NoSegment {
    /// The frame.
    pub frame: i64,
    /// Its video time in seconds.
    pub time: f64,
    /// All segments, in order of time.
    pub segments: Vec<SegmentFrames>,
}

/// The time during which one frame is exposed.
///
/// Shutter time `s` runs over `[0, 1]`, linear in video time. Past the end of the segment, where
/// the shutter outlasts it, segment parameter and scene time stay at their ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shutter {
    /// Index of the camera segment.
    pub segment: usize,
    /// Video time in seconds at which the shutter opens and closes.
    pub video: [f64; 2],
    segment_video: [f64; 2],
    segment_scene: [f64; 2],
}

impl Clock {
    /// The clock of a camera.
    pub fn new(camera: &Camera) -> Self {
        let last = camera.segments.len().saturating_sub(1);
        let segments = camera
            .segments
            .iter()
            .enumerate()
            .map(|(i, segment)| Segment::new(segment, camera.fps, i == last))
            .collect();
        Self { fps: camera.fps, segments }
    }

    /// The frames of every segment, in order of time.
    pub fn segments(&self) -> impl Iterator<Item = &SegmentFrames> {
        self.segments.iter().map(|segment| &segment.frames)
    }

    /// The shutter of frame `frame`: it opens at video time `frame / fps`.
    ///
    /// Segments are half-open, the last one owns its end; a frame within a millionth of a frame
    /// of a border lies on it.
    ///
    /// # Errors
    /// A frame in no segment.
    pub fn shutter(&self, frame: i64) -> Result<Shutter, NoSegment> {
        let open = frame as f64 / self.fps;
        let found = self
            .segments
            .iter()
            .position(|segment| (segment.frames.first..=segment.frames.last).contains(&frame));
        let Some(index) = found else {
            let segments = self.segments().cloned().collect();
            return Err(NoSegment { frame, time: open, segments });
        };
        let segment = &self.segments[index];
        Ok(Shutter {
            segment: index,
            video: [open, open + segment.blur_duration],
            segment_video: segment.video,
            segment_scene: segment.scene,
        })
    }
}

impl Segment {
    fn new(segment: &CamSegment, fps: f64, owns_its_end: bool) -> Self {
        let [start, end] = segment.video.map(|time| time * fps);
        let first_from = |time: f64| (time - BORDER_TOLERANCE_FRAMES).ceil() as i64;
        let last = if owns_its_end {
            (end + BORDER_TOLERANCE_FRAMES).floor() as i64
        } else {
            first_from(end).saturating_sub(1)
        };
        let frames = SegmentFrames {
            name: segment.name.clone(),
            video: segment.video,
            first: first_from(start),
            last,
        };
        Self {
            video: segment.video,
            scene: segment.scene,
            blur_duration: segment.blur_duration,
            frames,
        }
    }
}

impl Shutter {
    /// Seconds of video time that the shutter is open.
    pub fn duration(&self) -> f64 {
        self.video[1] - self.video[0]
    }

    /// Video time in seconds at shutter time `s`.
    pub fn video_time(&self, s: f64) -> f64 {
        mix(self.video[0], self.video[1], s)
    }

    /// How far through the camera segment shutter time `s` is: 0 at its start, 1 at its end and
    /// past it.
    pub fn segment_parameter(&self, s: f64) -> f64 {
        let [start, end] = self.segment_video;
        let time = self.video_time(s);
        if end > start { ((time - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Scene time at shutter time `s`.
    pub fn scene_time(&self, s: f64) -> f64 {
        mix(self.segment_scene[0], self.segment_scene[1], self.segment_parameter(s))
    }

    /// Earliest and latest scene time of the shutter (scene time may run backwards).
    pub fn scene_interval(&self) -> [f64; 2] {
        let [a, b] = [self.scene_time(0.0), self.scene_time(1.0)];
        [a.min(b), a.max(b)]
    }

    /// The shutter time at which scene time is `time`; `None` outside the shutter, and where scene
    /// time stands still.
    pub fn shutter_time_of(&self, time: f64) -> Option<f64> {
        let [scene, video] = [self.segment_scene, self.segment_video];
        let along = (time - scene[0]) / (scene[1] - scene[0]);
        let s = (mix(video[0], video[1], along) - self.video[0]) / self.duration();
        let rounding = 1e-9;
        (-rounding..=1.0 + rounding).contains(&s).then(|| s.clamp(0.0, 1.0))
    }
}

impl fmt::Display for SegmentFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, video, first, last } = self;
        let [start, end] = video.map(Short);
        write!(f, "`{name}` {start} s to {end} s, ")?;
        match last.saturating_sub(*first) {
            ..0 => write!(f, "no frame"),
            0 => write!(f, "frame {first}"),
            _ => write!(f, "frames {first} to {last}"),
        }
    }
}

impl fmt::Display for NoSegment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "frame {} ({} s of the video) lies in no camera segment; the camera has:",
            self.frame,
            Short(self.time)
        )?;
        self.segments.iter().try_for_each(|segment| write!(f, "\n  {segment}"))
    }
}

impl std::error::Error for NoSegment {}

#[cfg(test)]
pub(super) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::settings::{Film, OutputFormat, ToneMap};

    /// A segment that looks from (0, -10, 0) to the origin.
    pub(in crate::animation) fn segment(
        name: &str,
        video: [f64; 2],
        scene: [f64; 2],
    ) -> CamSegment {
        CamSegment {
            name: name.into(),
            video,
            scene,
            positions: vec![DVec3::new(0.0, -10.0, 0.0)],
            targets: vec![DVec3::ZERO],
            sky: [DVec3::Z; 2],
            fov: [0.5; 2],
            dof: [10.0; 2],
            lens_radius: [0.0; 2],
            blur_duration: 0.0,
        }
    }

    pub(in crate::animation) fn camera(fps: f64, segments: Vec<CamSegment>) -> Camera {
        let film = Film {
            width: 100,
            height: 100,
            prefix: "test".into(),
            output: OutputFormat::Png8,
            encoding: None,
            exposure: 0.0,
            tone_map: ToneMap::None,
            layers: Vec::new(),
        };
        Camera { fps, film, segments }
    }

    fn clock(fps: f64, borders: &[f64]) -> Clock {
        let segments = borders
            .windows(2)
            .enumerate()
            .map(|(i, w)| segment(&format!("s{i}"), [w[0], w[1]], [0.0, 1.0]))
            .collect();
        Clock::new(&camera(fps, segments))
    }

    #[test]
    fn half_open_and_the_last_owns_its_end() {
        let clock = clock(25.0, &[0.0, 2.0, 4.0]);
        let segment = |frame| clock.shutter(frame).map(|shutter| shutter.segment);
        assert_eq!(segment(0), Ok(0));
        assert_eq!(segment(49), Ok(0));
        assert_eq!(segment(50), Ok(1));
        assert_eq!(segment(100), Ok(1));
        assert!(segment(101).is_err());
        assert!(segment(-1).is_err());
    }

    #[test]
    fn every_border_that_falls_on_a_frame_belongs_to_the_later_segment() {
        for fps in [24.0, 25.0, 30.0, 3.0, 7.0, 60.0, 23.976, 29.97, 1000.0 / 7.0] {
            for k in 1..2000_i64 {
                // three ways that a border comes into being, none of them exact
                let borders =
                    [k as f64 / fps, k as f64 * (1.0 / fps), (k as f64 / fps * 1e9).round() / 1e9];
                for border in borders {
                    let clock = clock(fps, &[0.0, border, border + 100.0]);
                    assert_eq!(clock.shutter(k).unwrap().segment, 1, "{k} at {fps}: {border}");
                    assert_eq!(clock.shutter(k - 1).unwrap().segment, 0);
                }
            }
        }
    }

    #[test]
    fn a_frame_on_a_border_that_rounding_missed_has_parameter_zero() {
        let clock = clock(3.0, &[0.333_333_333_4, 1.0]);
        let shutter = clock.shutter(1).unwrap();
        assert_eq!(shutter.segment_parameter(0.0), 0.0);
        assert_eq!(shutter.scene_time(0.0), 0.0);
    }

    #[test]
    fn a_border_between_frames_is_not_moved() {
        let clock = clock(25.0, &[0.0, 0.0401, 1.0]);
        assert_eq!(clock.shutter(1).unwrap().segment, 0);
        assert_eq!(clock.shutter(2).unwrap().segment, 1);
    }

    #[test]
    fn scene_time_is_linear_in_video_time_and_clamped_past_the_end() {
        let mut segment = segment("slow", [1.0, 3.0], [10.0, 20.0]);
        segment.blur_duration = 1.0;
        let clock = Clock::new(&camera(4.0, vec![segment]));
        let shutter = clock.shutter(6).unwrap();
        assert_eq!(shutter.video, [1.5, 2.5]);
        assert_eq!(shutter.scene_interval(), [12.5, 17.5]);
        assert_eq!(shutter.scene_time(0.5), 15.0);
        let last = clock.shutter(10).unwrap(); // 2.5 s to 3.5 s; the segment ends at 3 s
        assert_eq!(last.segment_parameter(0.5), 1.0);
        assert_eq!(last.segment_parameter(1.0), 1.0);
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|s| last.scene_time(s)), [17.5, 18.75, 20.0, 20.0]);
    }

    #[test]
    fn scene_time_may_run_backwards_or_stand_still() {
        let mut back = segment("back", [0.0, 1.0], [5.0, 1.0]);
        back.blur_duration = 0.5;
        let mut still = segment("still", [1.0, 2.0], [3.3, 3.3]);
        still.blur_duration = 0.5;
        let clock = Clock::new(&camera(2.0, vec![back, still]));
        assert_eq!(clock.shutter(0).unwrap().scene_interval(), [3.0, 5.0]);
        assert_eq!(clock.shutter(3).unwrap().scene_interval(), [3.3, 3.3]);
    }

    #[test]
    fn a_segment_without_length_is_one_frame() {
        let clock = clock(25.0, &[2.0, 2.0]);
        let shutter = clock.shutter(50).unwrap();
        assert_eq!((shutter.segment_parameter(0.0), shutter.scene_time(0.0)), (0.0, 0.0));
        assert!(clock.shutter(49).is_err() && clock.shutter(51).is_err());
    }

    #[test]
    fn shutter_time_of_inverts_scene_time() {
        let mut segment = segment("s", [1.0, 3.0], [20.0, 10.0]);
        segment.blur_duration = 1.0;
        let shutter = Clock::new(&camera(4.0, vec![segment])).shutter(10).unwrap();
        for s in [0.1, 0.25, 0.49] {
            let back = shutter.shutter_time_of(shutter.scene_time(s)).unwrap();
            assert!((back - s).abs() < 1e-12);
        }
        assert_eq!(shutter.shutter_time_of(99.0), None);
    }

    #[test]
    fn a_frame_in_no_segment_is_told_what_there_is() {
        let segments = vec![
            segment("intro", [0.0, 2.0], [0.0, 1.0]),
            segment("blink", [2.01, 2.02], [0.0, 1.0]),
            segment("pieštec", [3.0, 3.04], [0.0, 1.0]),
        ];
        let error = Clock::new(&camera(25.0, segments)).shutter(60).unwrap_err();
        assert_eq!(
            error.to_string(),
            "frame 60 (2.4 s of the video) lies in no camera segment; the camera has:\n  \
             `intro` 0 s to 2 s, frames 0 to 49\n  \
             `blink` 2.01 s to 2.02 s, no frame\n  \
             `pieštec` 3 s to 3.04 s, frames 75 to 76"
        );
    }

    #[test]
    fn extreme_numbers_do_not_panic() {
        let clock = clock(1e300, &[-1e300, 1e300]);
        for frame in [i64::MIN, -1, 0, i64::MAX] {
            let _ = clock.shutter(frame).map(|shutter| shutter.scene_time(0.5));
        }
        assert!(Clock::new(&camera(25.0, vec![])).shutter(0).is_err());
    }
}
