"""slo-rt on the frames of flicker.py. `photonSeed` does what `fixed` says; everything else differs from frame to frame."""

import subprocess
import tempfile
from pathlib import Path

import flicker_job
import job
from light_slo_rt import read_exr, scene_text

SETTINGS = {
    "path": "photons .5",
    "photon_map": "photonMapSize 200000 causticMapSize 200000",
    "preview": "photonMapSize 60000 causticMapSize 60000 photonNearest 100 gather 0",
    "cache": "photonMapSize 200000 causticMapSize 200000 cacheError .2 gatherRays 256",
}


class SloRt(flicker_job.Calibrated):
    def __init__(self, order):
        self.order, self.folder = order, tempfile.TemporaryDirectory()
        try:
            self.version = subprocess.run(
                [order["program"], "--version"], check=True, capture_output=True, text=True
            ).stdout.split()[-1]
        except FileNotFoundError as error:
            job.missing(error)

    def timed(self, frame, seed, samples, threads, number):
        folder, order = Path(self.folder.name), self.order
        settings = SETTINGS[order["how"]] + (" photonSeed FIXED" if order["fixed"] else "")
        text = scene_text(frame, folder, settings)
        if order["how"] != "path":
            text = text.replace("integrator PATH", "integrator PHOTON_MAP")
        (folder / "scene.txt").write_text(text, encoding="utf-8")
        began = job.user_time()
        command = [
            order["program"],
            "-q",
            "--overwrite",
            "-s",
            folder / "scene.txt",
            "-f",
            str(number),
            "--samples",
            str(samples),
            "--threads",
            str(threads),
            "--outdir",
            folder,
        ]
        words = subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True).stdout
        return read_exr(words.strip().splitlines()[-1]), job.user_time() - began


if __name__ == "__main__":
    flicker_job.serve(SloRt)
