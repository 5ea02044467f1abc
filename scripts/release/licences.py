#!/usr/bin/env python3
"""Licences of all crates that are part of the program, and a bill of materials.

    licences.py --check              fail if a crate may not be shipped
    licences.py --texts FILE         write all licences with their texts
    licences.py --sbom FILE          write a bill of materials, CycloneDX 1.5

Needs cargo and the sources of the crates, which cargo has after a build.
"""

import argparse
import hashlib
import json
import pathlib
import re
import subprocess
import sys
import tomllib
import uuid

ROOT = pathlib.Path(__file__).resolve().parents[2]

# Licences under which the program may be shipped.
ALLOWED = set(tomllib.loads((ROOT / "deny.toml").read_text())["licenses"]["allow"])

# Names of files that hold a licence.
TEXTS = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


def crates(target, features):
    """The crates of the program for a target, by name and version: what cargo knows of each."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target]
    if features:
        command += ["--features", features]
    answer = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout
    data = json.loads(answer)
    packages = {package["id"]: package for package in data["packages"]}
    nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
    root = next(id for id, package in packages.items() if package["name"] == "slo-rt")
    needs, waiting = {}, [root]
    while waiting:
        id = waiting.pop()
        if id in needs:
            continue
        # Neither tests nor build scripts are part of the program.
        is_part = lambda dep: any(kind["kind"] is None for kind in dep["dep_kinds"])
        needs[id] = [dep["pkg"] for dep in nodes[id]["deps"] if is_part(dep)]
        waiting += needs[id]
    return root, packages, needs


def may_ship(expression):
    """Whether an SPDX expression offers a choice of which all parts are allowed."""
    # Older crates divide alternatives by a slash.
    tokens = re.findall(r"\(|\)|[^\s()]+", expression.replace("/", " OR "))

    def either():
        answer = both()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            answer = both() or answer
        return answer

    def both():
        answer = one()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            answer = one() and answer
        return answer

    def one():
        name = tokens.pop(0)
        if name == "(":
            answer = either()
            tokens.pop(0)
            return answer
        if tokens and tokens[0] == "WITH":
            tokens.pop(0)
            name += " WITH " + tokens.pop(0)
        return name in ALLOWED

    answer = either()
    if tokens:
        raise ValueError(f"not understood: {expression}")
    return answer


def is_ours(package):
    return package["source"] is None


def texts_of(package):
    """The files of a crate that hold its licence: their names and texts."""
    folder = pathlib.Path(package["manifest_path"]).parent
    files = sorted(path for path in folder.iterdir() if path.is_file() and TEXTS.search(path.name))
    files = [path for path in files if path.suffix not in (".rs", ".toml")]
    named = package.get("license_file")
    if named and (folder / named) not in files:
        files.append(folder / named)
    return [(path.name, path.read_text(errors="replace").replace("\r\n", "\n").strip()) for path in files]


def all_texts(packages):
    """All licences: first who has which, then each text once."""
    numbers, lines = {}, []
    for package in packages:
        own = [numbers.setdefault(text, len(numbers) + 1) for _, text in texts_of(package)]
        where = package["repository"] or f"https://crates.io/crates/{package['name']}"
        texts = ", ".join(str(number) for number in sorted(set(own))) or "none in the crate"
        lines.append(f"{package['name']} {package['version']}\n    {package['license']}; texts: {texts}\n    {where}\n")
    head = (
        "slo-rt contains the crates that follow, and the standard library of Rust (https://www.rust-lang.org, MIT or\n"
        "Apache-2.0). Each is named with its licence, the numbers of its texts below, and where it comes from.\n"
    )
    parts = [f"{'=' * 100}\nText {number}\n{'=' * 100}\n\n{text}\n" for text, number in numbers.items()]
    return "\n".join([head, *lines, *parts])


def purl(package):
    return f"pkg:cargo/{package['name']}@{package['version']}"


def sbom(root, packages, needs):
    """A bill of materials; the same for the same Cargo.lock."""
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    sums = {(entry["name"], entry["version"]): entry.get("checksum") for entry in lock["package"]}

    def component(package, kind):
        entry = {
            "type": kind,
            "bom-ref": purl(package),
            "name": package["name"],
            "version": package["version"],
            "licenses": [{"expression": package["license"].replace("/", " OR ")}],
            "purl": purl(package),
        }
        checksum = sums.get((package["name"], package["version"]))
        if checksum:
            entry["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        if package["repository"]:
            entry["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
        return entry

    ordered = sorted(needs, key=lambda id: (packages[id]["name"], packages[id]["version"]))
    refs = lambda id: sorted({purl(packages[need]) for need in needs[id]})
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": component(packages[root], "application")},
        "components": [component(packages[id], "library") for id in ordered if id != root],
        "dependencies": [{"ref": purl(packages[id]), "dependsOn": refs(id)} for id in ordered],
    }
    digest = hashlib.sha256(json.dumps(bill, sort_keys=True).encode()).digest()
    return {**bill, "serialNumber": f"urn:uuid:{uuid.UUID(bytes=digest[:16], version=4)}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="fail if a crate may not be shipped")
    parser.add_argument("--texts", metavar="FILE", type=pathlib.Path, help="write all licences")
    parser.add_argument("--sbom", metavar="FILE", type=pathlib.Path, help="write a bill of materials")
    parser.add_argument("--target", default="x86_64-unknown-linux-gnu", help="target [default: %(default)s]")
    parser.add_argument("--features", default="", help="features of slo-rt beside its default ones")
    args = parser.parse_args()

    root, packages, needs = crates(args.target, args.features)
    foreign = [packages[id] for id in needs if not is_ours(packages[id])]
    foreign.sort(key=lambda package: (package["name"], package["version"]))
    refused = [package for package in foreign if not may_ship(package["license"] or "none")]
    for package in refused:
        print(f"{package['name']} {package['version']}: may not be shipped under `{package['license']}`", file=sys.stderr)
    if refused:
        return 1
    if args.texts:
        args.texts.write_text(all_texts(foreign))
    if args.sbom:
        args.sbom.write_text(json.dumps(sbom(root, packages, needs), indent=2) + "\n")
    print(f"{len(foreign)} crates, all under licences that allow shipping")
    return 0


if __name__ == "__main__":
    sys.exit(main())
