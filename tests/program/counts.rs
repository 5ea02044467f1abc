//! Counts of rays, and maps of their costs.

use serde_json::Value;

use crate::Folder;

fn table(folder: &Folder, name: &str) -> Value {
    serde_json::from_slice(&folder.read(name)).expect("a table")
}

#[test]
fn rays_are_counted_by_kind_whatever_the_structure() {
    let folder = Folder::new();
    folder.printed("-q -s scene.txt");
    let expected = folder.read("ball_00000.png");
    let mut rays = vec![];
    for structure in ["bvh", "kdtree", "none", "grid", "octree", "kd", "rtree"] {
        let name = format!("{structure}.json");
        folder.printed(&format!("-q -s scene.txt --accelerator {structure} --count {name}"));
        assert!(folder.read("ball_00000.png") == expected, "{structure}");
        let table = table(&folder, &name);
        assert_eq!(table["accelerator"], structure.to_uppercase());
        let camera = &table["rays"]["camera"];
        assert_eq!(camera["rays"], 16 * 9 * 2);
        assert!(camera["sum"]["tests"].as_u64() >= camera["hits"].as_u64(), "{structure}");
        assert_eq!(table["structures"][0]["primitives"], 1);
        let of = |kind: &str| [&table["rays"][kind]["rays"], &table["rays"][kind]["hits"]];
        rays.push(["camera", "shadow", "specular"].map(|kind| of(kind).map(Value::clone)));
    }
    assert!(rays.iter().all(|other| *other == rays[0]), "{rays:?}");
}

#[test]
fn parameters_of_structures_are_read_and_told() {
    let folder = Folder::new();
    let options = "--accelerator grid --accelerator-options cells=2x3x4,mailbox=1";
    folder.printed(&format!("-q -s scene.txt {options} --count c_#.json --cost-map m_#.exr"));
    let table = table(&folder, "c_0.json");
    assert_eq!(table["accelerator_options"], "cells=2x3x4,mailbox=1");
    assert_eq!(table["structures"][0]["cells"], serde_json::json!([2, 3, 4]));
    assert!(folder.path().join("m_0.exr").is_file());
    // An earlier table is replaced, and nothing else.
    folder.printed("-q -s scene.txt --count c_0.json --cost-map m_0.exr");
    let refused = |typed: &str, exit: i32, said: &str| {
        let run = folder.run(&format!("-s scene.txt {typed}"));
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
    };
    folder.write("other.json", "{ \"name\": 1 }");
    refused("--count other.json", 73, "no counts");
    refused("--count c.txt", 2, "not named as a .json file");
    refused("--count c.json -f 0-2", 2, "####");
    refused("--accelerator-options densty=3", 2, "did you mean `density`?");
    refused("--accelerator cwbvh --count c.json", 2, "CWBVH does not count");
}
