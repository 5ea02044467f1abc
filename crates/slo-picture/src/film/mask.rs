//! Masks of names: Cryptomatte.
//!
//! Source: Cryptomatte specification 1.2.0, J. Friedman and A. C. Jones (Psyop, 2018). The hash is
//! MurmurHash3_x86_32 by A. Appleby.

use std::fmt::Write;

use slo_scene::{Layer, MaskNames};

/// Ids of a pixel that a file holds, by how many samples saw them.
pub(super) const RANKS: usize = 6;

/// What the names of a mask belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaskKind {
    /// Objects, and lamps that rays can hit.
    Object,
    /// Materials of objects.
    Material,
}

impl MaskKind {
    /// Both, in the order of files.
    pub const ALL: [Self; 2] = [Self::Object, Self::Material];

    /// The layer that asks for it.
    pub fn layer(self) -> Layer {
        match self {
            Self::Object => Layer::CryptoObject,
            Self::Material => Layer::CryptoMaterial,
        }
    }
}

/// A mask with the names that it may show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// What the names belong to.
    pub kind: MaskKind,
    /// The names.
    pub names: MaskNames,
}

impl Mask {
    /// The attributes of a file that holds the mask, with their values.
    pub fn attributes(&self) -> [(String, String); 4] {
        let name = self.kind.layer().name();
        let start = Self::attribute_start(self.kind);
        [
            ("conversion", "uint32_to_float32".to_owned()),
            ("hash", "MurmurHash3_32".to_owned()),
            ("manifest", self.manifest()),
            ("name", name.to_owned()),
        ]
        .map(|(key, value)| (format!("{start}{key}"), value))
    }

    /// The attribute of a file that holds the names.
    pub fn manifest_attribute(kind: MaskKind) -> String {
        Self::attribute_start(kind) + "manifest"
    }

    /// The mask that has such a manifest; without names if it is none.
    pub fn of_manifest(kind: MaskKind, manifest: &str) -> Self {
        let parsed: Option<serde_json::Map<String, serde_json::Value>> =
            serde_json::from_str(manifest).ok();
        let names = parsed.unwrap_or_default();
        Self { kind, names: MaskNames::new(names.keys().map(String::as_str)) }
    }

    fn attribute_start(kind: MaskKind) -> String {
        let key = format!("{:08x}", mask_hash(kind.layer().name().as_bytes()));
        format!("cryptomatte/{}/", &key[..7])
    }

    /// The names with their ids, as JSON in ASCII.
    fn manifest(&self) -> String {
        let mut json = String::from("{");
        for (i, name) in self.names.names().iter().enumerate() {
            let separator = if i == 0 { "" } else { "," };
            json += separator;
            push_ascii(&mut json, name);
            let _ = write!(json, ":\"{:08x}\"", mask_id(name));
        }
        json + "}"
    }
}

/// Appends a text as JSON in ASCII.
fn push_ascii(json: &mut String, text: &str) {
    for c in serde_json::Value::from(text).to_string().chars() {
        if c.is_ascii() {
            json.push(c);
            continue;
        }
        for unit in c.encode_utf16(&mut [0; 2]) {
            let _ = write!(json, "\\u{unit:04x}");
        }
    }
}

/// The id of a name: its hash, changed such that its bits are a normal f32.
pub fn mask_id(name: &str) -> u32 {
    let hash = mask_hash(name.as_bytes());
    match hash >> 23 & 255 {
        0 | 255 => hash ^ 1 << 23,
        _ => hash,
    }
}

/// MurmurHash3_x86_32 with the seed 0.
fn mask_hash(bytes: &[u8]) -> u32 {
    let mixed =
        |block: u32| block.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let mut hash = 0u32;
    let mut blocks = bytes.chunks_exact(4);
    for block in &mut blocks {
        let block = u32::from_le_bytes([block[0], block[1], block[2], block[3]]);
        hash = (hash ^ mixed(block)).rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let rest = blocks.remainder().iter().rev().fold(0, |rest, &byte| rest << 8 | u32::from(byte));
    hash ^= mixed(rest);
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_other_programs() {
        // From SMHasher, and from the tests of Gaffer and of Psyop's plugin.
        for (text, hash) in [
            ("", 0),
            ("test", 0xba6b_d213),
            ("Hello, world!", 0xc036_3e43),
            ("The quick brown fox jumps over the lazy dog", 0x2e4f_f723),
        ] {
            assert_eq!(mask_hash(text.as_bytes()), hash, "{text}");
        }
        let check = |name: &str, id: f64| {
            let found = f64::from(f32::from_bits(mask_id(name)));
            assert!((found - id).abs() < 1e-6 * id.abs(), "{name}: {found}");
        };
        check("hello", 6.070_562_710_24e-17);
        check("cube", -4.084_619_125_19e15);
        check("sphere", 2.790_186_043_83e15);
        check("plane", 3.665_576_175_93e-11);
        check("/GAFFERBOT/C_torso_GRP/C_head_GRP/C_head_CPT/C_head001_REN", -2.522_224_909_15e36);
    }

    #[test]
    fn ids_are_normal_numbers() {
        let mut changed = 0;
        for i in 0..100_000 {
            let name = format!("object {i}");
            let (hash, id) = (mask_hash(name.as_bytes()), mask_id(&name));
            assert!(f32::from_bits(id).is_normal(), "{name}");
            assert_eq!(hash & !(1 << 23), id & !(1 << 23), "{name}");
            changed += u32::from(hash != id);
        }
        // Two exponents of 256.
        assert!((600..1000).contains(&changed), "{changed}");
    }

    #[test]
    fn a_manifest_names_all_names() {
        let names = MaskNames::new(["cube", "K\u{fc}che \"1\"", "\u{1f4a1}"]);
        let mask = Mask { kind: MaskKind::Object, names };
        let attributes = mask.attributes();
        assert_eq!(attributes[0].0, "cryptomatte/f834d0a/conversion");
        assert_eq!(attributes[3].1, "crypto_object");
        assert_eq!(attributes[2].0, Mask::manifest_attribute(MaskKind::Object));
        let manifest = &attributes[2].1;
        assert!(manifest.is_ascii(), "{manifest}");
        let parsed: serde_json::Value = serde_json::from_str(manifest).unwrap();
        assert_eq!(parsed["cube"], format!("{:08x}", mask_id("cube")));
        assert_eq!(Mask::of_manifest(MaskKind::Object, manifest), mask);
        assert_eq!(Mask::of_manifest(MaskKind::Object, "no JSON").names, MaskNames::default());
    }
}
