"""The second opinion on glTF 2.0 files: triangles in world space at rest, skins and morph weights applied, instances placed."""

import base64
import json
import os
import struct
import urllib.parse

import numpy as np

from reference import Mesh

TYPES = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
LARGEST = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}
KNOWN = ("KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual", "EXT_mesh_gpu_instancing")


class Gltf:
    """The JSON part and the numbers it names."""

    def __init__(self, path):
        self.folder, self.bin, self.buffers = os.path.dirname(path), None, {}
        data = open(path, "rb").read()
        text = self.glb_text(data) if data[:4] == b"glTF" else data.decode("utf-8-sig")
        self.json = json.loads(text)
        if not str(self.json.get("asset", {}).get("version", "")).startswith("2"):
            raise ValueError(f"not glTF 2: {self.json.get('asset')!r}")

    def glb_text(self, data):
        (version,), at, text = struct.unpack("<I", data[4:8]), 12, ""
        if version != 2:
            raise ValueError(f"GLB of version {version}")
        while at + 8 <= len(data):
            length, kind = struct.unpack("<II", data[at : at + 8])
            chunk = data[at + 8 : at + 8 + length]
            at += 8 + length
            if kind == 0x4E4F534A:
                text = chunk.rstrip(b"\0 ").decode("utf-8-sig")
            elif kind == 0x004E4942 and self.bin is None:
                self.bin = chunk
        return text

    def buffer(self, index):
        if index not in self.buffers:
            uri = self.json["buffers"][index].get("uri")
            if uri is None:
                data = self.bin
            elif uri.startswith("data:"):
                code = uri.split(",", 1)[1]
                data = base64.b64decode(code + "=" * (-len(code) % 4))
            else:
                data = open(os.path.join(self.folder, urllib.parse.unquote(uri)), "rb").read()
            self.buffers[index] = np.frombuffer(data, np.uint8)
        return self.buffers[index]

    def view(self, index, offset, kind, width, count):
        view, dtype = self.json["bufferViews"][index], np.dtype("<" + TYPES[kind])
        if "EXT_meshopt_compression" in view.get("extensions", {}):
            raise ValueError("meshopt")
        row, start = dtype.itemsize * width, view.get("byteOffset", 0) + offset
        stride, data = view.get("byteStride") or row, self.buffer(view["buffer"])
        if count and start + stride * (count - 1) + row > len(data):
            raise ValueError("accessor beyond its buffer")
        rows = np.lib.stride_tricks.as_strided(data[start:], (count, row), (stride, 1))
        return np.ascontiguousarray(rows).view(dtype).reshape(count, width)

    def accessor(self, index):
        a = self.json["accessors"][index]
        width, count, kind = WIDTHS[a["type"]], a["count"], a["componentType"]
        values = np.zeros((count, width), TYPES[kind])
        if "bufferView" in a:
            values = self.view(a["bufferView"], a.get("byteOffset", 0), kind, width, count).copy()
        if "sparse" in a:
            at, what, changed = a["sparse"]["indices"], a["sparse"]["values"], a["sparse"]["count"]
            where = self.view(at["bufferView"], at.get("byteOffset", 0), at["componentType"], 1, changed)[:, 0]
            values[where] = self.view(what["bufferView"], what.get("byteOffset", 0), kind, width, changed)
        values = values.astype(float)
        return np.maximum(values / LARGEST[kind], -1) if a.get("normalized") else values


def trs(translation, rotation, scale):
    x, y, z, w = np.array(rotation, float) / (np.linalg.norm(rotation) or 1)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= np.array(scale, float)
    matrix[:3, 3] = translation
    return matrix


def node_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    return trs(node.get("translation", [0, 0, 0]), node.get("rotation", [0, 0, 0, 1]), node.get("scale", [1, 1, 1]))


def read_gltf(path):
    gltf, mesh = Gltf(path), Mesh()
    mesh.features |= set(gltf.json.get("extensionsUsed", []))
    for extension in gltf.json.get("extensionsRequired", []):
        if extension not in KNOWN and not extension.startswith("KHR_materials"):
            raise ValueError(f"requires {extension}")
    world = world_matrices(gltf, mesh)
    for index, matrix in world.items():
        node = gltf.json["nodes"][index]
        if "mesh" in node:
            add_node(gltf, mesh, node, matrix, world)
    return mesh.finish()


def world_matrices(gltf, mesh):
    """The matrix of each node of the scene that is shown."""
    nodes, scenes = gltf.json.get("nodes", []), gltf.json.get("scenes", [])
    if scenes:
        roots = scenes[gltf.json.get("scene", 0)].get("nodes", [])
    else:
        mesh.features.add("no scene")
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [i for i in range(len(nodes)) if i not in children]
    world, stack = {}, [(root, np.eye(4)) for root in roots]
    while stack:
        index, parent = stack.pop()
        if index in world:
            raise ValueError(f"node {index} is twice in the tree")
        world[index] = parent @ node_matrix(nodes[index])
        stack += [(child, world[index]) for child in nodes[index].get("children", [])]
    return world


def add_node(gltf, mesh, node, matrix, world):
    places, instancing = [matrix], node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
    if instancing:
        attributes = {name: gltf.accessor(i) for name, i in instancing["attributes"].items()}
        count = max(len(values) for values in attributes.values())
        default = {"TRANSLATION": [0, 0, 0], "ROTATION": [0, 0, 0, 1], "SCALE": [1, 1, 1]}
        places = [matrix @ trs(*(attributes[n][k] if n in attributes else d for n, d in default.items())) for k in range(count)]
        mesh.features.add(f"{count} instances")
    shape = gltf.json["meshes"][node["mesh"]]
    weights = node.get("weights", shape.get("weights", []))
    for primitive in shape["primitives"]:
        if "KHR_draco_mesh_compression" in primitive.get("extensions", {}):
            raise ValueError("Draco")
        if primitive.get("mode", 4) < 4 or "POSITION" not in primitive["attributes"]:
            mesh.features.add("points or lines" if primitive.get("mode", 4) < 4 else "no POSITION")
            continue
        positions, triangles = positions_of(gltf, mesh, primitive, weights), triangles_of(gltf, mesh, primitive)
        if len(triangles) and triangles.max() >= len(positions):
            raise ValueError("index out of range")
        if "skin" in node:
            mesh.features.add("skin")
            mesh.triangles_of.append(skinned(gltf, primitive, gltf.json["skins"][node["skin"]], positions, world)[triangles])
        else:
            mesh.triangles_of += [(positions @ place[:3, :3].T + place[:3, 3])[triangles] for place in places]


def positions_of(gltf, mesh, primitive, weights):
    index = primitive["attributes"]["POSITION"]
    positions = gltf.accessor(index)
    if "sparse" in gltf.json["accessors"][index]:
        mesh.features.add("sparse POSITION")
    for target, weight in zip(primitive.get("targets", []), weights):
        if weight and "POSITION" in target:
            mesh.features.add("morphed at rest")
            positions = positions + weight * gltf.accessor(target["POSITION"])
    return positions


def triangles_of(gltf, mesh, primitive):
    mode, count = primitive.get("mode", 4), gltf.json["accessors"][primitive["attributes"]["POSITION"]]["count"]
    corners = gltf.accessor(primitive["indices"])[:, 0].astype(int) if "indices" in primitive else np.arange(count)
    if mode == 4:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    mesh.features.add("strip or fan")
    first = corners[:-2] if mode == 5 else np.full(max(len(corners) - 2, 0), corners[0])
    return np.stack([first, corners[1:-1], corners[2:]], 1)


def skinned(gltf, primitive, skin, positions, world):
    inverse = np.tile(np.eye(4), (len(skin["joints"]), 1, 1))
    if "inverseBindMatrices" in skin:
        inverse = gltf.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices = np.stack([world.get(joint, np.eye(4)) @ inverse[k] for k, joint in enumerate(skin["joints"])])
    joints, weights = gltf.accessor(primitive["attributes"]["JOINTS_0"]).astype(int), gltf.accessor(primitive["attributes"]["WEIGHTS_0"])
    weights = weights / np.maximum(weights.sum(1, keepdims=True), 1e-20)
    homogeneous = np.concatenate([positions, np.ones((len(positions), 1))], 1)
    return np.einsum("nk,nkij,nj->ni", weights, matrices[np.where(weights > 0, joints, 0)], homogeneous)[:, :3]
