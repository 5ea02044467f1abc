"""The interface between compare.py and a renderer: a process for each renderer, a line of JSON for each picture.

A renderer's module calls `serve` with a class and a function that makes the scene of a name (by default a still life).
`Renderer(scene, order)` has a `version` and
`render(samples, seed, threads)`, which returns the picture as an array [row, column, channel] of linear light, the
first row on top, and the processor time to be counted, in seconds. If `samples` does not mean a uniform number of
samples, the class also has `reference`, with the same arguments and results, for uniform samples.
"""

import json
import os
import sys

import numpy as np

import stills

NOT_INSTALLED, CANNOT = 3, 4


class Cannot(Exception):
    """The renderer lacks a feature that the scene needs."""


def user_time():
    """Returns the processor time, in seconds, of this process and its finished child processes."""
    times = os.times()
    return times.user + times.children_user


def serve(renderer_class, scene_of=stills.Still):
    order = json.loads(sys.argv[1])
    # Not standard output, since renderers print messages there.
    answers = os.fdopen(order["answers"], "w")
    try:
        renderer = renderer_class(scene_of(order["still"]), order)
    except Cannot as reason:
        print(reason, file=sys.stderr)
        os._exit(CANNOT)
    print(json.dumps({"version": renderer.version}), file=answers, flush=True)
    for line in sys.stdin:
        wish = json.loads(line)
        render = getattr(renderer, "reference", renderer.render) if wish["reference"] else renderer.render
        picture, seconds = render(wish["samples"], wish["seed"], wish["threads"])
        np.save(wish["picture"], np.ascontiguousarray(picture[..., :3], dtype=np.float32))
        print(json.dumps({"seconds": seconds}), file=answers, flush=True)
    answers.flush()
    # Some renderers crash at shutdown.
    os._exit(0)


def missing(error):
    """Exits the process of a renderer that is not installed."""
    print(error, file=sys.stderr)
    sys.exit(NOT_INSTALLED)
