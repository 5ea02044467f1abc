#!/usr/bin/env python3
"""Packs the Blender extension: extension.py SOURCE FOLDER writes FOLDER/slo_rt-VERSION.zip.

The zip has what `blender --command extension build` puts into it, without Blender, and with the same bytes each time:
files in the order of their names, as old as SOURCE_DATE_EPOCH says.
"""

import os
import pathlib
import sys
import time
import tomllib
import zipfile


def main():
    source, folder = (pathlib.Path(path) for path in sys.argv[1:3])
    manifest = tomllib.loads((source / "blender_manifest.toml").read_text())
    when = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH", "315532800")))[:6]
    files = (path for path in source.rglob("*") if path.is_file())
    files = sorted(path for path in files if "__pycache__" not in path.parts and not path.name.startswith("."))
    target = folder / f"{manifest['id']}-{manifest['version']}.zip"
    with zipfile.ZipFile(target, "w") as archive:
        for path in files:
            entry = zipfile.ZipInfo(path.relative_to(source).as_posix(), when)
            entry.external_attr = 0o644 << 16
            archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED, 9)


if __name__ == "__main__":
    main()
