//! The answer for programs.

use serde_json::{Value, json};

use slo_render::integrator::{Account, AccountRay, Gain};
use slo_render::render::{Bright, Names, Share, Step, Tally, rays_of, word};

/// What a pixel is made of. `account` is that of the only sample, if there is one.
pub(super) fn answer(
    tally: &Tally,
    (pixel, frame): ([u32; 2], i64),
    account: Option<(&Account, &Names<'_>)>,
) -> Value {
    let mut answer = json!({
        "pixel": pixel,
        "frame": frame,
        "samples": tally.samples,
        "mean": tally.mean(),
        "luminance": tally.luminance(),
        "standardError": tally.standard_error(),
        "rays": tally.rays,
        "raysThatBroughtLight": tally.bringing,
        "unlistedRays": tally.unlisted,
        "byLight": shares(tally.lights()),
        "byWay": shares(tally.ways()),
        "bySeenObject": shares(tally.seen()),
        "byLitObject": shares(tally.lit()),
        "brightest": tally.brightest().into_iter().map(bright).collect::<Vec<_>>(),
    });
    if let Some((account, names)) = account {
        answer["tree"] = rays(account, names);
    }
    answer
}

fn shares(shares: Vec<Share>) -> Value {
    let share = |Share { name, mean, share, noise }: Share| json!({ "name": name, "mean": mean, "share": share, "noise": noise });
    shares.into_iter().map(share).collect()
}

fn bright(bright: &Bright) -> Value {
    json!({
        "sample": bright.sample,
        "source": word(bright.source),
        "light": bright.light,
        "luminance": bright.luminance,
        "times": bright.times,
        "sumOfLuminance": bright.sum,
        "way": bright.steps.iter().map(step).collect::<Vec<_>>(),
    })
}

fn step(step: &Step) -> Value {
    json!({
        "leg": step.leg,
        "light": step.light,
        "object": step.object,
        "material": step.material,
        "time": step.time,
        "position": step.position,
        "weight": step.weight,
    })
}

/// All rays of a sample. A ray names the one before it by its place in the list.
fn rays(account: &Account, names: &Names<'_>) -> Value {
    let ray = |(ray, gains): (&AccountRay, Vec<&Gain>)| {
        let mut value = step(&names.step(ray));
        value["before"] = json!(ray.before);
        value["depth"] = json!(ray.depth);
        let gain = |gain: &&Gain| {
            let light = gain.light.map(|light| light.to_f64());
            json!({ "source": word(gain.source), "light": light })
        };
        value["brought"] = gains.iter().map(gain).collect();
        value
    };
    rays_of(account).map(ray).collect()
}
