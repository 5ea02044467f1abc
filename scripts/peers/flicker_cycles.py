"""Cycles, from PyPI's bpy, on the frames of flicker.py."""

import flicker_job
from light_cycles import Cycles


class Frames(flicker_job.Calibrated):
    version = Cycles.version

    def __init__(self, order):
        self.order = order

    def timed(self, frame, seed, samples, threads, number):
        return Cycles(frame, self.order).render(samples, seed, threads)


if __name__ == "__main__":
    flicker_job.serve(Frames)
