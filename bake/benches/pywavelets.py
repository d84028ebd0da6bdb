"""Times PyWavelets on the work of the group `rows of 6x64x64` of haar.rs, for a comparison on one machine.

    pip install pywavelets numpy
    python3 bake/benches/pywavelets.py
"""

import time

import numpy
import pywt

ROWS, SIDE = 171, 64


def best(work, repetitions=10):
    """The shortest time of some, in seconds."""

    def timed():
        start = time.perf_counter()
        work()
        return time.perf_counter() - start

    return min(timed() for _ in range(repetitions))


cubes = numpy.random.default_rng(1).random((ROWS, 6, SIDE, SIDE), dtype=numpy.float32)


def forward():
    return pywt.wavedec2(cubes, "haar", mode="periodization", axes=(-2, -1))


coefficients = forward()
assert all(c.dtype == numpy.float32 for level in coefficients[1:] for c in level)
energy = sum(float((numpy.asarray(c, dtype=float) ** 2).sum()) for c in [coefficients[0], *(c for l in coefficients[1:] for c in l)])
assert abs(energy / float((cubes.astype(float) ** 2).sum()) - 1) < 1e-5, "the same orthonormal transform"

print(f"PyWavelets {pywt.__version__}, {ROWS} rows of 6x{SIDE}x{SIDE} f32")
for name, seconds in [
    ("forward, all rows at once", best(forward)),
    ("forward, face by face", best(lambda: [pywt.wavedec2(face, "haar", mode="periodization") for face in cubes.reshape(-1, SIDE, SIDE)], 3)),
    ("inverse, all rows at once", best(lambda: pywt.waverec2(coefficients, "haar", mode="periodization", axes=(-2, -1)))),
]:
    print(f"{name:28} {cubes.nbytes / 1e6 / seconds:8.0f} MB/s")
