#!/usr/bin/python3
"""Draws what motions show of a calibration: drive_pictures.py PICTURE.svg TITLE=NAME ...

Each NAME stands for NAME.bag and the calibration of it in the folder NAME. A row for each: the path from above, the
angular rates about the IMU's axes, and the sigmas of the first LiDAR, of what the drive does not show in red. Prints the
rows of the table in docs/good_drive.md.
"""
import math
import pathlib
import sys

import rosbag
import yaml

AXES = ["x", "y", "z"]
COLOURS = ["#c0392b", "#1a7f37", "#1f5fbf"]
INK, FAINT, BAD = "#1f2430", "#8a93a3", "#c0392b"
ROW, WIDTH = 150, 860  # px
PATH, RATES, SIGMAS = (20, 150), (200, 400), (640, 210)  # left edge and width of a row's parts
MOST_RATE = 1.7  # rad/s, at the edge of the picture
BIN = 0.1  # s, over which rates are averaged


def rates_of(bag):
    """Seconds and mean angular rates (rad/s, IMU's axes) over bins."""
    sums = {}
    start = None
    for _, message, _ in rosbag.Bag(bag).read_messages(topics=["/imu/data"]):
        time = message.header.stamp.to_sec()
        start = time if start is None else start
        rate = message.angular_velocity
        entry = sums.setdefault(int((time - start) / BIN), [0, 0.0, 0.0, 0.0])
        for i, value in enumerate([1, rate.x, rate.y, rate.z]):
            entry[i] += value
    return [((b + 0.5) * BIN, [s / entry[0] for s in entry[1:]]) for b, entry in sorted(sums.items())
            for entry in [sums[b]]]


def path_of(folder):
    file = pathlib.Path(folder) / "trajectory.tum"
    if not file.exists():
        return []
    rows = [line.split() for line in file.read_text().splitlines() if line and line[0] != "#"]
    return [(float(row[1]), float(row[2])) for row in rows[::10]]


def text(x, y, words, size=11, colour=INK, weight="normal", anchor="start"):
    return (f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size}" fill="{colour}" font-weight="{weight}" '
            f'text-anchor="{anchor}">{words}</text>\n')


def line_through(points, colour, width=1.2):
    steps = " ".join(f"{'M' if i == 0 else 'L'}{x:.1f} {y:.1f}" for i, (x, y) in enumerate(points))
    return f'<path d="{steps}" fill="none" stroke="{colour}" stroke-width="{width}" stroke-linejoin="round"/>\n'


def draw_path(path, top):
    left, width = PATH
    height = ROW - 55
    if not path:
        return text(left + 45, top + 30 + height / 2, "no path: refused", 10, FAINT)
    low = [min(p[i] for p in path) for i in (0, 1)]
    extent = max(max(p[i] for p in path) - low[i] for i in (0, 1))
    if extent < 0.5:  # m, a rig that does not move
        x, y = left + width / 2, top + 30 + height / 2
        return f'<circle cx="{x}" cy="{y}" r="4" fill="{INK}"/>\n' + text(x + 10, y + 4, "stands", 10, FAINT)
    scale = min(width / max(1e-9, max(p[0] for p in path) - low[0]), height / max(1e-9, max(p[1] for p in path) - low[1]))
    points = [(left + scale * (x - low[0]), top + 30 + height - scale * (y - low[1])) for x, y in path]
    metres = 10 ** math.floor(math.log10(extent / 2))
    metres *= 5 if extent / metres > 10 else 2 if extent / metres > 4 else 1
    bar = top + ROW - 12
    return (line_through(points, INK, 1.6) + line_through([(left, bar), (left + scale * metres, bar)], FAINT, 2) +
            text(left + scale * metres + 5, bar + 4, f"{metres:g} m", 10, FAINT))


def draw_rates(rates, top):
    left, width = RATES
    middle, half = top + ROW / 2 + 8, ROW / 2 - 28
    length = rates[-1][0]
    drawing = line_through([(left, middle), (left + width, middle)], FAINT, 0.8)
    for sign in (1, -1):
        y = middle - sign * half * 1.0 / MOST_RATE
        drawing += line_through([(left, y), (left + width, y)], "#d8dce4", 0.8)
        drawing += text(left - 4, y + 4, f"{sign}", 9, FAINT, anchor="end")
    for axis, colour in enumerate(COLOURS):
        drawing += line_through([(left + width * t / length, middle - half * max(-1.0, min(1.0, r[axis] / MOST_RATE)))
                                 for t, r in rates], colour)
    return drawing + text(left + width, top + ROW - 6, f"{length:.0f} s", 9, FAINT, anchor="end")


def sigmas_of(folder):
    """Rows of (name, three texts, three flags: shown) of the first LiDAR, and the verdict."""
    calibration = yaml.safe_load((pathlib.Path(folder) / "calibration.yaml").read_text())
    verdict = calibration["verdict"]
    lidars = [s for s in (calibration.get("sensors") or {}).values() if s["type"] == "lidar" and "sigma" in s]
    if not lidars:
        return verdict, []
    sigma, hidden = lidars[0]["sigma"], lidars[0].get("unobservable", [])

    def shown(quantity):
        """Of each axis whether no direction that is not shown lies near it."""
        return [not any(d["quantity"] == quantity and abs(d["direction"][i]) > 0.3 for d in hidden) for i in range(3)]
    return verdict, [("rotation, deg", [f"{v:.3f}" for v in sigma["rotation_deg"]], shown("rotation")),
                     ("translation, mm", [f"{1e3 * v:.1f}" for v in sigma["translation"]], shown("translation")),
                     ("offset, ms", [f"{1e3 * sigma['time_offset']:.3f}"], [lidars[0]["observable"]["time_offset"]])]


def draw_sigmas(verdict, rows, top):
    left, width = SIGMAS
    drawing = text(left, top + 30, verdict, 12, {"trusted": "#1a7f37", "refused": BAD}.get(verdict, "#9a6700"), "bold")
    if not rows:
        return drawing + text(left, top + 52, "nothing is given", 11, BAD)
    for i, axis in enumerate(AXES):
        drawing += text(left + 110 + 45 * i, top + 50, axis, 10, COLOURS[i], "bold", "end")
    for k, (name, values, shown) in enumerate(rows):
        y = top + 70 + 18 * k
        drawing += text(left - 20, y, name, 10, FAINT)
        for i, (value, flag) in enumerate(zip(values, shown)):
            drawing += text(left + 110 + 45 * i, y, value, 10.5, INK if flag else BAD, "normal" if flag else "bold", "end")
    return drawing


def main():
    picture, *motions = sys.argv[1:]
    body = ""
    for k, motion in enumerate(motions):
        title, _, name = motion.partition("=")
        top = k * ROW + 20
        verdict, sigmas = sigmas_of(name)
        rates = rates_of(name + ".bag")
        body += text(PATH[0], top + 14, title, 12, INK, "bold")
        body += draw_path(path_of(name), top) + draw_rates(rates, top) + draw_sigmas(verdict, sigmas, top)
        if k:
            body += line_through([(10, top), (WIDTH - 10, top)], "#e3e6ec", 1)
        rms = [math.sqrt(sum(r[i] ** 2 for _, r in rates) / len(rates)) for i in range(3)]
        cells = [" ".join(v if f else f"**{v}**" for v, f in zip(values, shown)) for _, values, shown in sigmas]
        print(f"| {title} | {verdict} | {' '.join(f'{r:.2f}' for r in rms)} | {' | '.join(cells or ['', '', ''])} |")
    height = len(motions) * ROW + 30
    head = text(RATES[0], 14, "angular rates about the IMU's x, y, z, rad/s", 10, FAINT) + text(
        SIGMAS[0] - 20, 14, "sigmas of the LiDAR; red: not shown", 10, FAINT)
    pathlib.Path(picture).write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" '
        f'font-family="DejaVu Sans, Helvetica, sans-serif">\n<rect width="{WIDTH}" height="{height}" fill="#ffffff"/>\n'
        f'{head}{body}</svg>\n')


if __name__ == "__main__":
    main()
