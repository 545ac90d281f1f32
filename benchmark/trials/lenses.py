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
