#!/usr/bin/env python3
"""Paints the textures of the scenes `chess` and `room`, and models sofa, cushion and floor of `room`.

Needs nothing but Python. What it writes is ours and free for any use (CC0)."""

import math
import struct
import sys
import zlib
from pathlib import Path

HERE = Path(__file__).parent


def write_png(name, size, colour):
    """A picture with a palette; `colour` gives sRGB of 0..255 at (u, v), 0..1 from the upper left."""
    width, height = size
    pixels = [[tuple(round(c) for c in colour((x + 0.5) / width, (y + 0.5) / height)) for x in range(width)]
              for y in range(height)]
    palette = sorted({pixel for row in pixels for pixel in row})
    assert len(palette) <= 256, f"{name}: {len(palette)} colours"
    number = {pixel: index for index, pixel in enumerate(palette)}
    rows = b"".join(b"\0" + bytes(number[pixel] for pixel in row) for row in pixels)

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 3, 0, 0, 0)
    data = zlib.compress(rows, 9)
    chunks = [(b"IHDR", header), (b"PLTE", bytes(sum(palette, ()))), (b"IDAT", data), (b"IEND", b"")]
    (HERE / name).write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*c) for c in chunks))


def hashed(*numbers):
    """A number of 0..1 that looks random."""
    return zlib.crc32(struct.pack(f"{len(numbers)}i", *numbers)) / 2**32


def noise(u, v, seed=0):
    """Smooth noise of 0..1 with a grid of 1."""
    x, y = math.floor(u), math.floor(v)
    s, t = ((a - b) ** 2 * (3 - 2 * (a - b)) for a, b in ((u, x), (v, y)))
    corner = [[hashed(seed, x + i, y + j) for i in (0, 1)] for j in (0, 1)]
    below, above = ((1 - s) * row[0] + s * row[1] for row in corner)
    return (1 - t) * below + t * above


def toned(colour, amount, levels=12):
    """`colour` darker or brighter by a share of −1..1, in steps that keep palettes small."""
    amount = round(amount * levels) / levels
    return [min(255, c * (1 + amount)) for c in colour]


def grain(u, v, seed):
    """Fibres along v, −1..1."""
    return 2 * noise(60 * u + 3 * noise(3 * u, 2 * v, seed), 3 * v, seed) - 1


def board(u, v):
    """64 squares of maple and walnut with a border, each with its own grain."""
    x, y = (u * 0.5 - 0.03) / 0.055, (v * 0.5 - 0.03) / 0.055
    if not (0 <= x < 8 and 0 <= y < 8):
        inner = -0.08 < x < 8.08 and -0.08 < y < 8.08
        return toned((206, 176, 128) if inner else (92, 52, 34), 0.10 * grain(u, v, 9))
    i, j = int(x), int(y)
    colour = (222, 188, 138) if (i + j) % 2 == 0 else (112, 66, 40)
    shade = 0.12 * (hashed(i, j, 5) - 0.5)
    return toned(colour, shade + 0.10 * grain(u, v + 3 * hashed(i, j), 8 * i + j), 24)


def planks(u, v):
    """Oak boards along u, four deep and staggered; repeats."""
    row = int(4 * v)
    x = u + 0.5 * (row % 2) + 0.17 * (row // 2)
    across, along = 4 * v - row, x % 1
    if across < 0.02 or along < 0.005:
        return 66, 42, 26
    shade = 0.22 * (hashed(row, int(x % 2)) - 0.5)
    return toned((178, 126, 80), shade + 0.12 * grain(across / 4, 2 * along, row), 16)


def rug(u, v):
    """A woven rug: a border, and lozenges."""
    edge = min(u, 1 - u, 1.4 * v, 1.4 * (1 - v))
    if edge < 0.05:
        return (196, 178, 146)
    if edge < 0.09:
        return (134, 32, 34)
    lozenge = abs((8 * u) % 1 - 0.5) + abs((6 * v) % 1 - 0.5)
    return (196, 152, 84) if lozenge < 0.16 else (52, 66, 104) if lozenge < 0.34 else (134, 32, 34)


def wallpaper(u, v):
    """Stripes with sprigs, once over a whole wall."""
    x, y = (9 * u) % 1, (7 * v + 0.5 * (int(9 * u) % 2)) % 1
    leaf = math.hypot((x - 0.5) / 0.7, y - 0.5 + 0.8 * abs(x - 0.5)) < 0.15
    stem = abs(x - 0.5) < 0.02 and 0.45 < y < 0.75
    if leaf or stem:
        return 96, 128, 98
    return (224, 216, 192) if 0.08 < x < 0.92 else (206, 196, 166)


def picture(u, v):
    """A landscape: sun, three ranges of hills and a lake."""
    if math.hypot(1.3 * (u - 0.7), v - 0.27) < 0.1:
        return 244, 208, 112
    for number, colour in enumerate(((126, 150, 176), (82, 116, 112), (44, 82, 60))):
        ridge = 0.45 + 0.13 * number - 0.13 * noise(4 * u + number, number, 7)
        if ridge < v < ridge + 0.14:
            return colour
    if v > 0.6:
        return toned((70, 112, 150), 0.3 * noise(5 * u, 40 * v, 3))
    return toned((222, 172, 128), 0.25 * (v - 0.3), 24)


class Model:
    """Positions, texture coordinates and normals, each once, and faces of an OBJ file."""

    def __init__(self):
        self.tables, self.faces = {"v": {}, "vt": {}, "vn": {}}, []

    def add(self, corners):
        """A face of {"v": position, "vt": …, "vn": normal}, counter-clockwise from outside."""
        numbers = ("/".join(self.number(corner, tag) for tag in self.tables) for corner in corners)
        self.faces.append("f " + " ".join(numbers))

    def number(self, corner, tag):
        if tag not in corner:
            return ""
        table, value = self.tables[tag], tuple(round(x, 4) + 0.0 for x in corner[tag])
        return str(table.setdefault(value, len(table) + 1))

    def write(self, name):
        lines = [f"# made by {Path(sys.argv[0]).name}, CC0"]
        for tag, table in self.tables.items():
            lines += [" ".join([tag] + [f"{x:g}" for x in value]) for value in table]
        (HERE / name).write_text("\n".join(lines + self.faces) + "\n")


def add_rounded_box(model, centre, size, radius, parts=3):
    """A box with rounded edges; its flat parts have so many squares a side."""
    half = [x / 2 for x in size]

    def steps(axis):
        inner = half[axis] - radius
        corner = [inner + radius * share for share in (math.tan(math.pi / 8), 1)]
        flat = [inner * (2 * i / parts - 1) for i in range(parts + 1)]
        return [-x for x in reversed(corner)] + flat + corner

    def corner(point):
        core = [max(-(h - radius), min(h - radius, x)) for x, h in zip(point, half)]
        outward = [x - c for x, c in zip(point, core)]
        length = math.hypot(*outward)
        normal = [x / length for x in outward]
        return {"v": [o + c + radius * n for o, c, n in zip(centre, core, normal)], "vn": normal}

    for axis in range(3):
        for side in (-1, 1):
            i, j = ((axis + 1) % 3, (axis + 2) % 3)[::side]
            a, b = steps(i), steps(j)

            def at(s, t):
                point = [0, 0, 0]
                point[axis], point[i], point[j] = side * half[axis], s, t
                return corner(point)

            for s0, s1 in zip(a, a[1:]):
                for t0, t1 in zip(b, b[1:]):
                    model.add([at(s0, t0), at(s1, t0), at(s1, t1), at(s0, t1)])


def sofa():
    """1.7 m wide, with its back to −Z."""
    model = Model()
    for centre, size, radius in (
        ((0, 0.22, 0), (1.64, 0.20, 0.74), 0.04),
        ((0, 0.52, -0.33), (1.64, 0.56, 0.18), 0.07),
        ((-0.80, 0.37, 0), (0.18, 0.50, 0.80), 0.07),
        ((0.80, 0.37, 0), (0.18, 0.50, 0.80), 0.07),
        ((-0.355, 0.40, 0.06), (0.70, 0.15, 0.64), 0.06),
        ((0.355, 0.40, 0.06), (0.70, 0.15, 0.64), 0.06),
        ((-0.355, 0.64, -0.18), (0.68, 0.40, 0.16), 0.07),
        ((0.355, 0.64, -0.18), (0.68, 0.40, 0.16), 0.07),
    ):
        add_rounded_box(model, centre, size, radius)
    model.write("room/sofa.obj")


def cushion():
    model = Model()
    add_rounded_box(model, (0, 0, 0), (0.40, 0.40, 0.13), 0.064)
    model.write("room/cushion.obj")


def floor():
    """3 m × 2.4 m in squares of 6 cm, but for the place of the rug, under which no light would come."""
    model, step = Model(), 0.06
    for i in range(50):
        for j in range(40):
            x, z = -1.5 + step * i, -1.2 + step * j
            if not (RUG[0] < x + step / 2 < RUG[1] and RUG[2] < z + step / 2 < RUG[3]):
                corners = ((x, z), (x, z + step), (x + step, z + step), (x + step, z))
                model.add([{"v": (s, 0, t), "vt": (s / 1.2, -t / 0.6), "vn": (0, 1, 0)} for s, t in corners])
    model.write("room/floor.obj")


# Least and largest x and z of the rug.
RUG = (-0.84, 0.84, -0.18, 0.96)


def main():
    write_png("chess/board.png", (512, 512), board)
    write_png("room/planks.png", (256, 256), planks)
    write_png("room/rug.png", (256, 192), rug)
    write_png("room/wallpaper.png", (768, 512), wallpaper)
    write_png("room/picture.png", (192, 128), picture)
    sofa()
    cushion()
    floor()


if __name__ == "__main__":
    main()
