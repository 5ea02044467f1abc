"""slo-rt with adaptive sampling: twice as many "samples" mean half of `--noise`."""

import job
from render_slo_rt import SloRt, scene_text

NOISE_AT_ONE = 0.64


class AdaptiveSloRt(SloRt):
    def __init__(self, still, order):
        super().__init__(still, order)
        self.adaptive = self.write("adaptive.txt", scene_text(still, "imageMinSamples 4 imageSamples 4096"))

    def reference(self, samples, seed, threads):
        return super().render(samples, seed, threads)

    def render(self, samples, seed, threads):
        return self.rendered(self.adaptive, seed, threads, "--noise", NOISE_AT_ONE / samples)


if __name__ == "__main__":
    job.serve(AdaptiveSloRt)
