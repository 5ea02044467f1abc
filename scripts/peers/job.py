"""How compare.py speaks with a renderer: a process of its own, a line of JSON for each picture.

A renderer's module calls `serve` with a class:
`Renderer(still, order)` has a `version` and `render(samples, seed, threads)`, which returns the picture as an array
[row, column, channel] of linear light, the first row on top, and the processor time that counts in seconds.
Where samples mean something else than the same number everywhere, `reference` does the same with that.
"""

import json
import os
import sys

import numpy as np

import stills

NOT_INSTALLED, CANNOT = 3, 4


class Cannot(Exception):
    """The renderer has not what the scene needs."""


def user_time():
    """Of this process and of those that it started and that have ended, in seconds."""
    times = os.times()
    return times.user + times.children_user


def serve(renderer_class):
    order = json.loads(sys.argv[1])
    # Not the standard output, where renderers print what they like.
    answers = os.fdopen(order["answers"], "w")
    try:
        renderer = renderer_class(stills.Still(order["still"]), order)
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
    # Some renderers crash when they are taken down.
    os._exit(0)


def missing(error):
    """Ends the module of a renderer that is not there."""
    print(error, file=sys.stderr)
    sys.exit(NOT_INSTALLED)
