"""Lenses as they are sold, from which the trials draw: model, image size and parameters."""

import math

# Of lenses as they are sold: model, image size, parameters. The last numbers of each make its distortion monotonic over the image.
LENSES = {
    "k-0.28": ("plumb_bob", (752, 480), [458.6, 457.3, 367.2, 248.4, -0.2834, 0.0740, 0.0002, 0.00002, 0.0]),
    "k-0.28-right": ("plumb_bob", (752, 480), [457.6, 456.1, 379.9, 255.2, -0.2837, 0.0745, -0.0001, -0.00003, 0.0]),
    "k-0.45": ("plumb_bob", (752, 480), [618.3, 617.1, 371.4, 233.9, -0.4513, 0.2712, 0.0003, -0.0004, -0.0811]),
    "k-0.15": ("plumb_bob", (752, 480), [421.5, 422.3, 379.7, 245.2, -0.1507, 0.0314, -0.0002, 0.0003, -0.0019]),
    "k+0.05": ("plumb_bob", (752, 480), [501.7, 500.9, 369.6, 242.8, 0.0508, -0.0213, 0.0002, -0.0003, 0.0011]),
    "wide-130": ("rational_polynomial", (800, 600),
                 [360.4, 360.9, 404.2, 294.3, 0.8127, 0.0918, 0.0001, -0.0002, 0.0021, 1.0871, 0.3127, 0.0068]),
    "fisheye-200": ("equidistant", (720, 720), [206.0, 206.4, 363.7, 355.4, 0.0132, -0.0051, 0.0021, -0.0006]),
    "sphere-180": ("double_sphere", (720, 720), [194.5, 194.1, 356.8, 362.6, -0.1812, 0.5921]),
}


def radius(model, p, angle):
    """Of a ray at this angle from the axis, in focal lengths."""
    if model == "equidistant":
        return angle * (1 + sum(k * angle ** (2 * i + 2) for i, k in enumerate(p[4:8])))
    if model == "double_sphere":
        xi, alpha = p[4:]
        x, z = math.sin(angle), math.cos(angle)
        shifted = xi + z
        return x / (alpha * math.hypot(x, shifted) + (1 - alpha) * shifted)
    r = math.tan(angle)
    s = r * r
    below = 1 + s * (p[9] + s * (p[10] + s * p[11])) if model == "rational_polynomial" else 1
    return r * (1 + s * (p[4] + s * (p[5] + s * p[8]))) / below


def reaches_corners(lens):
    """Whether the radius grows with the angle up to the corners of the image, with a tenth to spare."""
    model, (width, height), p = lens
    need = 1.1 * max(math.hypot(u - p[2], v - p[3]) for u in (0, width) for v in (0, height)) / p[0]
    before = 0.0
    for step in range(1, 700):
        now = radius(model, p, math.radians(0.125 * step))
        if now <= before or not math.isfinite(now):
            return False
        if now > need:
            return True
        before = now
    return False


def draw_lens(draw):
    """One that nobody sells: of any of the models, with distortion and focal length from the random generator `draw`."""
    while True:
        model = draw.choice(['plumb_bob', 'plumb_bob', 'rational_polynomial', 'equidistant', 'double_sphere'])
        width, height = draw.choice([(640, 480), (752, 480), (800, 500)] if model in ('plumb_bob', 'rational_polynomial')
                                    else [(640, 480), (720, 720)])
        center = [width / 2 + draw.gauss(0, 8), height / 2 + draw.gauss(0, 8)]
        decentring = [draw.gauss(0, 3e-4), draw.gauss(0, 3e-4)]
        if model == 'plumb_bob':
            k1 = draw.uniform(-0.45, 0.05)
            focal = width * draw.uniform(0.55, 0.95)
            rest = [k1, draw.uniform(0.8, 1.4) * k1 * k1] + decentring + [draw.uniform(-0.9, 0.0) * abs(k1) ** 3]
        elif model == 'rational_polynomial':
            sold = LENSES['wide-130'][2]
            focal = width * draw.uniform(0.4, 0.6)
            rest = [draw.uniform(0.9, 1.1) * sold[4], sold[5]] + decentring + sold[8:]
        elif model == 'equidistant':
            focal = width / math.radians(draw.uniform(150, 220))
            rest = [draw.gauss(0, s) for s in (0.02, 0.008, 0.003, 0.0008)]
        else:
            focal = width * draw.uniform(0.26, 0.34)
            rest = [draw.uniform(-0.25, 0.0), draw.uniform(0.52, 0.64)]
        lens = model, (width, height), [focal, focal * draw.uniform(0.996, 1.004)] + center + rest
        if model in ('equidistant', 'double_sphere'):
            angles = [radius(model, lens[2], math.radians(a)) for a in range(0, 116)]
            if all(a < b for a, b in zip(angles, angles[1:])):
                return lens
        elif reaches_corners(lens):
            return lens


def field_of_view_deg(lens):
    """Horizontal, between the middles of the left and right edge."""
    model, (width, _), p = lens
    half_angles = []
    for edge in (p[2] + 0.5, width - 0.5 - p[2]):
        low, high = 0.0, math.radians(85.0 if model in ("plumb_bob", "rational_polynomial") else 130.0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if radius(model, p, middle) * p[0] < edge else (low, middle)
        half_angles.append(low)
    return math.degrees(sum(half_angles))
