"""Draws what convergence.py measured as one SVG picture: a panel for each effect, a line for each generator.

Both axes are logarithmic, and a factor of two is as long on one as on the other, in every panel, so that a slope is
the exponent. Panels differ in where their errors begin.
"""

import math

WIDTH, COLUMNS = 860, 3
# The name of the vertical axis is left of the first panel of a row.
MARGIN = 18
# Of a panel: its size in pixels, and what is left free around its axes for titles, numbers and exponents.
PANEL, HEIGHT = (WIDTH - MARGIN) / COLUMNS, 262
LEFT, RIGHT, TOP, BOTTOM = 34, 54, 32, 44
# Vermilion, near black and blue stay far apart as protan, deutan and tritan eyes see them.
STYLES = {"PSEUDO": ("#d55e00", "square"), "ZERO_TWO": ("#333333", "triangle"), "QUASI": ("#0072b2", "circle")}
STYLE = """
text { font: 12px system-ui, -apple-system, "Segoe UI", "DejaVu Sans", Arial, sans-serif; fill: #333 }
.title { font-size: 14px; font-weight: 600; fill: #111 }
.number { font-size: 11px }
.exponent { font-weight: 600 }
.frame { fill: none; stroke: #bbb }
.grid { stroke: #e3e3e3 }
.guide { stroke: #8a8a8a; stroke-dasharray: 5 4 }
.line { fill: none; stroke-width: 2; stroke-linejoin: round }
"""


def text(x, y, content, kind="note", anchor="start", **more):
    attributes = "".join(f' {name}="{value}"' for name, value in more.items())
    return f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{attributes}>{content}</text>'


def segment(kind, x0, y0, x1, y1):
    return f'<line class="{kind}" x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"/>'


def marker(generator, x, y):
    colour, shape = STYLES[generator]
    if shape == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.4" fill="{colour}"/>'
    if shape == "square":
        return f'<rect x="{x - 3:.1f}" y="{y - 3:.1f}" width="6" height="6" fill="{colour}"/>'
    return f'<path d="M{x:.1f} {y - 4.2:.1f}l4 7h-8z" fill="{colour}"/>'


def ticks(low, high):
    """1, 2 and 5 times powers of ten from low to high."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    return [m * 10.0**d for d in decades for m in (1, 2, 5) if low <= m * 10.0**d <= high]


def spread(places, distance):
    """The places, moved apart until none is nearer to another than the distance; their mean stays."""
    order = sorted(range(len(places)), key=places.__getitem__)
    moved = [places[i] for i in order]
    for _ in range(100):
        for i in range(len(moved) - 1):
            short = distance - (moved[i + 1] - moved[i])
            if short > 0:
                moved[i] -= short / 2
                moved[i + 1] += short / 2
    return [moved[order.index(i)] for i in range(len(places))]


class Axes:
    """Where the numbers of a panel lie."""

    def __init__(self, left, top, counts, errors, scale):
        self.left, self.right = left + LEFT, left + PANEL - RIGHT
        self.top, self.bottom = top + TOP, top + HEIGHT - BOTTOM
        self.scale = scale
        self.first = math.log(counts[0])
        middle = 0.5 * (math.log(min(errors)) + math.log(max(errors)))
        half = 0.5 * (self.bottom - self.top) / scale
        self.low, self.high = middle - half, middle + half

    def x(self, count):
        return self.left + (math.log(count) - self.first) * self.scale

    def y(self, error):
        return self.bottom - (math.log(error) - self.low) * self.scale


def grid(axes, counts):
    free = -math.inf
    for count in counts:
        x = axes.x(count)
        yield segment("grid", x, axes.top, x, axes.bottom)
        if x >= free:
            yield text(x, axes.bottom + 15, count, "number", "middle")
            free = x + 24
    for error in ticks(math.exp(axes.low), math.exp(axes.high)):
        yield segment("grid", axes.left, axes.y(error), axes.right, axes.y(error))
        yield text(axes.left - 5, axes.y(error) + 4, f"{100 * error:g}", "number", "end")
    width, height = axes.right - axes.left, axes.bottom - axes.top
    yield f'<rect class="frame" x="{axes.left:.1f}" y="{axes.top:.1f}" width="{width:.1f}" height="{height:.1f}"/>'


def curves(axes, counts, lines):
    """The lines of the generators, the guide under them, their exponents beside them."""
    start = lines["PSEUDO"][0][0]
    end = start * (counts[-1] / counts[0]) ** -0.5
    yield segment("guide", axes.x(counts[0]), axes.y(start), axes.x(counts[-1]), axes.y(end))
    labels = spread([axes.y(errors[-1]) for errors, _ in lines.values()], 14)
    for (generator, (errors, exponent)), label in zip(lines.items(), labels):
        points = [(axes.x(n), axes.y(error)) for n, error in zip(counts, errors)]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        colour = STYLES[generator][0]
        yield f'<polyline class="line" points="{path}" stroke="{colour}"/>'
        yield from (marker(generator, x, y) for x, y in points)
        number = f"{exponent:.2f}".replace("-", "\u2212")
        yield text(axes.right + 6, label + 4, number, "exponent", style=f"fill: {colour}")


def panel(left, top, effect, counts, lines, scale):
    axes = Axes(left, top, counts, [error for errors, _ in lines.values() for error in errors], scale)
    yield text(axes.left, top + 21, effect, "title")
    yield from grid(axes, counts)
    yield from curves(axes, counts, lines)
    yield text(0.5 * (axes.left + axes.right), axes.bottom + 33, "samples per pixel", anchor="middle")


def legend(left, top):
    x, y = left + LEFT, top + TOP + 12
    for generator, (colour, _) in STYLES.items():
        yield f'<line class="line" x1="{x}" y1="{y}" x2="{x + 32}" y2="{y}" stroke="{colour}"/>'
        yield marker(generator, x + 16, y)
        yield text(x + 42, y + 4, generator, "exponent", style=f"fill: {colour}")
        y += 22
    yield segment("guide", x, y, x + 32, y)
    yield text(x + 42, y + 4, "\u22120.5, independent samples")
    for line in ["Numbers: slopes of the lines,", "exponents of the error in the", "number of samples (least squares)"]:
        yield text(x, y + 36, line)
        y += 17


def log_range(values):
    return math.log(max(values) / min(values))


def common_scale(counts, panels):
    """Pixels for a factor of e, so that all counts fit the width, and the errors of each effect the height."""
    ranges = [log_range([error for errors, _ in lines.values() for error in errors]) for lines in panels.values()]
    width, height = PANEL - LEFT - RIGHT, HEIGHT - TOP - BOTTOM - 16
    return min(width / log_range(counts), height / max(ranges))


def picture(counts, panels):
    """SVG, in lines. Panels: by effect and generator, relative errors (root mean square) at counts, and the exponent."""
    rows = math.ceil((len(panels) + 1) / COLUMNS)
    height = rows * HEIGHT + 8
    scale = common_scale(counts, panels)
    places = [(MARGIN + (i % COLUMNS) * PANEL, 4 + (i // COLUMNS) * HEIGHT) for i in range(len(panels) + 1)]
    size = f'viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}"'
    yield f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">'
    yield f"<title>Relative error by samples per pixel: {', '.join(panels)}</title>"
    yield f"<style>{STYLE}</style>"
    yield f'<rect width="{WIDTH}" height="{height}" rx="6" fill="#fff"/>'
    for (left, top), (effect, lines) in zip(places, panels.items()):
        yield from panel(left, top, effect, counts, lines, scale)
        if left == MARGIN:
            turned = f"translate(17 {top + 0.5 * (TOP + HEIGHT - BOTTOM):.1f}) rotate(-90)"
            yield text(0, 0, "relative error, root mean square (%)", anchor="middle", transform=turned)
    yield from legend(*places[-1])
    yield "</svg>"


def write(path, counts, panels):
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(picture(counts, panels)) + "\n")
