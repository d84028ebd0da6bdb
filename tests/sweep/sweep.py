"""Reads the models and environment maps of files.txt with `bake export` and judges what comes out by trimesh, OpenEXR and the readers of
reference.py, reference_gltf.py and maps.py. Usage: sweep.py BAKE [PART_OF_A_PATH]. Writes docs/notes/SWEEP.md, unless only a part is read, and
target/sweep/sweep.json; exit code 1 if any verdict is in capitals."""

import json
import logging
import os
import re
import shutil
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import trimesh

import maps
import reference
import report

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
PACKAGES = os.path.join(TOP, "target", "sweep", "packages")
LIMIT_S = 120
TOLERANCE = 1e-4  # of areas, and of a box's diagonal
MAP_TOLERANCE = 1e-3

# A floor, so that no scene is without a surface; the model or the map is added below.
SCENE = """
[vary]
%s
[render]
size = [64, 64]
[camera]
position = [0.5, 0.6, 3.0]
target = [0.5, 0.5, 0.0]
fov_deg = 40.0
[materials.paint]
brdf = "blinn-phong"
kd = [0.6, 0.6, 0.6]
ks = [0.05, 0.05, 0.05]
shininess = 20.0
[[object]]
name = "floor"
shape = "quad"
material = "paint"
transform = { translation = [0.0, -0.5, 0.0], scale = 4.0 }
"""
MODEL = SCENE % 'materials = ["paint"]' + """
[[light]]
name = "sun"
kind = "directional"
irradiance = [3.0, 3.0, 3.0]
transform = { rotation_deg = [-40.0, 20.0, 0.0] }
[[object]]
name = "model"
file = FILE
"""
MAP = SCENE % "light = true\nview = true" + """
[environment]
file = FILE
"""


def main():
    binary, part = os.path.abspath(sys.argv[1]), sys.argv[2] if len(sys.argv) > 2 else ""
    warnings.filterwarnings("ignore")
    logging.disable(logging.CRITICAL)
    notes = json.load(open(os.path.join(HERE, "notes.json")))
    models, environments = [], []
    for path in listed():
        if part not in path:
            continue
        is_map = path.endswith((".exr", ".hdr"))
        row = (sweep_map if is_map else sweep_model)(binary, os.path.join(PACKAGES, path))
        known = next((note for end, note in notes.items() if path.endswith(end)), {})
        row.update(path=path, note=known.get("note", ""))
        if row["verdict"] == known.get("instead_of"):
            row["verdict"] = known["verdict"]
        (environments if is_map else models).append(row)
        print(f"{report.verdict(row):10} {path}", flush=True)
    os.chdir(TOP)
    json.dump(dict(models=models, maps=environments), open("target/sweep/sweep.json", "w"), indent=1)
    if not part:
        open("docs/notes/SWEEP.md", "w").write(report.page(models, environments, versions()))
    print("\n".join(report.counts(models, environments)))
    sys.exit(any(re.search("[A-Z]{5}", report.verdict(row)) for row in models + environments))


def listed():
    for line in open(os.path.join(HERE, "files.txt")):
        folder, colon, names = line.partition(":")
        if colon and not line.startswith("#"):
            yield from (f"{folder}/{name}" for name in names.split())


def versions():
    """The version of each REGISTRY/PACKAGE."""
    lines = [line.split() for line in open(os.path.join(HERE, "packages.txt")) if line[:1] not in "#\n"]
    return {f"{registry.split('-')[0]}/{package.replace('@', '').replace('/', '-')}": version for registry, package, version in lines}


def sweep_model(binary, path):
    """With a material of the scene; glTF files also with their own."""
    scene, seen = MODEL.replace("FILE", json.dumps(path)), measured_by_others(path)
    ours = bake(binary, scene + 'material = "paint"\n', path)
    row = dict(ours=ours, **seen)
    row["verdict"], row["why"] = judge(ours, **seen)
    if path.endswith((".gltf", ".glb")):
        row["own"] = bake(binary, scene, path)
        row["own_verdict"] = judge_own(row["own"], ours)
    return row


def bake(binary, scene, path):
    """Exit code, what was said, and of the exported scene without its floor: triangles, area, bounds, the map."""
    work = tempfile.mkdtemp(prefix="relume-sweep-")
    try:
        toml, out = os.path.join(work, "scene.toml"), os.path.join(work, "out")
        open(toml, "w").write(scene)
        try:
            done = subprocess.run([binary, "export", toml, "-o", out], capture_output=True, timeout=LIMIT_S, stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            return dict(code=124, said=f"longer than {LIMIT_S} s", warnings=[])
        said = [line for line in done.stderr.decode("utf-8", "replace").splitlines() if not line.startswith("warning")]
        said = re.sub(r'^error: |%s"?: ?|%s/' % (re.escape(path), re.escape(os.path.dirname(path))), "", " ".join(said))
        result = dict(code=done.returncode, said=said, warnings=[])
        if done.returncode == 0:
            result.update(exported(out))
        return result
    finally:
        shutil.rmtree(work, ignore_errors=True)


def exported(folder):
    scene = json.load(open(os.path.join(folder, "scene.json")))
    triangles = [exported_triangles(os.path.join(folder, o["file"])) for o in scene["objects"] if o["name"] != "floor"]
    result = measure(triangles)
    result["warnings"] = scene["warnings"]
    if scene["environment"]:
        image = maps.exr_pixels(os.path.join(folder, scene["environment"]["file"]))[0]
        result["map"] = dict(size=[image.shape[1], image.shape[0]], mean=image.mean((0, 1)).tolist())
    return result


def exported_triangles(path):
    data = open(path, "rb").read()
    at = data.index(b"end_header\n") + 11
    vertices, faces = (int(re.search(rf"element {name} (\d+)".encode(), data[:at])[1]) for name in ("vertex", "face"))
    rows = np.frombuffer(data, np.dtype([("position", "<f4", 3), ("normal", "<f4", 3)]), vertices, at)
    corners = np.frombuffer(data, np.dtype([("count", "u1"), ("corners", "<i4", 3)]), faces, at + rows.nbytes)["corners"]
    return rows["position"].astype(float)[corners]


def measure(triangles):
    triangles = np.concatenate(triangles) if triangles else np.zeros((0, 3, 3))
    corners = triangles.reshape(-1, 3)
    bounds = [corners.min(0).tolist(), corners.max(0).tolist()] if len(corners) else None
    return dict(triangles=len(triangles), area=float(reference.triangle_areas(triangles).sum()), bounds=bounds)


def measured_by_others(path):
    def told(reader):
        try:
            return reader(path)
        except Exception as error:
            return dict(error=f"{type(error).__name__}: {str(error)[:120]}")

    return dict(tri=told(by_trimesh), ref=told(by_reference))


def by_trimesh(path):
    scene, triangles = trimesh.load_scene(path, process=False), []
    for node in scene.graph.nodes_geometry:
        matrix, name = scene.graph[node]
        mesh = scene.geometry[name]
        if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces):
            positions = np.asarray(mesh.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3]
            triangles.append(positions[mesh.faces])
    return measure(triangles)


def by_reference(path):
    mesh = reference.read(path)
    return dict(triangles=mesh.triangles, area=[mesh.low, mesh.high], bounds=mesh.bounds, features=sorted(mesh.features))


def judge(ours, tri, ref):
    """Verdict and why. In small letters all is as it should be; CAPITALS are to be looked at."""
    if ours["code"] == 0:
        if agree(ours, tri) and ("error" in ref or agree(ours, ref)):
            return "same", ""
        if agree(ours, ref):
            return "right", "trimesh cannot read it" if "error" in tri else "trimesh reads it otherwise"
        if "error" in ref:
            return "ACCEPTED", ref["error"]
        likewise = "trimesh errs likewise; " if agree(ours, tri) else ""
        return "DIFFERS", likewise + "reference: area {:.6g}..{:.6g}, box off by {:.2g}".format(*ref["area"], box_distance(ours, ref))
    if ours["code"] != 2:
        return "CRASHED", f"exit code {ours['code']}"
    if "error" in ref or not ref["triangles"] or ref["area"][1] == 0:
        return "refused", ref.get("error", "nothing with an area in it")
    return "REFUSED", f"reference: {ref['triangles']} triangles"


def agree(ours, other):
    if "error" in other:
        return False
    low, high = np.broadcast_to(other["area"], 2)
    return low * (1 - TOLERANCE) - 1e-30 <= ours["area"] <= high * (1 + TOLERANCE) + 1e-30 and box_distance(ours, other) <= TOLERANCE


def box_distance(ours, other):
    """Largest difference of the bounding boxes, in diagonals."""
    if not ours["bounds"] or not other["bounds"]:
        return 0.0 if ours["bounds"] == other["bounds"] else float("inf")
    a, b = np.array(ours["bounds"]), np.array(other["bounds"])
    return float(np.abs(a - b).max() / (np.linalg.norm(b[1] - b[0]) or 1.0))


def judge_own(own, ours):
    """With the file's own materials the same triangles are expected."""
    if own["code"] or ours["code"]:
        return "same" if own["code"] == ours["code"] else "REFUSED" if own["code"] else "ACCEPTED"
    if own["triangles"] == ours["triangles"] and abs(own["area"] - ours["area"]) <= TOLERANCE * ours["area"]:
        return "same"
    return "DIFFERS"


def sweep_map(binary, path):
    ours = bake(binary, MAP.replace("FILE", json.dumps(path)), path)
    try:
        ref = maps.read(path)
    except Exception as error:
        ref = dict(error=f"{type(error).__name__}: {str(error)[:100]}")
    verdict, why = judge_map(ours, ref)
    return dict(ours=ours, ref=ref, verdict=verdict, why=why)


def judge_map(ours, ref):
    twice_as_wide = "error" not in ref and ref["size"][0] == 2 * ref["size"][1]
    why = "; ".join(ref.get("features", []))
    if ours["code"]:
        return ("CRASHED" if ours["code"] != 2 else "REFUSED" if twice_as_wide else "refused"), why
    if "error" in ref:
        return "ACCEPTED", ref["error"]
    if not twice_as_wide:
        return "ACCEPTED", "not twice as wide as high, but taken for latitude-longitude"
    means = any(np.allclose(ours["map"]["mean"], mean, rtol=MAP_TOLERANCE, atol=1e-6) for mean in ref["means"])
    return "same" if means and ours["map"]["size"] == ref["size"] else "DIFFERS", why


if __name__ == "__main__":
    main()
