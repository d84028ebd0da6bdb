#!/usr/bin/env python3
"""Paints the textures of the scenes `cubes`, `bunny-painted` and `tube`, and models walls and tube.

Needs nothing but Python, and for the bunny `make assets`. What it writes is ours and free for any use (CC0)."""

import itertools
import math
import struct
import sys
import zlib

sys.dont_write_bytecode = True  # what is installed is the folder as it is
from paint import HERE, Model, noise

# What is painted is (kd, ks, s): two linear colours, of which the sum is at most 1, and an exponent of 1 to 200.
SHARPEST = 200
MOST = 0.95


# Textures


def write_textures(scene, name, size, material):
    """`material` gives what is painted at texel (x, y), in parts of `size`; four samples a texel are averaged."""
    layers = [[], [], []]
    for y in range(size):
        rows = [[], [], []]
        for x in range(size):
            samples = [material((x + i) / size, (y + j) / size) for j in (0.25, 0.75) for i in (0.25, 0.75)]
            kd, ks = ([sum(s[layer][k] for s in samples) / 4 for k in range(3)] for layer in (0, 1))
            kd = [min(d, MOST - s) for d, s in zip(kd, ks)]
            log = sum(math.log(s[2], SHARPEST) for s in samples) / 4
            texels = [encoded(c) for c in kd], [encoded(c) for c in ks], [round(255 * log)] * 3
            for row, texel in zip(rows, texels):
                row.append(tuple(texel))
        for layer, row in zip(layers, rows):
            layer.append(row)
    for layer, key in zip(layers, ("kd", "ks", "s")):
        write_png(f"{scene}/textures/{name}_{key}.png", layer)


def encoded(linear):
    """sRGB, 0..255. Rounded down, so that sums do not grow."""
    return int(255 * (12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055) + 0.01)


def linear(red, green, blue):
    """What an sRGB colour of 0..255 is."""
    shares = (c / 255 for c in (red, green, blue))
    return tuple(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shares)


def write_png(name, pixels):
    """With a palette if there are few colours."""
    height, width = len(pixels), len(pixels[0])
    palette = sorted({pixel for row in pixels for pixel in row})
    chunks = []
    if len(palette) <= 256:
        number = {pixel: index for index, pixel in enumerate(palette)}
        kind, rows = 3, b"".join(b"\0" + bytes(number[pixel] for pixel in row) for row in pixels)
        chunks.append((b"PLTE", bytes(sum(palette, ()))))
    else:
        above, rows, kind = bytes(3 * width), b"", 2
        for row in pixels:
            line = bytes(sum(row, ()))
            rows += min((filtered(line, above, number) for number in range(5)), key=cost)
            above = line

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0)
    chunks = [(b"IHDR", header), *chunks, (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    (HERE / name).write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*c) for c in chunks))


def filtered(line, above, number):
    """A line of three bytes a pixel by one of PNG's filters, which is named first."""
    left, corner = bytes(3) + line[:-3], bytes(3) + above[:-3]
    if number == 4:
        guess = [min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
                 for a, b, c in zip(left, above, corner)]
    else:
        guess = (bytes(len(line)), left, above, [(a + b) // 2 for a, b in zip(left, above)])[number]
    return bytes([number]) + bytes((x - g) % 256 for x, g in zip(line, guess))


def cost(line):
    """Small for lines that compress well, as the PNG standard guesses."""
    return sum(min(x, 256 - x) for x in line[1:])


# Materials


def matt(red, green, blue):
    return linear(red, green, blue), (0.02,) * 3, 5


def scaled(colour, factor):
    return tuple(factor * c for c in colour)


GOLD = ((0.16, 0.10, 0.03), (0.62, 0.43, 0.14), 170)
SILVER = ((0.14, 0.14, 0.15), (0.48, 0.48, 0.50), 190)


# The walls of `cubes`


def on_walls(of_wall, of_floor):
    """A material on the square of texture coordinates of the room: `of_wall` is given the place along the left, back
    and right wall, 0..3, and the height above the floor, 0..1; `of_floor` x and z, 0..1."""
    def material(u, v):
        column, row = int(2 * u), int(2 * v)
        across, down = ((2 * x - n - MARGIN) / (1 - 2 * MARGIN) for x, n in ((u, column), (v, row)))
        across, down = (min(max(x, 0), 1) for x in (across, down))
        if (column, row) == (0, 1):
            return of_floor(across, down)
        return of_wall({(0, 0): 0, (1, 0): 1, (1, 1): 2}[column, row] + across, 1 - down)
    return material


def mural_wall(t, h):
    """A meadow under a sky with a rainbow; a house at the left, trees at the right."""
    if in_house(t, h):
        return in_house(t, h)
    for x, foot, size in ((0.46, 0.08, 0.9), (2.30, 0.07, 1.0), (2.68, 0.06, 0.85), (1.93, 0.13, 0.6)):
        i, j = (t - x) / size, (h - foot) / size - 0.34
        if within(i, j, (0, 0.02, 0.12), (-0.09, -0.05, 0.09), (0.09, -0.05, 0.09)):
            apples = (-0.06, 0.03), (0.05, 0.06), (0.01, -0.05), (0.10, -0.06), (-0.11, -0.07)
            if within(i, j, *((*middle, 0.018) for middle in apples)):
                return matt(222, 48, 40)
            return matt(66, 140, 58) if i + j < 0 else matt(86, 162, 66)
        if abs(i) < 0.022 and -0.34 < j < 0:
            return matt(122, 78, 48)
    for foot, wide, colour in ((0.05, 1.9, (112, 182, 72)), (0.12, 1.3, (160, 208, 92)), (0.18, 0.9, (122, 182, 134))):
        if h < foot + 0.05 * math.sin(wide * math.pi * t + 9 * foot):
            place = (9 * t) % 1 - 0.5, (9 * h + 0.5 * (int(9 * t) % 2)) % 1 - 0.5
            daisy = foot == 0.05 and math.hypot(*place) < 0.17
            return matt(250, 244, 214) if daisy else matt(*colour)
    if math.hypot(t - 0.95, h - 0.80) < 0.10:
        return matt(255, 208, 64)
    spoke = (math.atan2(h - 0.80, t - 0.95) / (2 * math.pi) * 16) % 1
    if math.hypot(t - 0.95, h - 0.80) < 0.17 and abs(spoke - 0.5) < 0.17:
        return matt(255, 208, 64)
    i, j = (t - 2.02) / 0.11, (h - 0.80) / 0.125
    if math.hypot(i, j) < 1:
        gore = int(3 + 3.5 * i / (1.05 - 0.3 * abs(j))) % 3
        return matt(*((214, 62, 56), (248, 236, 210), (240, 160, 50))[gore])
    if abs(t - 2.02) < 0.03 and 0.615 < h < 0.65:
        return matt(140, 92, 54)
    if abs(abs(t - 2.02) - 0.022 - 0.4 * (h - 0.65)) < 0.004 and 0.64 < h < 0.72:
        return matt(110, 74, 50)
    for x, y, size in ((0.35, 0.78, 0.9), (1.62, 0.90, 0.8), (2.60, 0.82, 1.0), (1.30, 0.60, 0.5)):
        i, j = (t - x) / size, (h - y) / size
        puffs = ((0, 0, 0.07), (-0.08, -0.015, 0.05), (0.08, -0.01, 0.055), (0.03, 0.03, 0.06))
        if j > -0.045 and within(i, j, *puffs):
            return matt(250, 250, 248)
    bow = (math.hypot(t - 1.5, h - 0.12) - 0.40) / 0.03
    if 0 <= bow < 6:
        return matt(*RAINBOW[int(bow)])
    sky = (196, 226, 238), (174, 214, 236), (150, 200, 234), (128, 186, 230)
    return matt(*sky[min(max(int(4.6 * h - 0.7), 0), 3)])


RAINBOW = (142, 92, 180), (74, 112, 206), (84, 176, 92), (250, 222, 82), (244, 152, 58), (222, 66, 60)


def within(x, y, *circles):
    return any(math.hypot(x - i, y - j) < radius for i, j, radius in circles)


def in_house(t, h):
    x, y = t - 0.68, h - 0.05
    if 0 < y < 0.30 and abs(x) < 0.17:
        door, pane = abs(x + 0.07) < 0.045 and y < 0.17, abs(x - 0.075) < 0.05 and 0.11 < y < 0.22
        cross_bar = abs(x - 0.075) < 0.006 or abs(y - 0.165) < 0.006
        if pane:
            return matt(250, 246, 230) if cross_bar else matt(252, 214, 108)
        return matt(60, 104, 150) if door else matt(236, 190, 136)
    if 0.30 <= y < 0.30 + 0.95 * (0.21 - abs(x)) and abs(x) < 0.21:
        return matt(190, 66, 52) if (int(28 * y) + int(40 * (x + 1))) % 2 else matt(206, 80, 62)
    return matt(150, 86, 66) if 0.09 < x < 0.13 and 0.3 < y < 0.5 else None


def mural_floor(x, z):
    """A carpet: meadow, a way that winds, a pond, daisies."""
    way = abs(x - 0.5 - 0.16 * math.sin(5.2 * z + 0.4)) - 0.075
    if way < 0.0:
        stone = math.hypot((12 * x + 0.5 * (int(12 * z) % 2)) % 1 - 0.5, (12 * z) % 1 - 0.5) < 0.40
        return matt(238, 214, 160) if stone else matt(212, 180, 124)
    pond = math.hypot((x - 0.84) / 0.13, (z - 0.84) / 0.10)
    if pond < 1.15:
        return (linear(70, 150, 210), (0.10,) * 3, 80) if pond < 1 else matt(244, 232, 190)
    i, j = int(9 * x), int(9 * z)
    place = 9 * x - i - 0.5 + 0.3 * math.sin(7 * i + j), 9 * z - j - 0.5 + 0.3 * math.sin(5 * j + 3 * i)
    if math.hypot(*place) < 0.16:
        return matt(*((250, 244, 214), (244, 120, 130), (252, 214, 90))[(i + 2 * j) % 3])
    return matt(122, 184, 74) if (int(8 * (x + z)) % 2) else matt(134, 194, 82)


def stripes_wall(t, h):
    """Wallpaper of coloured stripes, every other satin, over a white skirting."""
    if h < 0.07:
        return (linear(244, 240, 230), (0.05,) * 3, 30)
    number = int(8 * t) % 8
    if number % 2:
        return matt(248, 238, 214)
    return linear(*((226, 74, 62), (246, 178, 60), (64, 150, 150), (54, 84, 148))[number // 2]), (0.09,) * 3, 40


def stripes_floor(x, z):
    """Boards with a gloss."""
    row = int(10 * x)
    tone = 1 + 0.22 * (noise(row, 0.3, 4) - 0.5) + 0.12 * (noise(90 * x, 5 * z + 3 * row, 5) - 0.5)
    joint = 10 * x - row < 0.05 or (2 * z + 0.37 * row) % 1 < 0.012
    return matt(78, 50, 32) if joint else (scaled(linear(192, 142, 92), tone), (0.10,) * 3, 60)


def checker_wall(t, h):
    """A wall of red, one of cream and one of blue squares, among paler ones."""
    wall, odd = int(t), (int(6 * t) + int(6 * h)) % 2
    colours = (((206, 42, 40), (246, 206, 190)), ((250, 196, 70), (252, 240, 206)), ((36, 86, 186), (196, 220, 246)))
    return linear(*colours[min(wall, 2)][odd]), (0.03,) * 3, 8


def checker_floor(x, z):
    """Black and white marble, polished."""
    vein = abs(noise(7 * x + 2 * noise(6 * x, 6 * z, 3), 7 * z, 2) - 0.5) < 0.025
    if (int(6 * x) + int(6 * z)) % 2:
        return (linear(40, 40, 44) if not vein else linear(96, 94, 92)), (0.22,) * 3, 160
    return (linear(226, 222, 212) if not vein else linear(178, 172, 166)), (0.16,) * 3, 160


def tile(x, y, colours):
    """Dark glazed tiles with a pale joint, no two beside each other of one colour."""
    i, j = math.floor(x), math.floor(y)
    edge = min(x - i, y - j, i + 1 - x, j + 1 - y)
    if edge < 0.035:
        return matt(150, 146, 138)
    kd = linear(*colours[(i + 2 * j) % len(colours)])
    return (kd, (0.34,) * 3, 190) if edge > 0.07 else (kd, (0.16,) * 3, 60)


TEALS = (24, 76, 84), (28, 92, 98), (20, 60, 74), (36, 102, 100), (22, 68, 94)


def tiles_wall(t, h):
    if 0.58 < h < 0.66:
        bead = math.hypot((25 * t) % 1 - 0.5, (h - 0.62) * 25) < 0.36
        return GOLD if bead else (linear(26, 24, 30), (0.2,) * 3, 160)
    return tile(5 * t, 5 * h + (0.9 if h < 0.6 else 0.7), TEALS)


def tiles_floor(x, z):
    return tile(4 * (x + z) + 8, 4 * (x - z) + 8, ((44, 38, 50), (60, 46, 58), (36, 34, 44), (70, 56, 62)))


# The bunny

# Texels along a side of its textures.
BUNNY = 256


def bunny_places():
    """The places on the bunny of 2 × 2 samples of each texel, row by row, in metres from where it
    stands; beyond charts, those nearby."""
    lines = (HERE.parent.parent / "assets/bunny.obj").read_text().split("\n")
    points = [tuple(0.125 * float(x) for x in line.split()[1:4]) for line in lines if line.startswith("v ")]
    faces = [[int(c.split("/")[0]) - 1 for c in line.split()[1:4]] for line in lines if line.startswith("f ")]
    lines = (HERE / "bunny-painted/atlas.txt").read_text().split("\n")
    texture = [tuple(2 * BUNNY * float(x) - 0.5 for x in line.split()[1:3]) for line in lines if line.startswith("t ")]
    corners = [[int(c) - 1 for c in line.split()[1:4]] for line in lines if line.startswith("f ")]
    assert len(faces) == len(corners)
    side = 2 * BUNNY
    found = [[None] * side for _ in range(side)]
    for face, corner in zip(faces, corners):
        (ax, ay), (bx, by), (cx, cy) = (texture[c] for c in corner)
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        for y in range(max(math.ceil(min(ay, by, cy)), 0), min(math.floor(max(ay, by, cy)), side - 1) + 1):
            for x in range(max(math.ceil(min(ax, bx, cx)), 0), min(math.floor(max(ax, bx, cx)), side - 1) + 1):
                v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
                w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
                if v >= 0 and w >= 0 and v + w <= 1:
                    found[y][x] = tuple((1 - v - w) * a + v * b + w * c for a, b, c in zip(*(points[p] for p in face)))
    return spread(found)


def spread(rows):
    """Fills what is None by what is beside it, ring by ring."""
    side = len(rows)
    border = [(x, y) for y in range(side) for x in range(side) if rows[y][x] is not None]
    while border:
        reached = {}
        for x, y in border:
            for i, j in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
                if 0 <= i < side and 0 <= j < side and rows[j][i] is None:
                    reached.setdefault((i, j), rows[y][x])
        for (i, j), place in reached.items():
            rows[j][i] = place
        border = list(reached)
    return rows


def on_bunny(places, of_place):
    side = len(places)
    return lambda u, v: of_place(*places[int(v * side)][int(u * side)])


def solid_noise(x, y, z, seed):
    """Smooth noise in space of 0..1: three plane ones."""
    return (noise(x, y, seed) + noise(y, z, seed + 1) + noise(z, x, seed + 2)) / 3


def halves(x, y, z):
    """Red in front, blue behind."""
    border = 0.04 * math.sin(8 * y) + 0.08 * y
    return ((0.72, 0.035, 0.03), (0.03,) * 3, 6) if x < border else ((0.03, 0.10, 0.68), (0.03,) * 3, 6)


def gilded(x, y, z):
    """White glaze, broken and mended with gold; tips gilded."""
    a, b = (solid_noise(4.2 * x + 7, 4.2 * y + 7, 4.2 * z + 7, seed) for seed in (1, 11))
    seam = min(abs(a - 0.5) / 0.9, abs(b - 0.49) / 0.9)
    ear = y > 1.03 + 0.03 * math.sin(25 * x)
    if seam < 0.014 or ear or y < 0.04:
        return GOLD
    return (0.70, 0.69, 0.65), (0.04,) * 3, 100


def spots(x, y, z):
    """Glossy spots on what is matt: balls in space, one in each cell of a grid, cut by the surface."""
    colours = ((0.62, 0.04, 0.05), (0.80, 0.36, 0.02), (0.03, 0.24, 0.55), (0.06, 0.36, 0.12), (0.35, 0.05, 0.34))
    place = [6.3 * c for c in (x + 3, y, z + 3)]
    nearest = math.inf, 0
    for step in itertools.product((-1, 0, 1), repeat=3):
        cell = [math.floor(c) + s for c, s in zip(place, step)]
        number = zlib.crc32(struct.pack("<3i", *cell))
        middle = [c + 0.25 + 0.5 * ((number >> shift) & 255) / 255 for c, shift in zip(cell, (0, 8, 16))]
        nearest = min(nearest, (math.dist(middle, place), number))
    if nearest[0] < 0.46:
        return colours[(nearest[1] >> 24) % 5], (0.10,) * 3, 190
    return (0.74, 0.68, 0.56), (0.01,) * 3, 3


def jade(x, y, z):
    """Green stone in layers, polished; darker ones are duller."""
    layer = 7.5 * (y + 0.35 * x) + 2.2 * solid_noise(2.5 * x + 5, 2.5 * y + 5, 2.5 * z + 5, 21)
    dark = abs(layer % 1 - 0.5) < 0.17
    pale = abs(layer % 1 - 0.5) > 0.42
    if dark:
        return (0.015, 0.10, 0.06), (0.03, 0.04, 0.03), 20
    return ((0.40, 0.62, 0.40) if pale else (0.08, 0.42, 0.20)), (0.06,) * 3, 110


# The tube


def on_tube(of_side):
    """`of_side` is given the part of a turn, the height of 0..1, and whether the place is outside; edges are as what
    is outside has it at the top."""
    def material(u, v):
        for number in (0, 2):
            top, bottom = sorted(ROWS[number])
            if top - 0.005 < v < bottom + 0.005:
                return of_side(u, min(max((bottom - v) / (bottom - top), 0), 1), number == 0)
        return of_side(u, 1, True)
    return material


def engraved(u, h, outside):
    """Gold with engraved rims and a meander between."""
    deep = ((0.09, 0.05, 0.015), (0.10, 0.07, 0.02), 12)
    if abs(abs(h - 0.5) - 0.36) < 0.02 or abs(abs(h - 0.5) - 0.42) < 0.012:
        return deep
    x, y = 8 * ((24 * u) % 1), 8 * (h - 0.5) / 0.60 + 4
    if 0 <= y < 8:
        rows = ("........", "#######.", "#.....#.", "#.###.#.", "#.#...#.", "#.#####.", "#.......", "########")
        return deep if rows[7 - int(y)][int(x)] == "#" else GOLD
    return GOLD


def bands(u, h, outside):
    """Upright bands of red and blue, matt."""
    red = int(16 * u) % 2
    if outside:
        return ((0.70, 0.06, 0.04) if red else (0.04, 0.12, 0.66)), (0.02,) * 3, 5
    return ((0.76, 0.50, 0.08) if red else (0.05, 0.42, 0.36)), (0.02,) * 3, 5


def half(u, h, outside):
    """Silver, by halves polished and rough; the border goes up and down in steps."""
    border = 0.56 + (0.02 if int(6 * h) % 2 else -0.02)
    polished = (u - border) % 1 < 0.5 if outside else (u + 0.03 * (int(6 * h) % 2)) % 0.25 < 0.14
    return SILVER if polished else ((0.32, 0.31, 0.30), (0.20,) * 3, 4)


def rings(u, h, outside):
    """Five rings of coloured metal with dark grooves."""
    number, share = min(int(5 * h), 4), (5 * h) % 1
    if share < 0.09 or share > 0.91:
        return (0.02, 0.02, 0.02), (0.03,) * 3, 8
    colours = (0.80, 0.12, 0.10), (0.82, 0.46, 0.08), (0.20, 0.66, 0.16), (0.08, 0.44, 0.80), (0.52, 0.16, 0.72)
    return scaled(colours[number], 0.25), scaled(colours[number], 0.80), 180


# Models


def walls():
    """Left wall, back wall, floor and right wall of a room, 2 m wide, high and deep, in the quarters of the square."""
    model = Model()
    sides = (
        ((0, 0), (-1, 2, 1), (0, 0, -2), (0, -2, 0)),
        ((1, 0), (-1, 2, -1), (2, 0, 0), (0, -2, 0)),
        ((0, 1), (-1, 0, -1), (2, 0, 0), (0, 0, 2)),
        ((1, 1), (1, 2, -1), (0, 0, 2), (0, -2, 0)),
    )
    for (column, row), corner, right, down in sides:
        normal = [x / 4 for x in cross(down, right)]

        def at(u, v):
            place = [c + u * r + v * d for c, r, d in zip(corner, right, down)]
            s, t = ((n + MARGIN + (1 - 2 * MARGIN) * x) / 2 for n, x in ((column, u), (row, v)))
            return {"v": place, "vt": (s, 1 - t), "vn": normal}

        model.add([at(0, 0), at(0, 1), at(1, 1), at(1, 0)])
    model.write("cubes/walls.obj")


def tube():
    """The outside, the upper edge, the inside and the lower edge of a tube, below each other in the square."""
    model = Model()
    outer, inner = RADII
    strips = (
        ((outer, HEIGHT), (outer, 0), (1, 0)),
        ((inner, HEIGHT), (outer, HEIGHT), (0, 1)),
        ((inner, 0), (inner, HEIGHT), (-1, 0)),
        ((outer, 0), (inner, 0), (0, -1)),
    )
    for rows, (first, last, (out, up)) in zip(ROWS, strips):
        for i in range(SEGMENTS):
            def at(step, end):
                (radius, height), row = (first, last)[end], rows[end]
                angle = 2 * math.pi * step / SEGMENTS
                x, z = -math.sin(angle), -math.cos(angle)
                place, normal = (radius * x, height, radius * z), (out * x, up, out * z)
                return {"v": place, "vt": (step / SEGMENTS, 1 - row), "vn": normal}

            model.add([at(i, 0), at(i, 1), at(i + 1, 1), at(i + 1, 0)])
    model.write("tube/tube.obj")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


# What is left free around each quarter of the square, in quarters: a texel of 256.
MARGIN = 1 / 128
# Metres.
RADII, HEIGHT, SEGMENTS = (0.50, 0.48), 0.30, 160
# Where in the square the outside, the upper edge, the inside and the lower edge of the tube begin and end, in
# regions, of which there are 32: a texel of 256 is left free between them.
ROWS = tuple((i / 32 + m / 256, j / 32 - m / 256) for i, j, m in ((0, 15, 1), (15, 16, 1), (31, 16, -1), (31, 32, 1)))


def main():
    walls()
    tube()
    for name, size, of_wall, of_floor in (
        ("mural", 512, mural_wall, mural_floor),
        ("stripes", 256, stripes_wall, stripes_floor),
        ("checker", 256, checker_wall, checker_floor),
        ("tiles", 256, tiles_wall, tiles_floor),
    ):
        write_textures("cubes", name, size, on_walls(of_wall, of_floor))
    for name, of_side in (("engraved", engraved), ("bands", bands), ("half", half), ("rings", rings)):
        write_textures("tube", name, 256, on_tube(of_side))
    places = bunny_places()
    for name, of_place in (("halves", halves), ("gilded", gilded), ("spots", spots), ("jade", jade)):
        write_textures("bunny-painted", name, BUNNY, on_bunny(places, of_place))


if __name__ == "__main__":
    main()
