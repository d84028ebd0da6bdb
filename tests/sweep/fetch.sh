#!/bin/sh
# Fetches the packages of packages.txt with the ordinary package clients and unpacks what they hold of models, maps and textures into
# target/sweep/packages/REGISTRY/PACKAGE; makes target/sweep/venv with the readers they are compared with. Nothing of a package is installed.
# Run from anywhere. What is already there in the right version is left alone.
set -eu

cd "$(dirname "$0")/../.."
list=tests/sweep/packages.txt
root=$PWD/target/sweep
kept='.*\.(gltf|glb|obj|mtl|ply|off|hdr|exr|bin|png|jpg|jpeg|tga|bmp)'

fail() {
    echo "error: $*" >&2
    exit 1
}

for client in python3 npm cargo apt-get dpkg-deb unzip; do
    command -v $client >/dev/null || fail "$client is missing; on Debian or Ubuntu: apt-get install python3-venv npm unzip"
done
mkdir -p "$root"
scratch=$(mktemp -d "$root/fetch-XXXXXX")
trap 'rm -rf "$scratch"' EXIT
trap 'exit 130' INT TERM

if ! cmp -s tests/sweep/requirements.txt "$root/venv/requirements.txt"; then
    echo "venv: installing trimesh and OpenEXR"
    python3 -m venv --clear "$root/venv" && "$root/venv/bin/pip" install -q -r tests/sweep/requirements.txt || fail "pip could not install tests/sweep/requirements.txt; Python 3.11 or newer is needed"
    cp tests/sweep/requirements.txt "$root/venv/requirements.txt"
fi

# Each fetch_REGISTRY PACKAGE VERSION fills $scratch/files with what the package holds.
fetch_apt() {
    (cd "$scratch" && apt-get download -q "$1=$2" >/dev/null 2>&1) || fail "apt-get could not fetch $1=$2; run apt-get update, or use Debian 12"
    dpkg-deb -x "$scratch"/*.deb "$scratch/files"
}
fetch_cargo() {
    # Shows the crate, for which cargo puts it into its cache; what it depends on stays away.
    cargo info -q "$1@$2" >/dev/null 2>&1 || fail "cargo could not fetch $1@$2; try again"
    tar -xzf "${CARGO_HOME:-$HOME/.cargo}"/registry/cache/*/"$1-$2.crate" -C "$scratch/files" --strip-components=1
}
fetch_npm() {
    (cd "$scratch" && npm pack --ignore-scripts --loglevel error "$1@$2" >/dev/null) || fail "npm could not fetch $1@$2; try again"
    tar -xzf "$scratch"/*.tgz -C "$scratch/files" --strip-components=1
}
fetch_pip() { # wheels for Python 3.11, whatever Python is here
    "$root/venv/bin/pip" download -q --no-deps -d "$scratch" --only-binary :all: --implementation cp --python-version 3.11 \
        --platform manylinux_2_35_x86_64 --platform manylinux_2_28_x86_64 "$1==$2" || fail "pip could not fetch $1==$2; try again"
    unzip -q "$scratch"/*.whl -d "$scratch/files"
}
fetch_pip_source() {
    "$root/venv/bin/pip" download -q --no-deps -d "$scratch" --no-binary "$1" "$1==$2" || fail "pip could not fetch the source of $1==$2; try again"
    tar -xzf "$scratch"/*.tar.gz -C "$scratch/files" --strip-components=1
}

# Some packages hold their models packed once more: archives, files compressed with gzip, maps as base64 in scripts.
unpack_inner() {
    find "$1" -name data.tar.gz -exec tar -xzf {} -C "$1" \;
    find "$1" -regextype posix-extended -iregex "$kept\.gz" -exec gunzip -f {} +
    find "$1" -name '*.exr.js' -exec python3 -c '
import base64, re, sys
for path in sys.argv[1:]:
    open(path[:-3], "wb").write(base64.b64decode(re.search(r"base64,([A-Za-z0-9+/=]+)", open(path).read())[1]))' {} +
    find "$1" -type l -delete
    find "$1" -regextype posix-extended -type f ! -iregex "$kept" -delete
    find "$1" -type d -empty -delete
}

while read -r registry package version; do
    case $registry in '' | '#'*) continue ;; esac
    place=$root/packages/${registry%-source}/$(echo "$package" | tr -d @ | tr / -)
    [ "$(cat "$place/.version" 2>/dev/null)" != "$version" ] || continue
    echo "$package $version: fetching with $registry"
    rm -rf "$scratch" "$place" && mkdir -p "$scratch/files" "${place%/*}"
    case $registry in
        apt | cargo | npm | pip) "fetch_$registry" "$package" "$version" </dev/null ;;
        pip-source) fetch_pip_source "$package" "$version" </dev/null ;;
        *) fail "$list: unknown registry $registry; apt, cargo, npm, pip and pip-source are known" ;;
    esac
    unpack_inner "$scratch/files"
    echo "$version" >"$scratch/files/.version"
    mv "$scratch/files" "$place"
done <"$list"
