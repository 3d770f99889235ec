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
fetch argos "${ARGOS_GIT:-https://github.com/ilpincy/argos3.git}" \
    421bd7630f895098b2ec60408edbb86991ff04b5 \
    src/core src/plugins/simulator/entities src/plugins/simulator/media src/plugins/simulator/physics_engines \
    src/plugins/simulator/visualizations src/plugins/robots/generic src/plugins/robots/e-puck

# build NAME FLAGS -- FILE... -- LIBRARY...: target/peers/bin/NAME, made anew where its driver or the flags changed.
build() {
    local name=$1 flags=() files=("$here/$1.cpp") libraries=() stamp file
    shift
    while [ "$1" != -- ]; do flags+=("$1"); shift; done
    shift
    while [ "$1" != -- ]; do files+=("$1"); shift; done
    shift
    libraries=("$@")
    stamp=$(echo "$CXX $CXXFLAGS ${flags[*]} ${files[*]} ${libraries[*]}" |
        cat - "$here/$name.cpp" "$here/common.h" "$out/$name/.commit" | sha256sum)
    [ "$(cat "$out/bin/$name.stamp" 2>/dev/null)" = "$stamp" ] && return
    echo "building $name" >&2
    rm -rf "$out/objects/$name"
    mkdir -p "$out/objects/$name"
    for file in "${files[@]}"; do
        local object
        object="$out/objects/$name/$(echo "${file#"$root"/}" | tr / -).o"
        # shellcheck disable=SC2086
        case $file in
            *.c) printf '%s\0' "${CC:-gcc} -std=gnu99 -w $CXXFLAGS ${flags[*]} -c $file -o $object" ;;
            *) printf '%s\0' "$CXX -std=c++17 -w $CXXFLAGS -I$here ${flags[*]} -c $file -o $object" ;;
        esac
    done | xargs -0 -P "$(nproc)" -I{} sh -c {}
    "$CXX" "$out/objects/$name"/*.o "${libraries[@]}" -o "$out/bin/$name"
    echo "$stamp" >"$out/bin/$name.stamp"
}

r="$out/roborobo4"
files=()
for file in "$r"/src/core/*.cpp "$r"/src/contrib/zsu/*.cpp; do
    [ "$(basename "$file")" = main.cpp ] || files+=("$file")
done
for name in ConfigurationLoader EnergyItem GateObject LandmarkObject MovableObject PhysicalObjectFactory RoundObject SwitchObject; do
    files+=("$r/src/ext/$name.cpp")
done
# shellcheck disable=SC2046
build roborobo4 -DMODULAR -I"$r/include" -I"$r/include/contrib" -I"$r/include/core" -I"$r/include/ext" -I"$r/prj" \
    $(sdl2-config --cflags) -- "${files[@]}" -- $(sdl2-config --libs) -lSDL2_image
f="$out/libfastsim/src"
build libfastsim -I"$f" -- "$f"/{laser,map,robot,radar,light_sensor,linear_camera}.cpp --
e="$out/enki"
build enki -I"$e" -- "$e"/enki/*.cpp "$e"/enki/interactions/*.cpp "$e"/enki/robots/DifferentialWheeled.cpp \
    "$e"/enki/robots/e-puck/EPuck.cpp --
a="$out/argos"
ln -sfn src "$a/argos3"
cat >"$a/src/core/config.h" <<'CONFIG'
// As its CMake makes it for the simulator, without Lua, Qt and images.
#define ARGOS_VERSION "3"
#define ARGOS_RELEASE "421bd76"
#define ARGOS_BUILD_FOR "simulator"
#define ARGOS_DYNAMIC_LIBRARY_LOADING
#define ARGOS_SHARED_LIBRARY_EXTENSION "so"
#define ARGOS_MODULE_LIBRARY_EXTENSION "so"
#define ARGOS_INSTALL_PREFIX "/usr/local"
#define ARGOS_USE_DOUBLE
#define ARGOS_THREADSAFE_LOG
#define ARGOS_BUILD_FLAGS ""
CONFIG
files=()
while IFS= read -r file; do
    files+=("$file")
done < <(find "$a"/src/core "$a"/src/plugins/simulator/{entities,media,physics_engines/dynamics2d} \
    "$a"/src/plugins/robots/{generic,e-puck} \( -name '*.cpp' -o -name '*.c' \) |
    grep -vE 'core/simulator/main.cpp|wrappers/lua|real_robot|qtopengl|dynamics3d' | sort)
# Two of its libraries have a constant of one name and value.
build argos -DARGOS_simulator_BUILD -I"$a" -I"$a/argos3/plugins/simulator/physics_engines/dynamics2d/chipmunk-physics/include" \
    -- "${files[@]}" -- -ldl -lpthread -rdynamic -Wl,--allow-multiple-definition

# OURS and OURS_CHECK may name binaries that are built already.
if [ -z "${OURS:-}" ] || [ -z "${OURS_CHECK:-}" ]; then
    (cd "$root" && cargo build --quiet --release -p loadtests --bins --example peers_check)
    target="${CARGO_TARGET_DIR:-$root/target}/release"
    OURS=${OURS:-$target/loadtests}
    OURS_CHECK=${OURS_CHECK:-$target/examples/peers_check}
fi
CXX="$CXX" CXXFLAGS="$CXXFLAGS" exec python3 "$here/measure.py" --bin "$out/bin" --sources "$out" \
    --scratch "$out/scratch" --worlds "$here/../worlds" --ours "$OURS" --ours-check "$OURS_CHECK" "$@"
