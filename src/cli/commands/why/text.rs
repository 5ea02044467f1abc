//! The answer for people.

use std::fmt::Write;

use crate::cli::base::counted;
use slo_render::integrator::Account;
use slo_render::render::{Names, Share, Tally, luminance, rays_of, word};

/// Most lines of a table.
const MOST_LINES: usize = 12;

/// Most rays of a sample that are listed.
const MOST_RAYS: usize = 200;

/// Writes what a pixel is made of.
pub(super) fn summary(tally: &Tally, title: &str, replay: &str) -> String {
    let mut text = format!("{title}: {}", rgb(tally.mean()));
    let samples = if tally.samples == 1 { "sample" } else { "samples" };
    let _ = write!(text, ", {} {samples}", tally.samples);
    if let Some(error) = tally.standard_error().filter(|_| tally.luminance() > 0.0) {
        let _ = write!(text, ", standard error {}", percent(error / tally.luminance()).trim());
    }
    let rays = counted(tally.rays, "ray");
    let _ = writeln!(text, "\n{rays}; {} brought light", tally.bringing);
    if tally.unlisted > 0 {
        let _ = writeln!(
            text,
            "{} of them are too many to be listed: their light counts as that of the ray before",
            tally.unlisted
        );
    }
    for (heading, shares) in [
        ("by light", tally.lights()),
        ("by way, from the camera", tally.ways()),
        ("by object seen first", tally.seen()),
        ("by object that the light falls on first", tally.lit()),
    ] {
        table(&mut text, heading, &shares);
    }
    let brightest = tally.brightest();
    if !brightest.is_empty() {
        let _ = writeln!(text, "\nbrightest ways");
    }
    let all = tally.luminance() * f64::from(tally.samples);
    for bright in &brightest {
        let share = if all > 0.0 { bright.sum / all } else { 0.0 };
        let often = match bright.times {
            1 => format!("sample {}", bright.sample),
            times => format!("{times} times, most in sample {}", bright.sample),
        };
        let _ = writeln!(text, "{}  {often}: {bright}", percent(share));
    }
    if let Some(first) = brightest.first().filter(|_| tally.samples > 1) {
        let _ = writeln!(text, "\nall rays of one sample: {replay} --sample {}", first.sample);
    }
    text
}

fn table(text: &mut String, heading: &str, shares: &[Share]) {
    let _ = writeln!(text, "\n{heading:<46} light   noise");
    for Share { name, share, noise, .. } in shares.iter().take(MOST_LINES) {
        let _ = writeln!(text, "  {name:<42} {} {}", percent(*share), percent(*noise));
    }
    let rest = &shares[shares.len().min(MOST_LINES)..];
    if !rest.is_empty() {
        let sum = |of: fn(&Share) -> f64| rest.iter().map(of).sum::<f64>();
        let (share, noise) = (percent(sum(|of| of.share)), percent(sum(|of| of.noise)));
        let name = format!("{} others", rest.len());
        let _ = writeln!(text, "  {name:<42} {share} {noise}");
    }
}

/// Writes all rays of a sample as a tree.
pub(super) fn tree(account: &Account, names: &Names<'_>) -> String {
    let mut text =
        String::from("\nrays; each with its weight, and with the light that it brought\n");
    let mut children: Vec<Vec<u32>> = vec![Vec::new(); account.rays.len()];
    let mut roots = Vec::new();
    for (number, ray) in (0u32..).zip(&account.rays) {
        match ray.before {
            Some(before) => children[before as usize].push(number),
            None => roots.push(number),
        }
    }
    let listed: Vec<_> = rays_of(account).collect();
    let mut waiting: Vec<(u32, usize)> = roots.into_iter().rev().map(|root| (root, 0)).collect();
    let mut lines = 0;
    while let Some((number, depth)) = waiting.pop() {
        if lines == MOST_RAYS {
            let _ = writeln!(text, "... {} rays in all; --json lists them", account.rays.len());
            break;
        }
        lines += 1;
        let (ray, gains) = &listed[number as usize];
        let step = names.step(ray);
        let _ = write!(text, "{:indent$}{}", "", step, indent = 2 + 2 * depth);
        let _ = write!(text, "  x {}", rgb(step.weight.map(f64::from)));
        for gain in gains {
            let light = gain.light.map(|light| light.to_f64());
            let _ = write!(text, "  {} {}", word(gain.source), rgb(light));
            let _ = write!(text, " (luminance {:.4})", luminance(light));
        }
        text += if gains.is_empty() && step.light.is_some() { "  blocked\n" } else { "\n" };
        waiting.extend(children[number as usize].iter().rev().map(|child| (*child, depth + 1)));
    }
    text
}

fn rgb(light: [f64; 3]) -> String {
    light.map(|light| format!("{light:.4}")).join(" ")
}

fn percent(share: f64) -> String {
    format!("{:6.1} %", share * 100.0)
}
