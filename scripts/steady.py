#!/usr/bin/env python3
# /// script
# dependencies = ["numpy", "opencv-python-headless"]
# ///
"""Takes the flicker out of denoised frames: averages each with its neighbours, along the motion in the picture.

    python3 scripts/steady.py denoised/film_ steady/film_
    python3 scripts/steady.py denoised/film_ steady/film_ --first 100 --last 199

Frames are the pictures named by the first prefix, five digits and .png, 8 or 16 bits. A denoiser guesses anew in each
frame; the mean of two frames before, two after and the frame itself flickers less and is sharper than one of them. A
neighbour does not count where it shows something else.
"""

import argparse
import glob
import os
import re
import sys

try:
    import cv2
    import numpy as np
except ImportError as error:
    sys.exit("steady.py: %s; try: pip install numpy opencv-python-headless" % error)

SIGMA = .026
"""Difference, of a range of 1, at which a neighbour counts 0.6 times."""


class Frames:
    """Pictures and the motion between neighbours; only those near the current frame are kept."""

    def __init__(self, paths, radius):
        self.paths, self.kept = paths, 2 * radius + 2
        self.pictures, self.flows = {}, {}
        self.optical_flow = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)

    def picture(self, i):
        if i not in self.pictures:
            values = cv2.imread(self.paths[i], cv2.IMREAD_UNCHANGED)
            if values is None or values.ndim != 3:
                sys.exit("steady.py: `%s` is not a picture in colour" % self.paths[i])
            values = values[..., :3].astype("f4") / np.iinfo(values.dtype).max
            grey = cv2.GaussianBlur(cv2.cvtColor(values, cv2.COLOR_BGR2GRAY), (0, 0), 1.0)
            self.pictures[i] = values, (grey * 255.0).astype("u1")
            self.forget(self.pictures, i, lambda key: key)
        return self.pictures[i]

    def flow(self, i, j):
        """Where the pixels of picture i are in picture j, relative to their place in i."""
        if (i, j) not in self.flows:
            self.flows[i, j] = self.optical_flow.calc(self.picture(i)[1], self.picture(j)[1], None)
            self.forget(self.flows, i, lambda key: key[0])
        return self.flows[i, j]

    def forget(self, kept, i, place):
        for key in [key for key in kept if abs(place(key) - i) > self.kept]:
            del kept[key]


def moved(values, flow, border, outside=0.0):
    height, width = flow.shape[:2]
    x, y = np.meshgrid(np.arange(width, dtype="f4"), np.arange(height, dtype="f4"))
    return cv2.remap(values, x + flow[..., 0], y + flow[..., 1], cv2.INTER_LINEAR, borderMode=border,
                     borderValue=(outside,) * 4)


def steady(frames, i, radius):
    """Picture i, averaged with up to `radius` pictures on each side."""
    picture = frames.picture(i)[0]
    even = cv2.GaussianBlur(picture, (0, 0), 2.0)
    total, weights = picture.copy(), np.ones(picture.shape[:2] + (1,), "f4")
    for side in (-1, 1):
        way = None
        for n in range(1, radius + 1):
            j = i + side * n
            if j not in frames.paths:
                break
            step = frames.flow(j - side, j)
            way = step if way is None else way + moved(step, way, cv2.BORDER_REPLICATE)
            other = moved(frames.picture(j)[0], way, cv2.BORDER_CONSTANT, -9.0)
            # Noise is finer than this blur; what differs beyond it is another thing
            off = ((cv2.GaussianBlur(other, (0, 0), 2.0) - even) ** 2).mean(-1, keepdims=True)
            weight = np.exp(off / (-2.0 * SIGMA * SIGMA)) * (1.0 if n == 1 else .7)
            weight[other.min(-1) < 0.0] = 0.0
            total += weight * other
            weights += weight
    return total / weights


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("frames", help="prefix of the denoised pictures")
    words.add_argument("to", help="prefix of the pictures to be written")
    words.add_argument("--radius", type=int, default=2, help="neighbours on each side (2)")
    words.add_argument("--first", type=int, help="first frame to be written")
    words.add_argument("--last", type=int, help="last frame to be written")
    words = words.parse_args()
    found = glob.glob(glob.escape(words.frames) + "[0-9]" * 5 + ".png")
    paths = {int(re.search(r"(\d{5})\.png$", path).group(1)): path for path in found}
    if not paths:
        sys.exit("steady.py: there are no pictures `%sNNNNN.png`" % words.frames)
    os.makedirs(os.path.dirname(words.to) or ".", exist_ok=True)
    cv2.setNumThreads(1)
    frames = Frames(paths, words.radius)
    for i in sorted(paths):
        if (words.first is None or i >= words.first) and (words.last is None or i <= words.last):
            values = steady(frames, i, words.radius) * 255.0
            # Dither: without it, dark gradients show bands
            values += np.random.default_rng(i).uniform(0.0, 1.0, values.shape)
            path = "%s%05d.png" % (words.to, i)
            cv2.imwrite(path, values.clip(0.0, 255.0).astype("u1"))
            print(path, flush=True)


if __name__ == "__main__":
    main()
