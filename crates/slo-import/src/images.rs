//! Images that files name, as PNG or JPEG.

use std::collections::HashMap;
use std::io::Cursor;

use image::{DynamicImage, ImageFormat};

use crate::files::Source;
use crate::model::{Image, Model};

/// Images by the names that a file calls them.
#[derive(Debug, Default)]
pub(crate) struct Images {
    known: HashMap<String, Option<usize>>,
}

impl Images {
    /// The image of this name. It is looked for in these folders, as it is called and as PNG or JPEG; one
    /// that can't be read is noted.
    pub(crate) fn find(
        &mut self,
        source: &Source,
        name: &str,
        folders: &[&str],
        model: &mut Model,
    ) -> Option<usize> {
        if let Some(known) = self.known.get(name) {
            return *known;
        }
        let image = read(source, name, folders);
        if image.is_none() {
            let name: String = name.chars().take(40).collect();
            model.notes.leave_out(format!("the image `{name}`, which can't be read"));
        }
        let place = image.map(|image| {
            model.images.push(image);
            model.images.len() - 1
        });
        self.known.insert(name.to_owned(), place);
        place
    }
}

fn read(source: &Source, name: &str, folders: &[&str]) -> Option<Image> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let names = [name.to_owned(), format!("{stem}.png"), format!("{stem}.jpg")];
    let paths = folders.iter().flat_map(|folder| names.iter().map(move |n| format!("{folder}{n}")));
    let bytes = paths.filter_map(|path| source.beside(&path).ok()).map(|file| file.bytes);
    let stem = stem.rsplit(['/', '\\']).next().unwrap_or(stem);
    bytes.filter_map(|bytes| usual(stem, bytes)).next()
}

/// The image as a file that slo-rt reads.
fn usual(stem: &str, bytes: Vec<u8>) -> Option<Image> {
    match image::guess_format(&bytes).ok()? {
        ImageFormat::Png => Some(Image { name: format!("{stem}.png"), bytes }),
        ImageFormat::Jpeg => Some(Image { name: format!("{stem}.jpg"), bytes }),
        format => png(stem, &image::load_from_memory_with_format(&bytes, format).ok()?),
    }
}

/// An image as PNG.
pub(crate) fn png(stem: &str, image: &DynamicImage) -> Option<Image> {
    let mut bytes = Vec::new();
    image.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).ok()?;
    Some(Image { name: format!("{stem}.png"), bytes })
}
