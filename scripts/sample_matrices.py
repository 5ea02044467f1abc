#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy"]
# ///
"""Searches for the matrices of crates/slo-render/src/sampling/matrices.rs and prints the file.

    uv run scripts/sample_matrices.py --seconds 600 >crates/slo-render/src/sampling/matrices.rs

Needs numpy, which `uv run` fetches.

A path takes its random numbers from groups of dimensions: lens, time, pixel, and for each of the first hits a point
and a choice. The two dimensions of a group are a (0,2)-sequence. The matrix of the first dimension may be any upper
triangular matrix with ones on the diagonal; the matrix of the second is the matrix of binomial coefficients times the
first. So the matrices of the first dimensions are free. They are chosen column by column such that the groups are well
distributed together. The figure of merit is the variance of an Owen-scrambled net, for integrands with a part of
variance 2^-(k - 1) at each scale 2^-k in each dimension.

A second search finds masks, one for each pixel of a block of 8 x 8. A mask is XORed to the points of its pixel before
the scramble, which is the same in the whole block. The points of neighbours then complement each other, whatever their
number: the joint error of 2 x 2, 4 x 4 and 8 x 8 pixels is smaller than with independent points.
"""

import argparse
import itertools
import sys
import time

try:
    import numpy as np
except ModuleNotFoundError as error:
    sys.exit(f"sample_matrices.py: {error}; start it by `uv run` or `pipx run`, or `pip install numpy`")

LENS, TIME, PIXEL = "lens", "time", "pixel"
POINTS, CHOICES = ("point 0", "point 1", "point 2"), ("choice 0", "choice 1", "choice 2")
A, B, C = POINTS
CHOICE_A, CHOICE_B, CHOICE_C = CHOICES
PLANES = (LENS, PIXEL, *POINTS)
GROUPS = (LENS, TIME, PIXEL, A, CHOICE_A, B, CHOICE_B, C, CHOICE_C)

# Groups that should be well distributed together, with weights.
TOGETHER = {
    (PIXEL, A): 3, (LENS, A): 3, (TIME, PIXEL): 2, (A, B): 2, (LENS, PIXEL): 1.5, (TIME, A): 1.5, (PIXEL, B): 1.5,
    (TIME, LENS): 1, (LENS, PIXEL, A): 1, (TIME, PIXEL, A): 1, (LENS, B): 1, (PIXEL, A, B): 1, (TIME, B): 0.5,
    (B, C): 0.5, (A, C): 0.5, (PIXEL, C): 0.5, (LENS, C): 0.3, (TIME, C): 0.2,
    (A, CHOICE_A): 1.5, (PIXEL, CHOICE_A): 0.7, (LENS, CHOICE_A): 0.5, (TIME, CHOICE_A): 0.3, (PIXEL, A, CHOICE_A): 0.3,
    (B, CHOICE_B): 0.5, (A, CHOICE_B): 0.2, (PIXEL, CHOICE_B): 0.2, (CHOICE_A, CHOICE_B): 0.2,
    (C, CHOICE_C): 0.3, (B, CHOICE_C): 0.2, (PIXEL, CHOICE_C): 0.2,
}
# No pair may be badly distributed: where a picture depends on both, more samples would not improve it.
for pair in itertools.combinations(GROUPS, 2):
    TOGETHER.setdefault(pair if pair in TOGETHER else pair[::-1], 0.1)
# The same for the samples of neighbouring pixels, which see different points but the same lights.
NEIGHBOURS = {
    (A,): 2, (LENS,): 1.5, (TIME,): 1, (B,): 1, (PIXEL,): 0.5, (C,): 0.5, (CHOICE_A,): 0.5, (CHOICE_B,): 0.2,
    (LENS, A): 2, (TIME, A): 1, (PIXEL, A): 1, (A, B): 0.7, (A, CHOICE_A): 0.5, (LENS, PIXEL): 0.5, (TIME, PIXEL): 0.5,
    (LENS, TIME): 0.5, (LENS, TIME, A): 0.5, (B, C): 0.2, (A, C): 0.2, (PIXEL, B): 0.2,
}

COLUMNS = 12  # beyond 2^12 samples, the columns are random
MASK_DIGITS = 16
BLOCK_BITS = 6
INFLUENCE = 0.5  # part of a dimension in the variance, over all scales


def binomial(words):
    """Returns the second dimension of a plane, given the first. The lowest bit is the most significant digit."""
    for shift, bits in ((1, 0xAAAAAAAA), (2, 0xCCCCCCCC), (4, 0xF0F0F0F0), (8, 0xFF00FF00), (16, 0xFFFF0000)):
        words = words ^ ((words & np.uint64(bits)) >> np.uint64(shift))
    return words


def kernel_by_common_digits():
    """Returns 1 + the sum of weighted Walsh functions, by the number of equal leading digits of two numbers."""
    scales = 2.0 ** -np.arange(40)
    scales /= scales.sum()
    equal = np.concatenate([[0], np.cumsum(scales)])
    return 1 + INFLUENCE * (equal[:33] - scales[:33])


KERNEL = kernel_by_common_digits()


def kernel(group, words):
    """Returns the kernel between zero and points that differ from it by `words` in the group's first dimension."""
    def of(digits):
        lowest = digits & (~digits + np.uint64(1))
        return KERNEL[np.where(digits == 0, 32, np.log2(np.maximum(lowest, 1).astype(np.float64))).astype(int)]

    return of(words) * of(binomial(words)) if group in PLANES else of(words)


def product(values, groups):
    result = 1.0
    for group in groups:
        result = result * values[group]
    return result


def search_matrices(random):
    """Searches for the columns of each group's first matrix."""
    matrices = {group: [] for group in GROUPS}
    points = {group: np.zeros(1, dtype=np.uint64) for group in GROUPS}
    for column in range(COLUMNS):
        starts = range(1 if column < 2 else 4 if column < 8 else 2)
        _, best = min((search_column(random, points, 1 << column) for _ in starts), key=lambda found: found[0])
        for group in GROUPS:
            matrices[group].append(best[group])
            points[group] = np.concatenate([points[group], points[group] ^ np.uint64(best[group])])
    return matrices, points


def search_column(random, points, diagonal):
    """Finds one column for all groups by descent from a random start; returns it with the remaining variance."""
    columns = {group: diagonal | int(random.integers(diagonal)) for group in GROUPS}
    columns[PIXEL] = diagonal
    old = {group: kernel(group, points[group]) for group in GROUPS}
    new = {group: kernel(group, points[group] ^ np.uint64(columns[group])) for group in GROUPS}
    old_part = sum(weight * product(old, groups).mean() for groups, weight in TOGETHER.items())
    figure = lambda: old_part + sum(weight * product(new, groups).mean() for groups, weight in TOGETHER.items())
    best, improved = figure(), True
    while improved:
        improved = False
        for group in GROUPS:
            if group == PIXEL:
                continue
            candidates = np.arange(diagonal) if diagonal <= 512 else random.integers(diagonal, size=512)
            candidates = candidates.astype(np.uint64) | np.uint64(diagonal)
            table = kernel(group, points[group][None, :] ^ candidates[:, None])
            others = sum(
                weight * product(new, [g for g in groups if g != group]) for groups, weight in TOGETHER.items()
                if group in groups
            )
            choice = int(np.argmin(table @ others))
            before, new[group] = new[group], table[choice]
            if (found := figure()) < best - 1e-12:
                best, improved, columns[group] = found, True, int(candidates[choice])
            else:
                new[group] = before
    return best, columns


def search_masks(random, points, seconds):
    """Finds by annealing, for each group, a word for each bit of a pixel's place in its block (x0 y0 x1 y1 x2 y2)."""
    points = {group: words[:256] for group, words in points.items()}
    masks = {group: [] for group in GROUPS}
    for bits in range(2, BLOCK_BITS + 1, 2):
        for group in GROUPS:
            masks[group] += [int(random.integers(1, 1 << MASK_DIGITS)) for _ in range(2)]
        anneal(random, points, masks, bits, seconds * 2 / BLOCK_BITS)
    return masks


def anneal(random, points, masks, bits, seconds):
    def table(group):
        span = np.zeros(1, dtype=np.uint64)
        for mask in masks[group]:
            span = np.concatenate([span, span ^ np.uint64(mask)])
        return kernel(group, (points[group][:, None] ^ span[None, :]).ravel()).reshape(256, -1)

    def figure(group):
        total = 0.0
        for groups, weight in NEIGHBOURS.items():
            if group in groups:
                sums = product(tables, groups).cumsum(0)
                for samples in range(9):
                    row = sums[(1 << samples) - 1].cumsum()
                    for pixels, share in ((bits - 1, 0.5), (bits, 1.0)):
                        count = 1 << (samples + pixels)
                        variance = row[(1 << pixels) - 1] / count - 1
                        total += weight * share * (1.5 if samples < 5 else 0.7) * np.log(variance + 1e-7 / count)
        return total

    tables = {group: table(group) for group in GROUPS}
    start = time.monotonic()
    while (passed := (time.monotonic() - start) / seconds) < 1:
        temperature = 1.5 * (1 - passed) ** 2 + 1e-9
        group, bit = GROUPS[random.integers(len(GROUPS))], bits - 1 - int(random.integers(2))
        before, old_mask, old_table = figure(group), masks[group][bit], tables[group]
        masks[group][bit] ^= mutation(random)
        tables[group] = table(group)
        worse = figure(group) - before
        if masks[group][bit] == 0 or (worse > 0 and random.random() >= np.exp(-worse / temperature)):
            masks[group][bit], tables[group] = old_mask, old_table
    print(f"{bits} bits: {sum(figure(group) for group in GROUPS):.1f}", file=sys.stderr)


def mutation(random):
    one = 1 << int(random.integers(MASK_DIGITS))
    kind = random.random()
    if kind < 0.6:
        return one
    if kind < 0.8:
        return one ^ (1 << int(random.integers(MASK_DIGITS)))
    return int(random.integers(1 << MASK_DIGITS)) & -one


def rust(name, about, rows):
    keyword = "static" if name == "MASKS" else "const"
    lines = [f"/// {about}", f"pub(super) {keyword} {name}: [[u32; {len(rows[GROUPS[0]])}]; {len(GROUPS)}] = ["]
    for group in GROUPS:
        words = ", ".join(f"{word:#x}" for word in rows[group])
        lines += [f"    // {group}", "    " + f"[{words}],"]
    return "\n".join([*lines, "];"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=600, help="time to search for the masks")
    options = parser.parse_args()
    random = np.random.default_rng(options.seed)
    matrices, points = search_matrices(random)
    masks = search_masks(random, points, options.seconds)
    print("//! Matrices of the sample points, found by `scripts/sample_matrices.py`. A word is a column of binary")
    print("//! digits, with the most significant digit in the lowest bit. A row is the first dimension of a group.\n")
    print(rust("MATRICES", "For each group, the digits that each bit of a point's number XORs.", matrices) + "\n")
    print(rust("MASKS", "For each group, the digits that each bit of a pixel's place in its block XORs.", masks))


if __name__ == "__main__":
    main()
