//! Values of options: what can be typed for each, and what it stands for.

mod address;
mod bytes;
mod frame_path;
mod frames;
mod gain;
mod maps;
mod names;
mod numbers;
mod order;
mod part;
mod picture;
mod progress;
mod quality;
mod server;
mod threads;
mod time;

pub(crate) use address::address;
pub(crate) use bytes::bytes;
pub(crate) use frame_path::FramePath;
pub(crate) use frames::{FrameChoice, Frames, frame, frames, named, shown};
pub(crate) use gain::{Gain, gain};
pub(crate) use maps::{Map, Maps, check_name};
pub(crate) use names::{
    AcceleratorName, EncodingName, FormatName, IntegratorName, LayerName, ToneMapName, parameters,
};
pub(crate) use numbers::count;
pub(crate) use order::Order;
pub(crate) use part::{PartBy, part};
pub(crate) use picture::{PixelAt, Region, Size, SizeChoice, pixel_at, region, size};
pub(crate) use progress::ProgressForm;
pub(crate) use quality::{exposure, limit, noise, photons, samples, seed, steps};
pub(crate) use server::server;
pub(crate) use threads::{Threads, threads};
pub(crate) use time::{LONGEST_LEASE, SHORTEST_LEASE, interval, lease, time};
