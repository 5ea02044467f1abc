#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["matplotlib>=3.6"]
# ///
"""Draws the measurements of convergence.py: one panel for each effect, one line for each generator.

    uv run scripts/convergence_plot.py docs/pictures/convergence.csv docs/pictures/convergence.svg

The first file comes from `convergence.py --data`. The ending of the second file selects the format: .svg, .png or
.pdf. Needs Python 3.10 and matplotlib. `uv run` and `pipx run` fetch matplotlib by themselves; for plain `python3`
install it first.

Both axes are logarithmic, and a factor of two has the same length on both axes of all panels, so the slope of a line
is the exponent of the error in the number of samples.
"""

import argparse
import csv
import math
import statistics
import sys

try:
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.ticker import LogLocator, NullLocator, StrMethodFormatter
except ModuleNotFoundError as error:
    sys.exit(
        f"convergence_plot.py needs matplotlib ({error}). Any of these helps:\n"
        "    uv run scripts/convergence_plot.py ...      or pipx run; fetches it for this run\n"
        "    python3 -m pip install matplotlib           in a virtual environment\n"
        "    apt-get install python3-matplotlib          on Debian and Ubuntu"
    )

COLUMNS = 3
PANEL = 3.0, 3.05  # inches, with titles and numbers
# Vermilion, near black and blue stay apart in all kinds of colour blindness; the markers differ as well.
STYLES = {
    "PSEUDO": {"color": "#d55e00", "marker": "s"},
    "ZERO_TWO": {"color": "#333333", "marker": "^"},
    "QUASI": {"color": "#0072b2", "marker": "o"},
}
GUIDE = {"color": "#8a8a8a", "linestyle": (0, (5, 4)), "linewidth": 1}
LOOK = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that the same data gives the same file
    "font.size": 9,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": "#bbbbbb",
    "axes.grid": True,
    "grid.color": "#e3e3e3",
    "lines.linewidth": 1.8,
    "lines.markersize": 5,
    "xtick.color": "#bbbbbb",
    "xtick.labelcolor": "#333333",
    "ytick.color": "#bbbbbb",
    "ytick.labelcolor": "#333333",
    "legend.frameon": False,
    "svg.hashsalt": "convergence",
}


def read(path):
    """Returns the numbers of samples and the relative errors (root mean square, percent) by effect and generator."""
    panels = {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            counts, errors = panels.setdefault(row["effect"], {}).setdefault(row["generator"], ([], []))
            counts.append(int(row["samples"]))
            errors.append(100 * math.sqrt(float(row["relative-mse"])))
    return panels


def slope(counts, errors):
    """Returns the exponent of the error in the number of samples, by least squares."""
    return statistics.linear_regression(list(map(math.log, counts)), list(map(math.log, errors))).slope


def draw_panel(axes, effect, lines):
    axes.set_title(effect)
    for generator, (counts, errors) in lines.items():
        label = f"{slope(counts, errors):.2f}".replace("-", "\N{MINUS SIGN}")
        axes.plot(counts, errors, label=label, zorder=3, **STYLES[generator])
    counts, errors = next(iter(lines.values()))
    axes.plot(counts, [errors[0] * (n / counts[0]) ** -0.5 for n in counts], zorder=2, **GUIDE)
    axes.set(xscale="log", yscale="log", aspect="equal", xticks=counts, xlabel="samples per pixel")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:.0f}"))
    axes.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.legend(title="slope", loc="lower left", handlelength=1.4, labelcolor="linecolor", alignment="left")


def limit(panels, axes_of):
    """Gives the vertical axes of all panels the same length, with the lines of each panel in the middle."""
    ranges = {}
    for effect, lines in panels.items():
        errors = [error for _, errors in lines.values() for error in errors]
        ranges[effect] = min(errors), max(errors)
    half = 1.3 * math.sqrt(max(high / low for low, high in ranges.values()))
    for effect, (low, high) in ranges.items():
        middle = math.sqrt(low * high)
        axes_of[effect].set_ylim(middle / half, middle * half)


def draw_legend(axes):
    axes.set_axis_off()
    handles = [Line2D([], [], label=generator, **style) for generator, style in STYLES.items()]
    handles.append(Line2D([], [], label="slope \N{MINUS SIGN}0.5:\nindependent samples", **GUIDE))
    note = "A slope is the exponent of the\nerror in the number of samples,\nfitted by least squares."
    legend = axes.legend(handles=handles, loc="upper left", labelspacing=0.8, handlelength=3, fontsize=10)
    axes.annotate(note, (0.04, -0.1), xycoords=legend, verticalalignment="top", color="#333333")


def draw(panels):
    rows = math.ceil((len(panels) + 1) / COLUMNS)
    figure = Figure(figsize=(COLUMNS * PANEL[0], rows * PANEL[1]), layout="compressed")
    places = list(figure.subplots(rows, COLUMNS).flat)
    axes_of = dict(zip(panels, places))
    for effect, lines in panels.items():
        draw_panel(axes_of[effect], effect, lines)
    limit(panels, axes_of)
    draw_legend(places[len(panels)])
    for axes in places[len(panels) + 1:]:
        axes.set_axis_off()
    figure.supylabel("relative error, root mean square (%)", fontsize=10)
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", metavar="DATA.csv", help="the file written by `convergence.py --data`")
    parser.add_argument("picture", metavar="PICTURE.svg", help=".svg, .png or .pdf")
    options = parser.parse_args()
    panels = read(options.data)
    with matplotlib.rc_context(LOOK):
        # Without the date the same data gives the same file.
        metadata = {"Date": None} if options.picture.endswith(".svg") else None
        draw(panels).savefig(options.picture, dpi=150, bbox_inches="tight", metadata=metadata)


if __name__ == "__main__":
    main()
