# Builds with CMake and Ninja, one at a time. Sourced by ./terravox.
# shellcheck shell=bash

# locked FILE COMMAND...: two of them must not work in the same folder, be it with Ninja or npm.
locked() {
    local file=$1 lock status
    shift
    mkdir -p "$(dirname "$file")"
    # Not `>`: it would remove what the owner of the lock has written.
    exec {lock}>>"$file"
    if ! flock --nonblock "$lock"; then
        say "Waiting for another ./terravox (process $(<"$file"))"
        flock "$lock"
    fi
    printf '%s\n' "$$" >"$file"
    # Without `||`, which would let it go on after a failure.
    "$@"
    status=$?
    exec {lock}>&-
    return "$status"
}

configure() { (cd "$ROOT" && cmake --preset "$1" "${@:2}"); }
compile() { (cd "$ROOT" && cmake --build --preset "$1" "${@:2}"); }

# build PRESET [TARGET...]: all targets unless some are named. What is up to date does not wait for
# another build, which may take an hour. CMake looks again for libraries after packages were
# installed: those of the tests have some that the build can do without.
build() {
    if is_locked "$ROOT/build/.lock" && was_built "$@"; then
        return 0
    fi
    locked "$ROOT/build/.lock" build_alone "$@"
}

build_alone() {
    local preset=$1 targets=() begun ninja=$ROOT/build/$1/build.ninja
    shift
    (($# == 0)) || targets=(--target "$@")
    mkdir -p "$LOGS"
    if [[ ! -f $ninja || $LOGS/apt-install.log -nt $ninja ]]; then
        say "Configuring ($preset)"
        quietly "$LOGS/configure-$preset.log" configure "$preset" || return
    fi
    begun=$ROOT/build/$preset/.begun
    touch "$begun"
    if ! compile "$preset" "${targets[@]}" -- -n 2>&1 | grep -q 'no work to do'; then
        say "Building ($preset)"
        quietly "$LOGS/build-$preset.log" compile "$preset" "${targets[@]}" || return
    fi
    note_built "$begun" "$preset" "$@"
}

is_locked() { [[ -f $1 ]] && ! flock --nonblock "$1" true; }

# built_stamp PRESET [TARGET]: a file with the time since which sources may have changed
built_stamp() { printf '%s\n' "$ROOT/build/$1/.built-${2:-all}"; }

# note_built BEGUN PRESET [TARGET...]
note_built() {
    local begun=$1 preset=$2 target
    shift 2
    (($# > 0)) || set -- all
    for target in "$@"; do
        touch --reference "$begun" "$(built_stamp "$preset" "$target")"
    done
}

# was_built PRESET [TARGET...]: true when no source has changed since all of them were built.
# Without Ninja, which must not read its files while another one writes them.
was_built() {
    local preset=$1 target
    shift
    (($# > 0)) || set -- all
    for target in "$@"; do
        is_newest "$(built_stamp "$preset" "$target")" ||
            is_newest "$(built_stamp "$preset")" || return 1
    done
}

# is_newest FILE: true when it is there, and no source of C++ nor a file of the build is newer.
is_newest() {
    local files=() name
    [[ -f $1 ]] || return 1
    for name in CMakeLists.txt CMakePresets.json common config raytracer tests voxelserver; do
        [[ ! -e $ROOT/$name ]] || files+=("$ROOT/$name")
    done
    [[ -z $(find "${files[@]}" -name node_modules -prune -o -type f -newer "$1" -print -quit) ]]
}
