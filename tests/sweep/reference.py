"""A second opinion on OBJ, OFF and PLY files (glTF: reference_gltf.py), written from the formats' specifications and independent of Relume
and of trimesh. Simple before fast."""

import os
import re

import numpy as np

FLAT = 1e-5  # a polygon is planar if no corner leaves its plane by more than this part of its size


class Mesh:
    """Triangles and polygons in world space, and in `features` what readers are known to treat differently."""

    def __init__(self):
        self.triangles_of, self.polygons, self.features = [], [], set()
        self.points = self.lines = self.bad_faces = 0

    def add_faces(self, vertices, faces):
        triples = []
        for face in faces:
            if len(face) < 3 or min(face) < 0 or max(face) >= len(vertices):
                self.bad_faces += 1
            elif len(face) == 3:
                triples.append(face)
            else:
                self.polygons.append(vertices[list(face)])
        if triples:
            self.triangles_of.append(vertices[np.array(triples)])

    def finish(self):
        """Counts and measures. Any triangulation of a planar polygon has the area of Newell's vector; what bent ones may have is bounded."""
        triangles = np.concatenate(self.triangles_of) if self.triangles_of else np.zeros((0, 3, 3))
        self.low = self.high = triangle_areas(triangles).sum()
        concave = bent = 0
        for p in self.polygons:
            newell, fan = 0.5 * np.linalg.norm(newell_vector(p)), triangle_areas(fan_of(p)).sum()
            low = high = newell
            if flatness(p) >= FLAT:
                bent += 1
                other = triangle_areas(fan_of(np.roll(p, 1, axis=0))).sum()
                low, high = (min(fan, other), max(fan, other)) if len(p) == 4 else (newell, max(fan * 1.2, newell))
            elif fan > newell * (1 + 1e-4):
                concave += 1
            self.low += low
            self.high += high
        if not np.isfinite(self.low):
            raise ValueError("positions that are not finite")
        corners = np.concatenate([triangles.reshape(-1, 3)] + self.polygons)
        self.triangles = len(triangles) + sum(len(p) - 2 for p in self.polygons)
        self.bounds = [corners.min(0).tolist(), corners.max(0).tolist()] if len(corners) else None
        counts = {
            "concave polygons": concave,
            "bent polygons": bent,
            "polygons of more than 3 corners": len(self.polygons),
            "lines": self.lines,
            "points": self.points,
            "faces left out": self.bad_faces,
        }
        self.features |= {f"{n} {what}" for what, n in counts.items() if n}
        return self


def triangle_areas(t):
    return 0.5 * np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1)


def fan_of(p):
    return np.array([[p[0], p[i], p[i + 1]] for i in range(1, len(p) - 1)])


def newell_vector(p):
    return np.cross(p - p[0], np.roll(p - p[0], -1, axis=0)).sum(0)


def flatness(p):
    normal, size = newell_vector(p), np.linalg.norm(p.max(0) - p.min(0))
    length = np.linalg.norm(normal)
    if size == 0 or length < 1e-12 * size * size:
        return 1.0
    return np.abs((p - p[0]) @ (normal / length)).max() / size


def text_of(path, mesh):
    """The text, in UTF-8 or UTF-16 after a mark, else in Latin-1."""
    data = open(path, "rb").read()
    for mark, code in ((b"\xef\xbb\xbf", "utf-8"), (b"\xfe\xff", "utf-16-be"), (b"\xff\xfe", "utf-16-le")):
        if data.startswith(mark):
            mesh.features.add(f"byte order mark {code}")
            return data[len(mark) :].decode(code, "replace")
    return data.decode("latin-1")


def read_obj(path):
    mesh, vertices, faces = Mesh(), [], []
    text = text_of(path, mesh).replace("\r\n", "\n").replace("\r", "\n")
    if "\\\n" in text:
        mesh.features.add("continued lines")
    for line in text.replace("\\\n", " ").split("\n"):
        words = line.split("#")[0].split()
        if not words:
            continue
        if words[0] == "v":
            vertices.append([float(x) for x in words[1:4]])
        elif words[0] in ("f", "fo"):
            first = [int(w.split("/")[0]) for w in words[1:]]
            faces.append([i - 1 if i > 0 else len(vertices) + i for i in first])
        elif words[0] == "l":
            mesh.lines += 1
        elif words[0] == "p":
            mesh.points += 1
        elif words == ["usemtl"]:
            mesh.features.add("usemtl without a name")
    if any(ord(c) > 127 for c in text):
        mesh.features.add("not ASCII")
    if any(f and (min(f) < 0 or max(f) >= len(vertices)) for f in faces):
        raise ValueError("a face names a vertex that is not there")
    mesh.add_faces(np.array(vertices, float).reshape(-1, 3), faces)
    return mesh.finish()


def read_off(path):
    """As the Geomview manual has it: the keyword is optional, and line breaks mean something only after faces."""
    mesh = Mesh()
    lines = [line.split("#")[0].split() for line in text_of(path, mesh).replace("\r", "\n").split("\n")]
    words = [(word, number) for number, line in enumerate(lines) for word in line]
    if not words:
        raise ValueError("empty")
    at, texture, colour, normal = off_keyword(words, mesh)
    vertex_count, face_count = int(words[at][0]), int(words[at + 1][0])
    if len(words) < vertex_count:
        raise ValueError(f"ends before vertex {vertex_count}")
    at += 3

    def line_end(at):
        number = words[at - 1][1]
        while at < len(words) and words[at][1] == number:
            at += 1
        return at

    vertices, faces = [], []
    for _ in range(vertex_count):
        vertices.append([float(words[at + k][0]) for k in range(3)])
        at += 3 + 3 * normal + 2 * texture
        at = line_end(at) if colour else at  # three or four numbers
    for _ in range(face_count):
        count = int(words[at][0])
        faces.append([int(word) for word, _ in words[at + 1 : at + 1 + count]])
        if len(faces[-1]) < count:
            raise ValueError("a face ends early")
        at = line_end(at + 1 + count)
    mesh.add_faces(np.array(vertices, float).reshape(-1, 3), faces)
    return mesh.finish()


def off_keyword(words, mesh):
    """Index of the first count, and whether vertices have texture coordinates, colours, normals."""
    word, line = words[0]
    if re.fullmatch(r"\d+", word):
        mesh.features.add("no keyword")
        return 0, False, False, False
    head = re.fullmatch(r"(ST)?(CN|NC|C|N)?(4)?(n)?OFF(\d*)", word)
    if not head:
        raise ValueError(f"the first word is {word!r}")
    if words[1][0] == "BINARY":
        raise ValueError("binary OFF")
    if head[3] or head[4]:
        raise ValueError("four-dimensional" if head[3] else "n-dimensional")
    if word != "OFF":
        mesh.features.add(word)
    if head[5]:
        words.insert(1, (head[5], line))
    if words[1][1] == line:
        mesh.features.add("counts on the first line")
    letters = head[2] or ""
    return 1, bool(head[1]), "C" in letters, "N" in letters


PLY_TYPES = {"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4", "double": "f8"}
PLY_TYPES |= {"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8"}


def read_ply(path):
    mesh, data = Mesh(), open(path, "rb").read()
    form, elements, at = ply_header(data)
    if form != "ascii":
        mesh.features.add(form)
    rows = ply_rows(data, form, elements, at)
    if "vertex" not in rows:
        raise ValueError("no element vertex")
    vertices = np.array([[row[axis] for axis in "xyz"] for row in rows["vertex"]], float).reshape(-1, 3)
    lists = [row.get("vertex_indices", row.get("vertex_index", [])) for row in rows.get("face", rows.get("tristrips", []))]
    if "face" not in rows and "tristrips" not in rows:
        raise ValueError("no faces")
    if "face" not in rows:
        mesh.features.add("triangle strips")
        lists = [face for strip in lists for face in strip_faces(strip)]
    mesh.add_faces(vertices, lists)
    return mesh.finish()


def ply_header(data):
    if not data.startswith(b"ply"):
        raise ValueError("no ply signature")
    end = data.index(b"end_header")
    at = data.index(b"\n" if b"\n" in data[end : end + 13] else b"\r", end) + 1
    form, elements = None, []
    for line in data[:end].decode("latin-1").replace("\r", "\n").split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            form = words[1]
        elif words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), []))
        elif words[:2] == ["property", "list"]:
            elements[-1][2].append((words[4], PLY_TYPES[words[2]], PLY_TYPES[words[3]]))
        elif words[:1] == ["property"]:
            elements[-1][2].append((words[2], None, PLY_TYPES[words[1]]))
    return form, elements, at


def ply_rows(data, form, elements, at):
    """Each element's rows, as dictionaries of numbers and lists."""
    order, tokens = ">" if "big" in form else "<", None
    if form == "ascii":
        tokens, at = data[at:].decode("latin-1").split(), 0

    def take(kind, count):
        nonlocal at
        if tokens is None:
            values = np.frombuffer(data, order + kind, count, at).tolist()
            at += count * int(kind[1])
        else:
            values = [float(token) if kind[0] == "f" else int(float(token)) for token in tokens[at : at + count]]
            at += count
        return values

    def row(properties):
        return {name: take(kind, 1)[0] if size is None else take(kind, int(take(size, 1)[0])) for name, size, kind in properties}

    return {name: [row(properties) for _ in range(count)] for name, count, properties in elements}


def strip_faces(strip):
    run, faces = [], []
    for index in strip:
        run = run + [index] if index >= 0 else []
        if len(run) >= 3:
            faces.append(run[-3:])
    return faces


def read(path):
    import reference_gltf

    readers = {"obj": read_obj, "off": read_off, "ply": read_ply, "gltf": reference_gltf.read_gltf, "glb": reference_gltf.read_gltf}
    return readers[os.path.splitext(path)[1][1:].lower()](path)
