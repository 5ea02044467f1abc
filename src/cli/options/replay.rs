//! The command that explains a pixel again.

use std::path::{Path, PathBuf};

use crate::cli::args::{ViewArgs, WhyArgs};
use crate::cli::values::{IntegratorName, Size, SizeChoice};

/// What a command line says of a scene and of its light.
#[derive(Clone, Debug, Default)]
pub(crate) struct Replay {
    scene: Option<PathBuf>,
    /// Whether `-s` stands in front of the scene.
    has_option: bool,
    indir: Option<PathBuf>,
    allow_outside: bool,
    size: Option<SizeChoice>,
    integrator: Option<IntegratorName>,
    photons: Option<f32>,
    seed: Option<u64>,
}

impl Replay {
    /// Takes the words of `why`.
    pub(crate) fn of(args: &WhyArgs) -> Self {
        let &WhyArgs { allow_outside, size, integrator, photons, seed, .. } = args;
        Self {
            scene: args.file.clone().or_else(|| args.scene.clone()),
            has_option: args.scene.is_some(),
            indir: args.indir.clone(),
            allow_outside,
            size,
            integrator,
            photons,
            seed,
        }
    }

    /// Takes the words of `view`.
    pub(crate) fn of_view(args: &ViewArgs) -> Self {
        let settings = &args.settings;
        Self {
            scene: args.scene.clone(),
            has_option: false,
            indir: args.indir.clone(),
            allow_outside: args.allow_outside,
            size: settings.size,
            integrator: settings.integrator,
            photons: settings.photons,
            seed: settings.seed,
        }
    }

    /// The same for a picture of another size.
    pub(crate) fn sized(self, width: u32, height: u32) -> Self {
        Self { size: Some(SizeChoice::Pixels(Size { width, height })), ..self }
    }

    /// The command, which names the scene as the user did.
    pub(crate) fn command(&self, [x, y]: [u32; 2], frame: Option<i64>) -> String {
        let mut command = format!("slo-rt why {x},{y}");
        if let Some(scene) = &self.scene {
            let option = if self.has_option { "-s " } else { "" };
            command += &format!(" {option}{}", quoted(scene));
        }
        if let Some(indir) = &self.indir {
            command += &format!(" --indir {}", quoted(indir));
        }
        if self.allow_outside {
            command += " --allow-outside";
        }
        if let Some(frame) = frame {
            command += &format!(" -f {frame}");
        }
        if let Some(size) = self.size {
            command += &format!(" --size {size}");
        }
        if let Some(integrator) = self.integrator {
            command += &format!(" --integrator {}", integrator.0.name().to_lowercase());
        }
        if let Some(photons) = self.photons {
            command += &format!(" --photons {photons}");
        }
        if let Some(seed) = self.seed {
            command += &format!(" --seed {seed}");
        }
        command
    }
}

/// A path as a shell reads it.
fn quoted(path: &Path) -> String {
    let path = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:\\".contains(c);
    // What begins with `-` would be an option.
    let path = if path.starts_with('-') { format!("./{path}") } else { path };
    if !path.is_empty() && path.chars().all(is_plain) {
        path
    } else {
        format!("'{}'", path.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scenes_are_named_as_they_were() {
        let replay = Replay { scene: Some("scene.txt".into()), ..Replay::default() };
        assert_eq!(replay.command([10, 20], None), "slo-rt why 10,20 scene.txt");
        let replay = Replay { has_option: true, indir: Some("my scenes".into()), ..replay };
        let expected = "slo-rt why 1,2 -s scene.txt --indir 'my scenes' -f 3 --size 64x48";
        assert_eq!(replay.sized(64, 48).command([1, 2], Some(3)), expected);
        assert_eq!(Replay::default().command([0, 0], None), "slo-rt why 0,0");
        assert_eq!(quoted(Path::new("it's")), r"'it'\''s'");
        assert_eq!(quoted(Path::new("-s.txt")), "./-s.txt");
    }
}
