"""Rays through Embree, for comparison with `cargo bench -p relume-bake --bench rays`: triangles and rays are made by the
same rules there. One thread; the best of seven runs.

    pip install numpy embreex && taskset -c 0 python bake/benches/embree.py
"""

import time

import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

RAYS = 1 << 17
ROUNDS = 7
RANDOM = numpy.random.default_rng(5)


def field(side):
    """A height field of 2 side² triangles, [triangles, corners, 3]."""
    along = numpy.linspace(-1, 1, side + 1)
    x, z = numpy.meshgrid(along, along)
    y = 0.1 * numpy.sin(9 * x) * numpy.cos(7 * z) + 0.01 * numpy.sin(90 * x + 60 * z)
    corners = numpy.stack([x, y, z], -1).reshape(-1, 3).astype(numpy.float32)
    x, z = (index.ravel() for index in numpy.meshgrid(numpy.arange(side), numpy.arange(side)))

    def at(x, z):
        return z * (side + 1) + x

    lower = numpy.stack([at(x, z), at(x, z + 1), at(x + 1, z)], -1)
    upper = numpy.stack([at(x + 1, z), at(x, z + 1), at(x + 1, z + 1)], -1)
    return corners[numpy.concatenate([lower, upper])]


def soup(count):
    """Triangles without order, [triangles, corners, 3]."""
    middles = RANDOM.uniform(-1, 1, (count, 1, 3))
    return (middles + 0.01 * RANDOM.uniform(-1, 1, (count, 3, 3))).astype(numpy.float32)


def rays(triangles):
    """Origins and unit directions, [rays, 3] each, in a film's order and in none."""
    low, high = triangles.reshape(-1, 3).min(0), triangles.reshape(-1, 3).max(0)
    middle, half = (low + high) / 2, (high - low) / 2
    eye = middle + numpy.array([0.1, 0.7, 2.0]) * half.max() * 1.3
    side = int(RAYS**0.5)
    across, down = numpy.meshgrid(*[(numpy.arange(side) + 0.5) / side * 2 - 1] * 2)
    film = middle + numpy.stack([across, down, 0 * across], -1).reshape(-1, 3) * half - eye
    yield "a film's", numpy.broadcast_to(eye, film.shape), film
    yield "no", middle + RANDOM.uniform(-1, 1, (RAYS, 3)) * half, RANDOM.normal(size=(RAYS, 3))


def seconds(scene, origins, directions, query):
    start = time.perf_counter()
    scene.run(origins, directions, query=query)
    return time.perf_counter() - start


def main():
    for name, triangles in [("a height field", field(500)), ("triangles without order", soup(500_000))]:
        scene = EmbreeScene(robust=True)
        TriangleMesh(scene, triangles)
        print(f"{name}: {len(triangles)} triangles")
        for order, origins, directions in rays(triangles):
            directions = directions / numpy.linalg.norm(directions, axis=1, keepdims=True)
            origins, directions = (numpy.ascontiguousarray(x, numpy.float32) for x in (origins, directions))
            for query, words in [("INTERSECT", "nearest"), ("OCCLUDED", "occlusion")]:
                best = min(seconds(scene, origins, directions, query) for _ in range(ROUNDS))
                print(f"  {words + ', in ' + order + ' order':42} {len(origins) / best / 1e6:8.2f} Mray/s")


if __name__ == "__main__":
    main()
