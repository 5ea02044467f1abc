//! `--display-server`: pictures in a viewer while they are rendered.

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread::{self, JoinHandle};

use super::{Folder, SCENE};
use slo_picture::output::Raster;

/// Takes all packets of one connection: for each, its kind and what follows.
fn packets(listener: TcpListener) -> JoinHandle<Vec<(u8, Vec<u8>)>> {
    let next = |stream: &mut TcpStream| {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut packet).ok()?;
        let rest = packet.split_off(1);
        Some((packet[0], rest))
    };
    thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        std::iter::from_fn(|| next(&mut stream)).collect()
    })
}

fn folder() -> Folder {
    let size = "width 70 height 40";
    Folder::with_scene(&SCENE.replace("width 16 height 9", size).replace("PNG_IMAGE", "EXR_IMAGE"))
}

#[test]
fn a_viewer_gets_the_whole_picture() {
    let (folder, listener) = (folder(), TcpListener::bind("127.0.0.1:0").unwrap());
    let address = listener.local_addr().unwrap();
    let received = packets(listener);
    let printed = folder.printed(&format!("-q -s scene.txt -f 0-1 --display-server {address}"));
    assert_eq!(printed, "ball_00000.exr\nball_00001.exr\n");
    let received = received.join().unwrap();
    for name in ["ball_00000.exr", "ball_00001.exr"] {
        let image = Raster::read(&folder.path().join(name)).unwrap().image;
        let mut shown = vec![[0f32; 3]; image.rgb.len()];
        let head = [&[0], name.as_bytes(), &[0]].concat();
        let mine = received.iter().filter(|(_, packet)| packet.starts_with(&head));
        let mut kinds = Vec::new();
        for (kind, packet) in mine {
            kinds.push(*kind);
            let rest = &packet[head.len()..];
            let number = |at: usize| u32::from_le_bytes(rest[at..at + 4].try_into().unwrap());
            if *kind == 4 {
                assert_eq!([number(0), number(4), number(8)], [70, 40, 3]);
                continue;
            }
            let [x, y, width, height] = [10, 14, 18, 22].map(|at| number(at) as usize);
            let light =
                rest[26 + 48..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
            let light: Vec<f32> = light.collect();
            assert_eq!(light.len(), width * height * 3);
            for (i, rgb) in light.chunks(3).enumerate() {
                shown[(y + i / width) * 70 + x + i % width] = rgb.try_into().unwrap();
            }
        }
        assert_eq!(kinds[0], 4);
        assert!(kinds.len() > 6 && kinds[1..].iter().all(|kind| *kind == 6), "{kinds:?}");
        assert!(shown == image.rgb, "{name}");
    }
}

#[test]
fn a_viewer_that_is_not_there_or_goes_away_stops_nothing() {
    let folder = folder();
    folder.printed("-q -s scene.txt -od alone");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let leaves = thread::spawn(move || drop(listener.accept().unwrap()));
    let run = folder.run(&format!("-s scene.txt -od left --display-server {address}"));
    assert_eq!((run.exit, &*run.printed), (0, "left/ball_00000.exr\n"), "{}", run.said);
    leaves.join().unwrap();
    let run = folder.run(&format!("-s scene.txt -od missing --display-server {address}"));
    assert_eq!(run.exit, 0, "{}", run.said);
    assert!(run.said.contains("rendering goes on without it"), "{}", run.said);
    for name in ["left", "missing"] {
        let picture = folder.read(&format!("{name}/ball_00000.exr"));
        assert!(picture == folder.read("alone/ball_00000.exr"), "{name}");
    }
    assert_eq!(folder.run("-s scene.txt --display-server nowhere").exit, 2);
}
