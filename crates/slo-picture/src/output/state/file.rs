//! States in files: checkpoints, parts, pictures that may get more samples.
//!
//! All numbers are little-endian:
//!
//! | bytes | what |
//! |---|---|
//! | 8 | `slo-rt` and two zeros |
//! | 4 | [`VERSION`] |
//! | 4 + n | length of the recipe, the recipe as JSON |
//! | 16 | area of the film: x0, y0, x1, y1 |
//! | 16 | region that was asked for |
//! | 8 | numbers of the first sample and one past the last, 0 and 0 if samples are not shared out |
//! | 4 | 1 with spreads, 2 complete, 4 with features, 8 with the light of groups, 16 depth, 32 position, 64 uv, 128 motion, 256 objects, 512 materials |
//! | 4, (4 + n) each | with the light of groups: their number, and the length and the name of each; with objects, with materials: the same |
//! | 4 each | how many samples each pixel has, row by row |
//! | 24, 24, 48, 48 each | of the pixels that have any: sums; of those with more than one or a share of samples: base; with spreads: least and most; with features: albedo and normal; with the light of groups: 24 each; of depth, position, uv and motion: 16 for the number of hits, 16 for each number; with objects, with materials: 4 for the number of ids, and for each 4 and how many samples saw it in 4 |
//! | 32 | BLAKE3 over all before |

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::Path;

use slo_scene::{LightGroups, MaskNames};

use super::check::{Bounds, check_places};
use crate::film::{
    Area, Features, Film, FirstHitLayers, FirstHits, Fixed, MaskKind, Pixel, PlaceLayers,
    SignedFixed, Spread, State, Subject, Wide,
};
use crate::output::file::{open_regular, write_atomically};

/// Changes with the layout of the file.
pub(super) const VERSION: u32 = 1;
/// The first bytes of every state.
pub(in crate::output) const MAGIC: [u8; 8] = *b"slo-rt\0\0";
const LONGEST_RECIPE: u32 = 1 << 16;
const WITH_SPREADS: u32 = 1;
const COMPLETE: u32 = 2;
const WITH_FEATURES: u32 = 4;
const WITH_LIGHTS: u32 = 8;
const WITH_DEPTH: u32 = 16;
const WITH_POSITION: u32 = 32;
const WITH_UV: u32 = 64;
const WITH_MOTION: u32 = 128;
const WITH_OBJECTS: u32 = 256;
const WITH_MATERIALS: u32 = 512;
/// The sum of all flags.
const FLAGS: u32 = 2 * WITH_MATERIALS - 1;
/// Most bytes of the name of an object or a material.
const LONGEST_NAME: usize = 1 << 20;
/// Length of the hash at the end.
pub(super) const HASH: u64 = 32;
const BUFFER: usize = 1 << 16;

/// Writes `state` to `path`, which holds the old file or the complete new one at any time.
///
/// # Errors
/// What the system says.
pub fn write_state(path: &Path, state: &State) -> io::Result<()> {
    write_atomically(path, |file| {
        let hashed = Hashed { inner: file, hasher: blake3::Hasher::new() };
        let mut out = BufWriter::with_capacity(BUFFER, hashed);
        write_header(&mut out, state)?;
        write_pixels(&mut out, state)?;
        let out = out.into_inner().map_err(io::IntoInnerError::into_error)?;
        out.inner.write_all(out.hasher.finalize().as_bytes())
    })
}

fn write_header(out: &mut impl Write, state: &State) -> io::Result<()> {
    out.write_all(&MAGIC)?;
    put(out, VERSION)?;
    let subject = &state.subject;
    put(out, subject.recipe.len() as u32)?;
    out.write_all(subject.recipe.as_bytes())?;
    for area in [subject.area, subject.region] {
        [area.x0, area.y0, area.x1, area.y1].into_iter().try_for_each(|n| put(out, n))?;
    }
    let range = subject.samples.clone().unwrap_or(0..0);
    put(out, range.start)?;
    put(out, range.end)?;
    let flags = [
        (subject.with_spreads, WITH_SPREADS),
        (state.is_complete, COMPLETE),
        (subject.with_features, WITH_FEATURES),
        (subject.light_groups.is_some(), WITH_LIGHTS),
        (subject.first_hits.places.depth, WITH_DEPTH),
        (subject.first_hits.places.position, WITH_POSITION),
        (subject.first_hits.places.uv, WITH_UV),
        (subject.first_hits.places.motion, WITH_MOTION),
        (subject.first_hits.objects.is_some(), WITH_OBJECTS),
        (subject.first_hits.materials.is_some(), WITH_MATERIALS),
    ];
    put(out, flags.iter().filter(|(is_set, _)| *is_set).map(|(_, flag)| flag).sum())?;
    if let Some(groups) = &subject.light_groups {
        put_names(out, groups.names())?;
    }
    let mut masks = MaskKind::ALL.iter().filter_map(|kind| subject.first_hits.names(*kind));
    masks.try_for_each(|names| put_names(out, names.names()))
}

fn put_names(out: &mut impl Write, names: &[String]) -> io::Result<()> {
    put(out, names.len() as u32)?;
    names.iter().try_for_each(|name| {
        put(out, name.len() as u32)?;
        out.write_all(name.as_bytes())
    })
}

fn write_pixels(out: &mut impl Write, state: &State) -> io::Result<()> {
    let pixels = state.film.pixels();
    pixels.iter().try_for_each(|pixel| put(out, pixel.samples))?;
    for (i, pixel) in pixels.iter().enumerate().filter(|(_, pixel)| pixel.samples > 0) {
        put_color(out, pixel.sum)?;
        if has_base(pixel, state.subject.samples.is_some()) {
            put_color(out, pixel.base)?;
        }
        if let Some(spread) = state.film.spreads().get(i) {
            put_color(out, spread.least)?;
            put_color(out, spread.most)?;
        }
        if let Some(features) = state.film.features().get(i) {
            put_signed(out, features.albedo)?;
            put_signed(out, features.normal)?;
        }
        state.film.lights(i).iter().try_for_each(|light| put_color(out, *light))?;
        put_first_hits(out, state.film.first_hits(), i)?;
    }
    Ok(())
}

fn put_first_hits(out: &mut impl Write, hits: &FirstHits, i: usize) -> io::Result<()> {
    let put_wide = |sum: &Wide| out.write_all(&sum.units().to_le_bytes());
    hits.places(i).iter().try_for_each(put_wide)?;
    for ids in MaskKind::ALL.iter().filter_map(|kind| hits.ids(*kind, i)) {
        put(out, ids.entries().len() as u32)?;
        for (id, count) in ids.entries() {
            put(out, *id)?;
            put(out, *count)?;
        }
    }
    Ok(())
}

fn has_base(pixel: &Pixel, is_share: bool) -> bool {
    pixel.samples > 1 || is_share
}

fn put(out: &mut impl Write, number: u32) -> io::Result<()> {
    out.write_all(&number.to_le_bytes())
}

fn put_color(out: &mut impl Write, color: [Fixed; 3]) -> io::Result<()> {
    put_three(out, color.map(|c| c.units().to_le_bytes()))
}

fn put_signed(out: &mut impl Write, numbers: [SignedFixed; 3]) -> io::Result<()> {
    put_three(out, numbers.map(|n| n.units().to_le_bytes()))
}

fn put_three(out: &mut impl Write, numbers: [[u8; 8]; 3]) -> io::Result<()> {
    out.write_all(numbers.as_flattened())
}

/// Reads the state at `path`. Nothing in the file is trusted: a file that is truncated, damaged, of
/// another program, or that holds impossible numbers is refused.
///
/// # Errors
/// What the system says, and `InvalidData` with what is wrong.
pub fn read_state(path: &Path) -> io::Result<State> {
    read(open_regular(path)?).map_err(cut_off)
}

/// Reads the subject of the state at `path`, and whether it is complete, without its samples.
///
/// # Errors
/// As [`read_state`].
pub fn read_subject(path: &Path) -> io::Result<(Subject, bool)> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len().saturating_sub(HASH);
    let header = Header::read(&mut BufReader::new(file)).map_err(cut_off)?;
    header.check(length)?;
    Ok((header.subject, header.is_complete))
}

fn cut_off(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => bad("it was cut off"),
        _ => error,
    }
}

fn read(file: File) -> io::Result<State> {
    let length = file.metadata()?.len().saturating_sub(HASH);
    let hashed = Hashed { inner: file.take(length), hasher: blake3::Hasher::new() };
    let mut input = BufReader::with_capacity(BUFFER, hashed);
    let header = Header::read(&mut input)?;
    let bounds = header.check(length)?;
    let film = read_film(&mut input, &header.subject, &bounds)?;
    if input.read(&mut [0])? != 0 {
        return Err(bad("it is damaged"));
    }
    let Hashed { inner, hasher } = input.into_inner();
    let mut expected = [0; HASH as usize];
    inner.into_inner().read_exact(&mut expected)?;
    if hasher.finalize() == expected { Ok(header.state(film)) } else { Err(bad("it is damaged")) }
}

/// All before the pixels.
struct Header {
    subject: Subject,
    is_complete: bool,
}

impl Header {
    fn read(input: &mut impl Read) -> io::Result<Self> {
        let mut magic = [0; 8];
        input.read_exact(&mut magic).map_err(|_| bad("it is no state of slo-rt"))?;
        if magic != MAGIC {
            return Err(bad("it is no state of slo-rt"));
        }
        if get(input)? != VERSION {
            return Err(bad("it is of another version of slo-rt"));
        }
        let length = get(input)?;
        if length > LONGEST_RECIPE {
            return Err(bad("it is damaged"));
        }
        let mut recipe = vec![0; length as usize];
        input.read_exact(&mut recipe)?;
        let recipe = String::from_utf8(recipe).map_err(|_| bad("it is damaged"))?;
        let (area, region) = (get_area(input)?, get_area(input)?);
        let samples = Some(get(input)?..get(input)?).filter(|range| *range != (0..0));
        let flags = get(input)?;
        if flags > FLAGS {
            return Err(bad("it is of another version of slo-rt"));
        }
        let has = |flag: u32| flags & flag != 0;
        let light_groups = if has(WITH_LIGHTS) { Some(get_groups(input)?) } else { None };
        let places = PlaceLayers {
            depth: has(WITH_DEPTH),
            position: has(WITH_POSITION),
            uv: has(WITH_UV),
            motion: has(WITH_MOTION),
        };
        let objects = if has(WITH_OBJECTS) { Some(get_mask_names(input)?) } else { None };
        let materials = if has(WITH_MATERIALS) { Some(get_mask_names(input)?) } else { None };
        let subject = Subject {
            recipe,
            area,
            region,
            samples,
            with_spreads: has(WITH_SPREADS),
            with_features: has(WITH_FEATURES),
            light_groups,
            first_hits: FirstHitLayers { places, objects, materials },
        };
        Ok(Self { subject, is_complete: has(COMPLETE) })
    }

    /// Whether a file of `length` bytes can hold what the header says, before memory is allocated.
    fn check(&self, length: u64) -> io::Result<Bounds> {
        let bounds = Bounds::of(&self.subject, self.is_complete).map_err(damaged)?;
        match self.subject.area.len() as u64 * 4 < length {
            true => Ok(bounds),
            false => Err(damaged("it is too short for its pixels")),
        }
    }

    fn state(self, film: Film) -> State {
        State { subject: self.subject, film, is_complete: self.is_complete }
    }
}

fn read_film(input: &mut impl Read, subject: &Subject, bounds: &Bounds) -> io::Result<Film> {
    let mut film = subject.film().map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    for i in 0..subject.area.len() {
        let samples = get(input)?;
        bounds.check_count(samples).map_err(damaged)?;
        film.at_mut(i).0.samples = samples;
    }
    for i in 0..subject.area.len() {
        let (pixel, spread) = film.at_mut(i);
        if pixel.samples == 0 {
            continue;
        }
        read_pixel(input, pixel, spread, subject.samples.is_some())?;
        if let Some(features) = film.features_mut(i) {
            *features = Features { albedo: get_signed(input)?, normal: get_signed(input)? };
        }
        for light in film.lights_mut(i) {
            *light = get_color(input)?;
        }
        let (spread, features) = (film.spreads().get(i), film.features().get(i));
        bounds.check_pixel(&film.pixels()[i], spread, features, film.lights(i)).map_err(damaged)?;
        let samples = film.pixels()[i].samples;
        get_first_hits(input, film.first_hits_mut(), i, samples)?;
    }
    Ok(film)
}

/// Reads what a pixel of so many samples shows of what camera rays hit first.
fn get_first_hits(
    input: &mut impl Read,
    hits: &mut FirstHits,
    i: usize,
    samples: u32,
) -> io::Result<()> {
    for sum in hits.places_mut(i) {
        let mut bytes = [0; 16];
        input.read_exact(&mut bytes)?;
        *sum = Wide::from_units(i128::from_le_bytes(bytes));
    }
    check_places(hits, i, samples).map_err(damaged)?;
    for kind in MaskKind::ALL {
        let Some(ids) = hits.ids_mut(kind, i) else { continue };
        let count = get(input)?;
        let (mut last, mut seen) = (None, 0u32);
        for _ in 0..count {
            let (id, times) = (get(input)?, get(input)?);
            seen = seen.saturating_add(times);
            if last >= Some(id) || times == 0 || seen > samples {
                return Err(damaged("its ids do not fit its samples"));
            }
            last = Some(id);
            ids.add(id, times).ok_or_else(|| damaged("its ids do not fit its samples"))?;
        }
    }
    Ok(())
}

fn read_pixel(
    input: &mut impl Read,
    pixel: &mut Pixel,
    spread: Option<&mut Spread>,
    is_share: bool,
) -> io::Result<()> {
    pixel.sum = get_color(input)?;
    if has_base(pixel, is_share) {
        pixel.base = get_color(input)?;
    }
    if let Some(spread) = spread {
        *spread = Spread { least: get_color(input)?, most: get_color(input)? };
    }
    Ok(())
}

fn get(input: &mut impl Read) -> io::Result<u32> {
    let mut bytes = [0; 4];
    input.read_exact(&mut bytes)?;
    Ok(u32::from_le_bytes(bytes))
}

fn get_area(input: &mut impl Read) -> io::Result<Area> {
    let area = Area { x0: get(input)?, y0: get(input)?, x1: get(input)?, y1: get(input)? };
    if area.x0 < area.x1 && area.y0 < area.y1 { Ok(area) } else { Err(bad("it is damaged")) }
}

/// Reads the groups of lights, which are in their order.
fn get_groups(input: &mut impl Read) -> io::Result<LightGroups> {
    let names = get_names(input, LightGroups::MOST, LightGroups::LONGEST)?;
    let groups = LightGroups::new(names.iter().map(String::as_str));
    if groups.names() == names { Ok(groups) } else { Err(bad("it is damaged")) }
}

/// Reads the names of a mask, which are in their order.
fn get_mask_names(input: &mut impl Read) -> io::Result<MaskNames> {
    let names = get_names(input, u32::MAX as usize, LONGEST_NAME)?;
    let mask = MaskNames::new(names.iter().map(String::as_str));
    if mask.names() == names { Ok(mask) } else { Err(bad("it is damaged")) }
}

/// Reads names, at most so many of so many bytes.
fn get_names(input: &mut impl Read, most: usize, longest: usize) -> io::Result<Vec<String>> {
    let count = get(input)? as usize;
    if count > most {
        return Err(bad("it is damaged"));
    }
    let mut names = Vec::new();
    for _ in 0..count {
        let length = get(input)? as usize;
        if length > longest {
            return Err(bad("it is damaged"));
        }
        let mut name = vec![0; length];
        input.read_exact(&mut name)?;
        names.push(String::from_utf8(name).map_err(|_| bad("it is damaged"))?);
    }
    Ok(names)
}

fn get_color(input: &mut impl Read) -> io::Result<[Fixed; 3]> {
    Ok(get_three(input)?.map(|bytes| Fixed::from_units(u64::from_le_bytes(bytes))))
}

fn get_signed(input: &mut impl Read) -> io::Result<[SignedFixed; 3]> {
    Ok(get_three(input)?.map(|bytes| SignedFixed::from_units(i64::from_le_bytes(bytes))))
}

fn get_three(input: &mut impl Read) -> io::Result<[[u8; 8]; 3]> {
    let mut numbers = [[0; 8]; 3];
    input.read_exact(numbers.as_flattened_mut())?;
    Ok(numbers)
}

fn damaged(why: &str) -> io::Error {
    bad(format!("it is damaged: {why}"))
}

fn bad(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// Hashes what goes through it.
struct Hashed<T> {
    inner: T,
    hasher: blake3::Hasher,
}

impl<T: Write> Write for Hashed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<T: Read> Read for Hashed<T> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(bytes)?;
        self.hasher.update(&bytes[..read]);
        Ok(read)
    }
}
