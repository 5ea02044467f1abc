//! Tests of how typed arguments are understood.

use clap::{CommandFactory, Parser};

use super::{Args, Command};
use crate::cli::values::{FrameChoice, Frames, Threads};
use slo_scene::{Accelerator, Integrator};

#[test]
fn the_definition_is_sound() {
    Args::command().debug_assert();
}

fn parse(typed: &str) -> Result<Args, clap::Error> {
    Args::try_parse_from(format!("slo-rt {typed}").trim().split(' '))
}

fn frames(typed: &str) -> Option<Frames> {
    match parse(typed).unwrap().frame? {
        FrameChoice::These(frames) => Some(frames),
        FrameChoice::All => panic!("{typed}"),
    }
}

#[test]
fn frames_may_be_negative() {
    for typed in ["-f -5", "-f=-5", "-f-5", "--frame -5", "--frame=-5"] {
        assert_eq!(frames(typed), Some(Frames::single(-5)), "{typed}");
    }
    for typed in ["-f -5--1,3", "--frame=-5--1,3", "-f-5--1,3"] {
        let frames = frames(typed).unwrap();
        assert_eq!(frames.numbers, [-5, -4, -3, -2, -1, 3], "{typed}");
    }
    assert_eq!(frames("-f 15"), Some(Frames::single(15)));
    assert_eq!(parse("").unwrap().frame, None);
    for typed in ["-f all", "--frame=All"] {
        assert_eq!(parse(typed).unwrap().frame, Some(FrameChoice::All), "{typed}");
    }
}

#[test]
fn the_spelling_of_the_thesis_works() {
    assert_eq!(parse("--outdit x").unwrap().outdir, Some("x".into()));
    assert!(!Args::command().render_long_help().to_string().contains("outdit"));
}

#[test]
fn commands_stand_alone() {
    let merge = parse("merge a.part b.part --outdir out").unwrap();
    assert!(matches!(merge.command, Some(Command::Merge(args)) if args.files.len() == 2));
    assert!(parse("compare a.png b.png --max-flip 0.1 --map c.png").is_ok());
    assert!(parse("verify a.png -s scene.txt --tiles 3").is_ok());
    assert!(parse("sheet a.png b.png --columns 2").is_ok());
    assert!(parse("denoise a.exr b.png --outdir out --library lib.so --threads 2").is_ok());
    for limited in ["", "merge a.part", "compare a b", "bake s.txt", "view s.txt", "why 1,2"] {
        let args = parse(format!("{limited} --memory-limit 2GB").trim()).unwrap();
        assert_eq!(args.memory_limit, Some(2_000_000_000), "{limited}");
    }
    assert!(parse("--memory-limit 2GB merge a.part").is_err());
    for limit in ["nan", "-0.1", "inf", "x"] {
        for name in ["rmse", "relative-mse", "bias", "flip"] {
            assert!(parse(&format!("compare a b --max-{name} {limit}")).is_err(), "{limit}");
        }
    }
    for bad in ["merge", "merge a -f 3", "-f 3 merge a", "help", "compare a", "sheet", "verify"] {
        assert!(parse(bad).is_err(), "{bad}");
    }
}

#[test]
fn wrong_values_are_refused() {
    for bad in [
        "-f x",
        "-f 1.5",
        "-f 99999999999999999999",
        "-f",
        "-f --quiet",
        "-f 1-5 --order random",
        "--progress loud",
        "--overwrite --skip-existing",
        "--overwrite --share",
        "--share=0",
        "--checkpoint -1",
        "--time 0",
        "--time 5x",
        "--time 5s --noise 0.1",
        "--time 5s --part 1/2",
        "-f 1-3 --total-time 0",
        "-f 1-3 --total-time 5s --time 1s",
        "-f 1-3 --total-time 5s --noise 0.1",
        "-f 1-3 --total-time 5s --steps 5,0",
        "-f 1-3 --total-time 5s --part 1/2",
        "-f 1-3 --total-time 5s --region 4x4+0+0",
        "-f 1-3 --total-time 5s --share",
        "-f 1-3 --total-time 5s --info",
        "--steps 5",
        "--steps 99,0",
        "--noise 0",
        "--noise -1",
        "--noise nan",
        "--noise 2",
        "--part-by samples",
        "--part 1/2 --info",
        "--threads 0",
        "--samples 0",
        "--samples 65536",
        "--samples -1",
        "--seed -1",
        "--accelerator tree",
        "--integrator photon_maps",
        "--photons -1",
        "--photons 101",
        "--color blue",
        "--exposure 33",
        "--tone-map filmic",
        "--layers depths",
        "--layers albedo,",
        "--layers",
        "--format jpeg",
        "--indir x",
        "--quiet --verbose",
        "scene.txt",
        "--recipe a --check",
        "-f 1 -f 2",
        "--frame= ",
    ] {
        assert!(parse(bad).is_err(), "{bad}");
    }
}

#[test]
fn numbers_below_their_range_are_told_the_range() {
    for (typed, said) in [("--samples -3", "from 1 to 65535"), ("--threads -1", "from 1 to 4096")] {
        let error = parse(typed).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    for (typed, said) in [
        ("--time -5s", "expected a time"),
        ("-f 1-2 --total-time -1h", "expected a time"),
        ("--steps -1,0", "expected a step"),
        ("--size -4x4", "each from 1 to 65536"),
        ("--part -1/3", "expected a number"),
        ("--region -4x4+0+0", "such as 320x180+0+90"),
        ("--noise 1e-50", "too close to 0"),
        ("--photons -1", "from 0 to 100"),
    ] {
        let error = parse(typed).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    assert!(parse("--seed -1").unwrap_err().to_string().contains("'--seed <N>'"));
}

#[test]
fn numbers_are_taken_as_people_write_them() {
    let samples = |typed: &str| parse(typed).unwrap().settings.samples;
    assert_eq!((samples("--samples 1e3"), samples("--samples 1_000")), (Some(1000), Some(1000)));
    assert_eq!(parse("--seed 0xff").unwrap().settings.seed, Some(255));
    let threads = |typed: &str| parse(typed).unwrap().threads;
    assert_eq!(threads("--threads auto"), Some(Threads::All));
    assert_eq!(threads("--threads 4"), Some(Threads::Count(4)));
    let checkpoint = |typed: &str| parse(typed).unwrap().checkpoint.as_secs();
    assert_eq!((checkpoint(""), checkpoint("--checkpoint 90s")), (60, 90));
    assert_eq!((checkpoint("--checkpoint 0"), checkpoint("--checkpoint=none")), (0, 0));
    let share = |typed: &str| parse(typed).unwrap().share.map(|lease| lease.as_secs());
    assert_eq!((share("--share"), share("--share=5m"), share("")), (Some(60), Some(300), None));
    assert_eq!(parse("--noise 1%").unwrap().settings.noise, Some(0.01));
}

#[test]
fn names_may_be_in_capitals() {
    for typed in [
        "--format EXR",
        "--format PNG16_IMAGE",
        "--order Reverse",
        "--part 1/2 --part-by Samples",
        "--layers Albedo,NORMAL",
        "--tone-map AGX",
        "--encoding Srgb",
        "--progress Plain",
        "--color NEVER",
    ] {
        assert!(parse(typed).is_ok(), "{typed}");
    }
}

/// Returns the options of the program and its commands that take a value, each after the arguments
/// that its command needs.
fn options_with_values() -> Vec<(Vec<&'static str>, String)> {
    let positional = |command: &str| match command {
        "compare" => vec!["compare", "a.png", "b.png"],
        "sheet" => vec!["sheet", "a.png"],
        "verify" => vec!["verify", "a.png"],
        "denoise" => vec!["denoise", "a.png"],
        "relight" => vec!["relight", "a.exr"],
        "merge" => vec!["merge", "a.part"],
        "import" => vec!["import", "a.obj"],
        "bake" => vec!["bake", "a.txt"],
        "why" => vec!["why", "0,0"],
        "view" => vec!["view", "a.txt"],
        "generate" => vec!["generate", "man"],
        other => panic!("a command without a test: {other}"),
    };
    let of = |command: &clap::Command, typed: Vec<&'static str>| -> Vec<_> {
        let with_value = command.get_arguments().filter(|arg| arg.get_action().takes_values());
        let names = with_value.filter_map(|arg| arg.get_long());
        names.map(|name| (typed.clone(), format!("--{name}"))).collect()
    };
    let args = Args::command();
    let commands = args.get_subcommands().flat_map(|c| of(c, positional(c.get_name())));
    of(&args, Vec::new()).into_iter().chain(commands).collect()
}

#[test]
fn no_refusal_is_a_programmers() {
    let mut refused = 0;
    for (typed, option) in options_with_values() {
        for value in ["", "x", "-1", "1.5", "1e400", "99999999999999999999999", "١", "nan", "0x"] {
            let joined = format!("{option}={value}");
            let args = ["slo-rt"].into_iter().chain(typed.iter().copied()).chain([&*joined]);
            let Err(error) = Args::try_parse_from(args) else { continue };
            if error.kind() == clap::error::ErrorKind::MissingRequiredArgument {
                continue;
            }
            let said = error.to_string();
            refused += 1;
            for raw in ["digit found", "parse", "number too", "cannot be", "float", "ParseInt"] {
                assert!(!said.contains(raw), "{joined}: {said}");
            }
            let helps = ["such as", "possible values", "a value is required"];
            assert!(helps.iter().any(|help| said.contains(help)), "{joined}: {said}");
        }
    }
    assert!(refused > 100, "{refused}");
}

#[test]
fn integrators_may_be_spelt_as_in_scenes() {
    for (name, integrator) in Integrator::NAMES {
        for name in [name.to_owned(), name.to_lowercase()] {
            let parsed = parse(&format!("--integrator {name}")).unwrap().settings.integrator;
            assert_eq!(parsed.map(|name| name.0), Some(integrator), "{name}");
        }
    }
}

#[test]
fn accelerators_may_be_spelt_as_in_scenes() {
    for (name, accelerator) in Accelerator::NAMES {
        for name in [name.to_owned(), name.to_lowercase()] {
            let parsed = parse(&format!("--accelerator {name}")).unwrap().settings.accelerator;
            assert_eq!(parsed.map(|name| name.0), Some(accelerator), "{name}");
        }
    }
}
