//! What a pixel is made of.

use serde_json::{Value, json};
use slo_render::render::{Bright, Names, Plan, Share, Tally, explain};

use super::{Effects, Studio};
use crate::pick::pixel_at;

/// Most samples that are traced once more.
const MOST_SAMPLES: u32 = 256;
/// The brightest ways that are listed.
const WAYS: usize = 6;
/// Most lines of a table.
const MOST_LINES: usize = 12;

impl Studio {
    /// Explains what is seen at a place of the picture.
    pub(super) fn explain(&mut self, at: [f64; 2]) -> Result<Effects, String> {
        let stage = self.stage.as_ref().ok_or("the scene has errors")?;
        let (scene, number) = (stage.shown(), stage.frame());
        let (x, y) = pixel_at(at, scene.camera.film.width, scene.camera.film.height);
        let samples = Plan::new(scene).least().clamp(1, MOST_SAMPLES);
        let link = self.link.clone();
        let tally = self.looker.explained(scene, number, |frame| {
            let things = frame.things(scene).map_err(|error| error.to_string())?;
            let names = Names { frame, things: &things };
            let mut tally = Tally::new(WAYS);
            let gives_up = || link.is_waited_for();
            let mut tell = |sample, account: &_| tally.add(sample, account, &names);
            match explain(frame, [x, y], 0..samples, &gives_up, &mut tell) {
                Some(()) => Ok(tally),
                None => Err("something else was asked for meanwhile".to_owned()),
            }
        });
        let tally = tally.map_err(|fault| fault.to_string())??;
        let film = &scene.camera.film;
        let size = (stage.share() != 1.0).then_some([film.width, film.height]);
        let replay = self.loading.replay([x, y], number, size);
        self.why = Some(answer(&tally, [x, y], number, &replay));
        Ok(Effects::default())
    }
}

fn answer(tally: &Tally, pixel: [u32; 2], frame: i64, replay: &str) -> Value {
    let luminance = tally.luminance();
    let error = tally.standard_error().filter(|_| luminance > 0.0);
    let all = luminance * f64::from(tally.samples);
    json!({
        "pixel": pixel,
        "frame": frame,
        "samples": tally.samples,
        "mean": tally.mean(),
        "error": error.map(|error| error / luminance),
        "rays": tally.rays,
        "bringing": tally.bringing,
        "tables": [
            { "title": "By light", "shares": shares(tally.lights()) },
            { "title": "By way, from the camera", "shares": shares(tally.ways()) },
            { "title": "By object seen first", "shares": shares(tally.seen()) },
            { "title": "By object that the light falls on first", "shares": shares(tally.lit()) },
        ],
        "brightest": tally.brightest().into_iter().map(|way| bright(way, all)).collect::<Vec<_>>(),
        "replay": replay,
    })
}

fn shares(mut shares: Vec<Share>) -> Vec<Value> {
    let rest = shares.split_off(shares.len().min(MOST_LINES));
    if !rest.is_empty() {
        let sum = |of: fn(&Share) -> f64| rest.iter().map(of).sum::<f64>();
        let (share, noise) = (sum(|of| of.share), sum(|of| of.noise));
        shares.push(Share { name: format!("{} others", rest.len()), mean: [0.0; 3], share, noise });
    }
    let value = |of: Share| json!({ "name": of.name, "share": of.share, "noise": of.noise });
    shares.into_iter().map(value).collect()
}

fn bright(bright: &Bright, all: f64) -> Value {
    let share = if all > 0.0 { bright.sum / all } else { 0.0 };
    json!({ "sample": bright.sample, "times": bright.times, "share": share, "way": bright.to_string() })
}
