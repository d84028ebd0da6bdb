"""Rays through Embree, for comparison with `cargo bench -p relume-bake --bench rays`, which leaves the very triangles and
rays in target/rays. One thread; each chunk's best time counts. Rays that meet another triangle than ours are counted.

    cargo bench -p relume-bake --bench rays -- write
    pip install numpy embreex && taskset -c 0 python bake/benches/embree.py
"""

import pathlib
import time

import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

CHUNK = 1 << 12
ROUNDS = 7
FOLDER = pathlib.Path(__file__).parents[2] / "target/rays"


def read(file, kind, shape):
    return numpy.fromfile(FOLDER / file, kind).reshape(shape)


def seconds(scene, origins, directions, query):
    """Of one run, chunk by chunk."""
    times = []
    for first in range(0, len(origins), CHUNK):
        chunk = slice(first, first + CHUNK)
        start = time.perf_counter()
        scene.run(origins[chunk], directions[chunk], query=query)
        times.append(time.perf_counter() - start)
    return numpy.array(times)


def differences(scene, triangles, origins, directions, ours):
    """In words, how many rays meet another triangle than ours, at what distances."""
    theirs = scene.run(origins, directions, output=True)
    hit = theirs["primID"].astype(numpy.uint32)
    other = numpy.flatnonzero(hit != ours)
    one_misses = (hit[other] == 2**32 - 1) | (ours[other] == 2**32 - 1)
    both = other[~one_misses]
    a, b, c = triangles[ours[both]].astype(numpy.float64).transpose(1, 0, 2)
    normal = numpy.cross(b - a, c - a)
    along = [(normal * x).sum(1) for x in (a - origins[both], directions[both])]
    apart = numpy.abs(along[0] / along[1] - theirs["tfar"][both]).max(initial=0)
    return f"{one_misses.sum()} hit one only, {len(both)} other triangles at most {apart:.1e} apart"


def main():
    for file in sorted(FOLDER.glob("*.triangles")):
        name = file.stem
        triangles = read(file.name, "<f4", (-1, 3, 3))
        scene = EmbreeScene(robust=True)
        TriangleMesh(scene, triangles)
        print(f"{name}: {len(triangles)} triangles")
        for order in ("film", "none"):
            rays = read(f"{name}.{order}.rays", "<f4", (-1, 2, 3))
            origins, directions = (numpy.ascontiguousarray(rays[:, k]) for k in (0, 1))
            ours = read(f"{name}.{order}.met", "<u4", -1)
            print(f"  order: {order}: {differences(scene, triangles, origins, directions, ours)}")
            for query, words in [("INTERSECT", "nearest"), ("OCCLUDED", "occlusion")]:
                runs = [seconds(scene, origins, directions, query) for _ in range(ROUNDS)]
                best = numpy.min(runs, axis=0).sum()
                print(f"  {words + ', order: ' + order:42} {len(rays) / best / 1e6:8.2f} Mray/s")


if __name__ == "__main__":
    main()
