#!/usr/bin/env bash
# Fetches other simulators at fixed commits, builds them and evswarm, and measures them in turns.
# Arguments go to measure.py (--rounds, --only, --robots, --check); README.md beside this file says more.
set -euo pipefail

here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
out="$root/target/peers"
CXX=${CXX:-g++}
CXXFLAGS=${CXXFLAGS:--O3 -DNDEBUG}
mkdir -p "$out/bin" "$out/scratch"

missing=()
for tool in git python3 "$CXX" sdl2-config; do
    command -v "$tool" >/dev/null || missing+=("$tool")
done
if [ ${#missing[@]} -gt 0 ]; then
    echo "not found: ${missing[*]} (Debian: apt-get install git python3 g++ libsdl2-dev libsdl2-image-dev libboost-dev)" >&2
    exit 1
fi

# fetch NAME URL COMMIT PATH...: the paths at that commit, below target/peers/NAME.
fetch() {
    local name=$1 url=$2 commit=$3
    shift 3
    local source="$out/$name"
    [ "$(cat "$source/.commit" 2>/dev/null)" = "$commit" ] && return
    echo "fetching $name $commit" >&2
    rm -rf "$source" "$source.git"
    git clone --quiet --bare "$url" "$source.git"
    mkdir -p "$source"
    git --git-dir="$source.git" archive "$commit" "$@" | tar -x -C "$source"
    rm -rf "$source.git"
    echo "$commit" >"$source/.commit"
}

fetch roborobo4 "${ROBOROBO4_GIT:-https://github.com/nekonaute/roborobo4.git}" \
    ae758c327228f612d044a54ee00d33ee1c469ee1 \
    src include prj config/benchmark.properties \
    data/minirobot-mask-edgesOnly.bmp data/minirobot-specs-8sensors.bmp \
    data/robot15-mask.bmp data/robot15-specs-8sensors.bmp
fetch libfastsim "${LIBFASTSIM_GIT:-https://github.com/sferes2/libfastsim.git}" \
    bc1cc8ab7a9297d7631424214fcacda8525fcb8a src
fetch enki "${ENKI_GIT:-https://github.com/enki-community/enki.git}" \
    bb486bfb1ea6c038b3eaad847dda91abe363cc5d enki

# build NAME FLAGS... FILES...: target/peers/bin/NAME, made anew where its driver or the flags changed.
build() {
    local name=$1
    shift
    local stamp
    stamp=$(echo "$CXX $CXXFLAGS $*" | cat - "$here/$name.cpp" "$here/common.h" "$out/$name/.commit" | sha256sum)
    [ "$(cat "$out/bin/$name.stamp" 2>/dev/null)" = "$stamp" ] && return
    echo "building $name" >&2
    # shellcheck disable=SC2086
    "$CXX" -std=c++17 -w $CXXFLAGS -I"$here" "$here/$name.cpp" "$@" -o "$out/bin/$name"
    echo "$stamp" >"$out/bin/$name.stamp"
}

r="$out/roborobo4"
objects=()
for name in ConfigurationLoader EnergyItem GateObject LandmarkObject MovableObject PhysicalObjectFactory RoundObject SwitchObject; do
    objects+=("$r/src/ext/$name.cpp")
done
core=()
for file in "$r"/src/core/*.cpp "$r"/src/contrib/zsu/*.cpp; do
    [ "$(basename "$file")" = main.cpp ] || core+=("$file")
done
# shellcheck disable=SC2046
build roborobo4 -DMODULAR -I"$r/include" -I"$r/include/contrib" -I"$r/include/core" -I"$r/include/ext" -I"$r/prj" \
    $(sdl2-config --cflags) "${core[@]}" "${objects[@]}" $(sdl2-config --libs) -lSDL2_image
f="$out/libfastsim/src"
build libfastsim -I"$f" "$f"/{laser,map,robot,radar,light_sensor,linear_camera}.cpp
e="$out/enki"
build enki -I"$e" "$e"/enki/*.cpp "$e"/enki/interactions/*.cpp "$e"/enki/robots/DifferentialWheeled.cpp \
    "$e"/enki/robots/e-puck/EPuck.cpp

# OURS and OURS_CHECK may name binaries that are built already.
if [ -z "${OURS:-}" ] || [ -z "${OURS_CHECK:-}" ]; then
    (cd "$root" && cargo build --quiet --release -p loadtests --bins --example peers_check)
    target="${CARGO_TARGET_DIR:-$root/target}/release"
    OURS=${OURS:-$target/loadtests}
    OURS_CHECK=${OURS_CHECK:-$target/examples/peers_check}
fi
CXX="$CXX" CXXFLAGS="$CXXFLAGS" exec python3 "$here/measure.py" --bin "$out/bin" --sources "$out" \
    --scratch "$out/scratch" --worlds "$here/../worlds" --ours "$OURS" --ours-check "$OURS_CHECK" "$@"
