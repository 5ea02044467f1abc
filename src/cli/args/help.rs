//! Texts of `--help`.

pub(super) const ABOUT: &str = "Renders frames of a scene file: motion blur, depth of field, soft shadows, \
                     glossy surfaces.";

pub(super) const LONG_ABOUT: &str = "\
slo-rt renders frames of a scene file to pictures: motion blur, depth of field, soft shadows,
glossy reflection and refraction.

Without arguments it renders frame 0 of its built-in scene and prints the path of the picture.
For a sequence, the same command again renders only what is missing, damaged or out of date.";

pub(super) const EXAMPLES: &str = "\
Examples:
  slo-rt                                the built-in scene, to see that everything works
  slo-rt -s table.txt -f 15             frame 15 of a scene
  slo-rt -s table.txt -f 0-100 -od out  a sequence; again: only what is missing
  slo-rt -s table.txt -f 0-100 -od out --share
                                        the same on each of several machines
  slo-rt -s table.txt -f 0-100 -od out --total-time 8h
                                        as clean as possible overnight
  slo-rt -s table.txt --check           find mistakes, render nothing
  slo-rt -s table.txt --size 320x180 --samples 4
                                        a quick draft
  slo-rt -f 15 -s table.txt -id input/scenes -od output/table
                                        folders for input and output
  slo-rt -s table.txt --part 3/10       the third of ten parts, for the third machine
  slo-rt merge *.part                   the pictures from all parts
  slo-rt sheet out/*.png                a contact sheet of the pictures
  slo-rt denoise draft_00015.exr        remove the noise from a picture
  slo-rt relight room.exr -g lamp=0.5 -o dim.png
                                        dim lights of a picture made with `--layers lights`
  slo-rt bake room.txt -o maps          the light on objects, as images
  slo-rt why 320,180 -s room.txt        where the light of a pixel comes from
  slo-rt --recipe default_00000.png     how a picture was made

The paths of the pictures go to standard output, everything else to standard error.";

pub(super) const EXIT_CODES: &str = "\
Exit codes:
    0  done
    1  rendering failed, there is not enough memory, or a file could not be read or
       written; or some frames of a sequence failed and the others are done
    2  the command line is wrong, or the scene has no such frame
   65  the scene, a mesh or a texture has errors; or a picture or a part is damaged
   66  an input file is missing or can't be read
   69  the GPU that the accelerator needs is missing or can't take the scene
   73  the picture can't be created, or a file that slo-rt did not make has its name
   74  the picture can't be written
   75  stopped by Ctrl-C or a signal; the same command continues
  130  ended at once by a second Ctrl-C or signal

Environment:
  NO_COLOR, CLICOLOR_FORCE, TERM=dumb   colours as usual; --color overrides them
  SLO_RT_ISA=avx512|avx2|neon|portable  instruction set; the picture is the same
  SLO_RT_GPU=NAME                       a part of the name of the GPU to use";

/// Heading of the options that replace settings of the scene.
pub(super) const SETTINGS: &str = "Overrides of the scene's settings";
