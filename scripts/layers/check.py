"""Renders a picture with all layers and checks what other programs read in it.

    PYTHONPATH=FOLDER python3 scripts/layers/check.py PROGRAM

The folder holds PyPI's OpenEXR, mmh3 and numpy; `test.sh` fetches them.
"""

import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import mmh3
import numpy as np
import OpenEXR

# A red wall in the left half, 12 units away, behind a blue ball that slides by half a unit a frame.
SCENE = """
settings s { imageSamples 16 }
Camera c {
    fps 1
    Film f { width 64 height 64 prefix layers_ output EXR_IMAGE }
    CamSegment only { videoStart 0 videoEnd 3 sceneStart 0 sceneEnd 3
        addPosition { 0 -10 0 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart 0.5 }
}
light_point lamp { color { 1 1 1 } position { 0 -9 5 } }
phong_info red { diffuse { .6 .1 .1 } } material_phong red { phong_info red }
phong_info blue { diffuse { .1 .1 .6 } } material_phong blue { phong_info blue }
rectangle wall { material red vertex0 { -90 2 -90 } vertex1 { -0.1 2 -90 } vertex2 { -0.1 2 90 } }
sphere ball { center { 0 0 0 } radius 2 material blue
    addKframe { time 0 key { pivot { 0.5 0 0 } } } addKframe { time 3 key { pivot { 2 0 0 } } } }
"""
LAYERS = "depth,position,uv,motion,crypto_object,crypto_material,samples,error"
MASKS = {"crypto_object": {"ball", "wall", "lamp"}, "crypto_material": {"red", "blue"}}


def rendered(program, folder):
    """Renders frame 1 and returns its header and channels."""
    scene = Path(folder, "scene.txt")
    scene.write_text(SCENE)
    subprocess.run(
        [program, "-q", "-s", scene, "-f", "1", "--layers", LAYERS, "-od", folder],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    with OpenEXR.File(str(Path(folder, "layers_00001.exr")), separate_channels=True) as file:
        channels = {name: channel.pixels for name, channel in file.channels().items()}
        return dict(file.header()), channels


def mask_id(name):
    """The id of a name, as the specification of Cryptomatte says: its hash as a normal number."""
    value = mmh3.hash(name, signed=False)
    return value ^ 1 << 23 if value >> 23 & 255 in (0, 255) else value


def as_float(value):
    return struct.unpack("<f", struct.pack("<I", value))[0]


def covers(channels, layer, name):
    """The share of each pixel that an id covers, as programs for compositing add it up."""
    wanted, share = np.float32(as_float(mask_id(name))), 0
    for rank in range(3):
        for ids, shares in ("RG", "BA"):
            start = f"{layer}{rank:02}."
            share = share + np.where(channels[start + ids] == wanted, channels[start + shares], 0)
    return share


def check_masks(header, channels):
    for layer, names in MASKS.items():
        key = f"cryptomatte/{mmh3.hash(layer, signed=False):08x}"[: len("cryptomatte/") + 7]
        said = {what: header[f"{key}/{what}"] for what in ("name", "hash", "conversion", "manifest")}
        assert said["name"] == layer, said
        assert said["hash"] == "MurmurHash3_32", said
        assert said["conversion"] == "uint32_to_float32", said
        manifest = json.loads(said["manifest"])
        assert manifest == {name: f"{mask_id(name):08x}" for name in names}, manifest
    for layer, ball, wall in (
        ("crypto_object", "ball", "wall"), ("crypto_material", "blue", "red")
    ):
        ball, wall = covers(channels, layer, ball), covers(channels, layer, wall)
        assert ball[32, 38] == 1 and ball[5, 5] == 0 and wall[5, 5] == 1 and wall[5, 60] == 0
        shares = ball + wall
        assert shares.max() == 1 and set(np.unique(shares * 16)) <= set(range(17))
        edge = (ball > 0) & (ball < 1)
        assert 20 < edge.sum() < 120, edge.sum()
        # The silhouette of the ball: its centre is 1 to the right, and 6.4 pixels are a unit.
        radius = 32 * 2 / np.sqrt(10**2 - 2**2) / 0.5
        assert abs(ball.sum() - np.pi * radius**2) < 0.02 * ball.sum(), ball.sum()


def main():
    with tempfile.TemporaryDirectory() as folder:
        header, channels = rendered(sys.argv[1], folder)
    assert all(pixels.dtype == np.float32 for pixels in channels.values())
    check_masks(header, channels)
    depth = channels["depth.Z"]
    assert np.all(np.abs(depth[:8, :20] - 12) < 1e-4) and np.all(depth[:8, 50:] == 1e10)
    assert np.all(np.abs(channels["position.Y"][:8, :20] - 2) < 1e-4)
    assert np.all(channels["uv.A"][:8, :20] == 1) and np.all(channels["uv.A"][:8, 50:] == 0)
    # Half a unit to the right each frame, a little more than 3.2 pixels on the side of the eye.
    before, after = channels["motion.X"][32, 38], channels["motion.Z"][32, 38]
    assert -4.2 < before < -3.2 and -4.2 < after < -3.2, (before, after)
    assert np.all(np.abs(channels["motion.Y"][32, 36:40]) < 0.1)
    assert np.all(channels["motion.X"][:8, :20] == 0)
    assert np.all(channels["samples.X"] == 16)
    assert np.all(channels["error.R"] >= 0) and channels["error.R"].max() > 0
    print(f"{len(channels)} channels are as other programs expect them")


if __name__ == "__main__":
    main()
