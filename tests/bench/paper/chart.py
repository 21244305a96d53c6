"""Charts as SVG files: lines over a few places, and bars on a scale of powers of ten.

Needs the standard library of Python alone.
"""

import math
from xml.sax.saxutils import escape

# Distinguishable with any colour vision. Ref: Okabe & Ito, "Color Universal Design", 2008.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
FONT = 'font-family="DejaVu Sans, Verdana, sans-serif"'
GRID = "#dddddd"
INK = "#222222"


def round_step(largest, most_steps=6):
    """@return the smallest of 1, 2, 5 times a power of ten that reaches `largest` in so many steps

    @param largest above 0
    """
    power = 10.0 ** math.floor(math.log10(largest / most_steps))
    return next(
        factor * power
        for factor in (1, 2, 5, 10)
        if factor * power * most_steps >= largest * (1 - 1e-9)
    )


def number(value):
    return f"{value:.3g}" if value < 1000 else f"{value:.0f}"


def text(x, y, words, anchor="start", size=12, turned=False):
    turn = f' transform="rotate(-90 {x:.1f} {y:.1f})"' if turned else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" {FONT} font-size="{size}" '
        f'fill="{INK}" text-anchor="{anchor}"{turn}>{escape(str(words))}</text>'
    )


def line(x0, y0, x1, y1, colour=INK, width=1.0):
    return (
        f'<line x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}" '
        f'stroke="{colour}" stroke-width="{width}"/>'
    )


def document(width, height, title, caption, parts):
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">'
    )
    frame = [
        f'<rect width="{width}" height="{height}" fill="white"/>',
        text(16, 26, title, size=16),
        text(16, height - 12, caption, size=10),
    ]
    return "\n".join([head, f"<title>{escape(title)}</title>", *frame, *parts, "</svg>"]) + "\n"


def legend(names, x, y):
    parts = []
    for index, name in enumerate(names):
        parts += [
            f'<circle cx="{x:.1f}" cy="{y - 4:.1f}" r="5" fill="{COLOURS[index % len(COLOURS)]}"/>',
            text(x + 10, y, name),
        ]
        x += 34 + 7 * len(name)
    return parts


def line_chart(title, caption, x_name, y_name, places, series):
    """Lines over evenly spaced places; y begins at 0.

    The mark of a place is the median of its values; its whisker goes from the minimum to the
    maximum.

    @param places labels of x, from the left
    @param series {name: [values at each place]}; every place has a value
    """
    width = 720
    height = 440
    left = 70
    right = 24
    top = 74
    bottom = 74
    largest = max(
        value for places_of in series.values() for values in places_of for value in values
    )
    step = round_step(largest)
    end = step * math.ceil(largest / step - 1e-9)

    def x_of(index):
        return left + (index + 0.5) * (width - left - right) / len(places)

    def y_of(value):
        return height - bottom - value / end * (height - top - bottom)

    parts = legend(series, left, 52)
    for tick in range(round(end / step) + 1):
        parts += [
            line(left, y_of(tick * step), width - right, y_of(tick * step), GRID),
            text(left - 8, y_of(tick * step) + 4, number(tick * step), "end"),
        ]
    parts += [
        text(x_of(index), height - bottom + 18, label, "middle")
        for index, label in enumerate(places)
    ]
    parts += [
        text((left + width - right) / 2, height - bottom + 40, x_name, "middle"),
        text(22, (top + height - bottom) / 2, y_name, "middle", turned=True),
    ]
    for order, values_at in enumerate(series.values()):
        colour = COLOURS[order % len(COLOURS)]
        marks = [(x_of(index), y_of(median(values))) for index, values in enumerate(values_at)]
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in marks)
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>'
        )
        for (x, y), values in zip(marks, values_at):
            parts += [
                line(x, y_of(min(values)), x, y_of(max(values)), colour, 1.5),
                f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{colour}"/>',
            ]
    return document(width, height, title, caption, parts)


def bar_chart(title, caption, x_name, bars, marks, mark_name):
    """Bars on a scale of powers of ten, in the order given, with a mark next to some.

    @param bars  {name: value above 0}
    @param marks {name: value above 0} for some of the names; `mark_name` describes them
    """
    width = 720
    left = 170
    right = 70
    top = 74
    row = 24
    height = top + row * len(bars) + 84
    values = list(bars.values()) + [marks[name] for name in bars if name in marks]
    low = math.floor(math.log10(min(values)))
    high = max(low + 1, math.ceil(math.log10(max(values))))

    def x_of(value):
        return left + (math.log10(value) - low) / (high - low) * (width - left - right)

    bottom = top + row * len(bars)
    parts = legend(["here", mark_name], left, 52)
    for power in range(low, high + 1):
        parts += [
            line(x_of(10.0**power), top, x_of(10.0**power), bottom, GRID),
            text(x_of(10.0**power), bottom + 18, number(10.0**power), "middle"),
        ]
    parts.append(text((left + width - right) / 2, bottom + 40, x_name, "middle"))
    for order, (name, value) in enumerate(bars.items()):
        y = top + row * order
        parts += [
            text(left - 8, y + 16, name, "end"),
            text(width - right + 8, y + 16, number(value)),
        ]
        parts.append(
            f'<rect x="{left}" y="{y + 5}" width="{max(1.0, x_of(value) - left):.1f}" '
            f'height="{row - 10}" fill="{COLOURS[0]}"/>'
        )
        if name in marks:
            parts.append(
                f'<circle cx="{x_of(marks[name]):.1f}" cy="{y + row / 2:.1f}" '
                f'r="5" fill="{COLOURS[1]}" stroke="white"/>'
            )
    return document(width, height, title, caption, parts)


def median(values):
    ordered = sorted(values)
    half = len(ordered) // 2
    return ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2
