//! Settings that are one of several words of the scene language: each word stands here.

use super::choice::choices;

choices! {
    /// Which light is found.
    pub enum Integrator {
        /// Light that comes straight from lamps, and what mirrors, gloss and glass see.
        Distributed = "DISTRIBUTED",
        /// All light.
        Path = "PATH",
        /// All light, smooth and with a bias: photon mapping.
        PhotonMap = "PHOTON_MAP",
    }
}

impl Integrator {
    /// `recursion` if a scene does not say it.
    pub const fn recursion(self) -> u32 {
        match self {
            Self::Distributed => 3,
            Self::Path | Self::PhotonMap => 16,
        }
    }

    /// `lightSamplingType` if a scene does not say it.
    pub const fn light_sampling(self) -> LightSampling {
        match self {
            Self::Distributed => LightSampling::All,
            Self::Path | Self::PhotonMap => LightSampling::One,
        }
    }
}

choices! {
    /// The structure that rays are traced through.
    pub enum Accelerator {
        /// SAH kd-tree.
        KdTree = "KDTREE",
        /// 8-wide bounding volume hierarchy.
        Bvh = "BVH",
        /// obvhs's compressed wide hierarchy, the library yardstick.
        Cwbvh = "CWBVH",
        /// Every primitive is tested.
        None = "NONE",
        /// Uniform grid, to study.
        Grid = "GRID",
        /// Octree, to study.
        Octree = "OCTREE",
        /// Binary hierarchy of halves, to study.
        Median = "MEDIAN",
        /// Packed R-tree, to study.
        RTree = "RTREE",
        /// Binary hierarchy by the surface area heuristic, to study.
        Binary = "BINARY",
        /// Plain kd-tree with several traversals, to study.
        Kd = "KD",
        /// The boxes of all primitives, to study.
        Boxes = "BOXES",
        /// `Grid`, traversed by a GPU.
        GpuGrid = "GPU_GRID",
        /// `Kd` with a short stack, traversed by a GPU.
        GpuKd = "GPU_KD",
        /// `Binary`, traversed by a GPU.
        GpuBvh = "GPU_BVH",
    }
}

impl Accelerator {
    /// Whether a GPU traverses the structure.
    pub const fn needs_gpu(self) -> bool {
        matches!(self, Self::GpuGrid | Self::GpuKd | Self::GpuBvh)
    }
}

choices! {
    /// Which points the integral is sampled at.
    pub enum Generator {
        /// Independent uniform numbers.
        Pseudo = "PSEUDO",
        /// Owen-scrambled (0,2)-sequences that go well together.
        Quasi = "QUASI",
        /// The thesis's XOR-scrambled (0,2)-sequence.
        ZeroTwo = "ZERO_TWO",
    }
}

choices! {
    /// How many lights a hit asks.
    #[derive(Default)]
    pub enum LightSampling {
        /// One light, chosen at random in proportion to the light that is expected from it.
        One = "SAMPLE_ONE_AT_TIME",
        /// Every light.
        #[default]
        All = "SAMPLE_ALL_AT_TIME",
    }
}

choices! {
    /// The contrast of a sample `I` with the mean `E` (thesis 5.12 to 5.14).
    pub enum Contrast {
        /// |I - E|
        Difference = "DIFFERENCE",
        /// |I - E| / E
        Weber = "WEBER",
        /// |I - E| / (I + E)
        Michelson = "MICHELSON",
    }
}

choices! {
    /// What a refractive object does to light that passes through it on its way to a hit.
    pub enum ShadowMode {
        /// Blocks it.
        Opaque = "OPAQUE",
        /// Lets `refraction` of it through, unbent.
        Transparent = "TRANSPARENT",
    }
}

choices! {
    /// What the random numbers of photons depend on.
    #[derive(Default)]
    pub enum PhotonSeed {
        /// The seed and the frame.
        #[default]
        Frame = "FRAME",
        /// The seed alone: what is left of their noise stands still where the scene does.
        Fixed = "FIXED",
    }
}

choices! {
    /// How the photons of caustics count by their distance.
    #[derive(Default)]
    pub enum CausticFilter {
        /// Less with distance, in proportion to it.
        #[default]
        Cone = "CONE",
        /// All alike.
        None = "NONE",
    }
}

choices! {
    /// How radiance becomes an encoded value of a file, such as a PNG's.
    #[derive(Default)]
    pub enum Encoding {
        /// Clamped and scaled, as in the thesis.
        #[default]
        Raw = "RAW",
        /// Linear light to sRGB.
        Srgb = "SRGB",
    }
}

choices! {
    /// What compresses radiance of any size into the range of a screen, before the encoding.
    #[derive(Default)]
    pub enum ToneMap {
        /// Nothing: what is brighter than white is clamped.
        #[default]
        None = "NONE",
        /// AgX in its base look, as in Blender: what is bright loses contrast first, then colour.
        Agx = "AGX",
    }
}

choices! {
    /// What a file holds beside the colours. Its word is the one of the command line, of recipes and of
    /// channels in files.
    #[derive(PartialOrd, Ord)]
    pub enum Layer {
        /// The share of light that surfaces reflect, whatever light falls on them: red, green, blue
        /// from 0 to 1.
        Albedo = "albedo",
        /// Shading normals of surfaces, on the visible side: x, y, z in the scene's axes, of length 1
        /// where there is one surface, and 0 where there is none.
        Normal = "normal",
        /// The light of each group of lights, one layer a group: their sum is the picture.
        Lights = "lights",
        /// Distance along the view of what camera rays hit, in units of the scene.
        Depth = "depth",
        /// Where camera rays hit something: x, y, z in the scene's axes.
        Position = "position",
        /// Texture coordinates of what camera rays hit.
        Uv = "uv",
        /// By how many pixels what camera rays hit moves from the frame before to this one, and from
        /// this one to the next.
        Motion = "motion",
        /// Which objects camera rays hit, and how many of a pixel's rays: Cryptomatte.
        CryptoObject = "crypto_object",
        /// Which materials camera rays hit, and how many of a pixel's rays: Cryptomatte.
        CryptoMaterial = "crypto_material",
        /// Number of samples.
        Samples = "samples",
        /// Estimated standard error of the colours: red, green, blue.
        Error = "error",
    }
}

impl Layer {
    /// Whether it shows surfaces, whatever light falls on them, for denoisers.
    pub fn is_of_surfaces(self) -> bool {
        matches!(self, Self::Albedo | Self::Normal)
    }
}

choices! {
    /// How values of an image encode light.
    pub enum Curve {
        /// They are linear.
        Raw = "RAW",
        /// They follow the curve of sRGB.
        Srgb = "SRGB",
    }
}

choices! {
    /// How an image continues outside of the unit square.
    pub enum Wrap {
        /// It repeats.
        Repeat = "REPEAT",
        /// Its edge continues.
        Clamp = "CLAMP",
        /// It repeats, each time mirrored.
        Mirror = "MIRROR",
    }
}

choices! {
    /// Which way is up in the file of a mesh.
    #[derive(Default, Hash)]
    pub enum Axes {
        /// z, as in scenes.
        #[default]
        ZUp = "Z_UP",
        /// y; z points forward.
        YUp = "Y_UP",
    }
}

choices! {
    /// How the motion of key frames goes on before the first and after the last.
    pub enum Repeat {
        /// It begins again.
        Cycle = "CYCLE",
        /// It begins again from where it ended.
        Offset = "OFFSET",
        /// It runs back and forth.
        PingPong = "PINGPONG",
    }
}

choices! {
    /// How values between the texels of an image come about.
    pub enum Filter {
        /// From the four nearest texels.
        Linear = "LINEAR",
        /// From the nearest texel.
        Nearest = "NEAREST",
    }
}
