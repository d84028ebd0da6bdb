"""A second opinion on environment maps: width, height and mean of each channel, by OpenEXR or by an RGBE reader of our own."""

import numpy as np
import OpenEXR

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def read(path):
    """`size`, `means` (each of them right) and `features`."""
    return read_hdr(path) if path.endswith(".hdr") else read_exr(path)


def read_exr(path):
    """In the display window, in Rec. 709 with a white that stays white, then without negative values."""
    image, header = exr_pixels(path)
    features = []
    negative = (image < 0).any(-1).sum()
    if negative:
        more = 100 * (np.maximum(image, 0).mean() / image.mean() - 1)
        features.append(f"{negative} texels below 0, down to {image.min():.3g}; clipping them adds {more:.2f} % to the mean")
    chromaticities = header.get("chromaticities")
    if chromaticities is not None:
        image = image @ to_rec_709(chromaticities).T
        features.append("chromaticities with white {:.4f} {:.4f}".format(*chromaticities[6:8]))
    return dict(size=[image.shape[1], image.shape[0]], means=[np.maximum(image, 0).mean((0, 1)).tolist()], features=features)


def exr_pixels(path):
    with OpenEXR.File(path, separate_channels=True) as file:
        header, channels = dict(file.parts[0].header), file.parts[0].channels
        stored = np.stack([np.asarray(channels[name].pixels, float) for name in "RGB"], -1)
    (x0, y0), (x1, y1) = header["dataWindow"]
    (u0, v0), (u1, v1) = header["displayWindow"]
    left, right, top, bottom = max(x0, u0), min(x1, u1) + 1, max(y0, v0), min(y1, v1) + 1
    image = np.zeros((v1 - v0 + 1, u1 - u0 + 1, 3))
    image[top - v0 : bottom - v0, left - u0 : right - u0] = stored[top - y0 : bottom - y0, left - x0 : right - x0]
    return np.where(np.isfinite(image), image, 0), header


def xyz_from_rgb(chromaticities):
    xyz = np.array([[x / y, 1, (1 - x - y) / y] for x, y in np.reshape(chromaticities, (4, 2))])
    return xyz[:3].T * np.linalg.solve(xyz[:3].T, xyz[3]), xyz[3]


def to_rec_709(chromaticities):
    (mine, white), (rec_709, d65) = xyz_from_rgb(chromaticities), xyz_from_rgb(REC_709)
    adapt = np.linalg.inv(BRADFORD) @ np.diag((BRADFORD @ d65) / (BRADFORD @ white)) @ BRADFORD
    return np.linalg.inv(rec_709) @ adapt @ mine


def read_hdr(path):
    """Radiance, run-length encoded or not, the axes in the usual order. Readers differ in whether a mantissa stands for the middle of its step."""
    data = open(path, "rb").read()
    start = data.index(b"\n\n") + 2
    at = data.index(b"\n", start) + 1
    _, height, _, width = data[start:at].split()
    height, width = int(height), int(width)
    image = np.zeros((height, 4, width), np.uint8)
    for row in image:
        if data[at : at + 2] != b"\x02\x02":
            row[:] = np.frombuffer(data, np.uint8, 4 * width, at).reshape(width, 4).T
            at += 4 * width
            continue
        at += 4
        for channel in row:
            at = run_lengths(data, at, channel)
    scale = np.ldexp(1.0, image[:, 3].astype(int) - 136) * (image[:, 3] > 0)
    means = [[float(((image[:, k] + middle) * scale).mean()) for k in range(3)] for middle in (0.5, 0.0)]
    return dict(size=[width, height], means=means, features=[])


def run_lengths(data, at, channel):
    x = 0
    while x < len(channel):
        n = data[at]
        if n > 128:
            channel[x : x + n - 128] = data[at + 1]
            x, at = x + n - 128, at + 2
        else:
            channel[x : x + n] = np.frombuffer(data, np.uint8, n, at + 1)
            x, at = x + n, at + 1 + n
    return at
