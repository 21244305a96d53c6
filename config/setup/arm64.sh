# 64-bit ARM on another processor: Terravox is compiled for it against Debian's libraries, tested in
# an emulator, and packaged (config/setup/debian.sh). Sourced by ./terravox.
# shellcheck shell=bash

# shellcheck disable=SC2153  # ROOT is of ./terravox
ARM64_PACKAGE_LIST=$ROOT/config/setup/debian-arm64-packages.txt
ARM64_ROOT=$ROOT/build/deps/arm64

# What pictures are made of, from numbers and voxels to light.
ARM64_TESTS=(
    common_test
    material_test
    raytracer_test
    scene_test
    sky_test
    solar_test
    walker_test
)

# Libraries, headers and data of the packages to build with. Compilers and generators are those of
# this machine. Of Python there are the headers: python3-dev would bring the whole of it.
arm64_packages() {
    wanted_packages "$PACKAGE_LIST" |
        grep -E '^(lib.*|.*-dev|catch2|tzdata.*)$' | grep -v '^python3-dev$'
    printf '%s\n' libc6-dev libpython3-dev
}

# arm64_apt FOLDER ARGUMENT...: apt with a state of its own, in which nothing is installed. Its
# sources and keys are those of this machine.
arm64_apt() {
    local folder=$1
    shift
    apt-get --quiet --yes --no-install-recommends \
        -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o APT::Sandbox::User= \
        -o Dir::State="$folder" -o Dir::State::status="$folder/status" -o Dir::Cache="$folder" "$@"
}

# The packages are unpacked, never installed: no script of theirs runs.
install_arm64_root() {
    local key part folder packages
    # They are fetched again when other packages are wanted, or more is done with them.
    key=$({ arm64_packages && declare -f unpack_arm64_packages record_arm64_package; } | sha256sum)
    [[ -f $ARM64_ROOT/.packages && $(<"$ARM64_ROOT/.packages") == "$key" ]] && return
    say "Fetching libraries for 64-bit ARM"
    part=$(mktemp -d "$ROOT/build/deps/arm64.XXXXXX")
    folder=$part/apt
    mkdir -p "$folder/lists/partial" "$folder/archives/partial" "$part/root"
    touch "$folder/status"
    mapfile -t packages < <(arm64_packages)
    { quietly "$LOGS/arm64-update.log" arm64_apt "$folder" update &&
        quietly "$LOGS/arm64-fetch.log" \
            arm64_apt "$folder" --download-only install "${packages[@]}"; } ||
        { rm -rf "$part" && die "fetch libraries for 64-bit ARM: apt-get failed; do its sources" \
            "offer arm64?"; }
    quietly "$LOGS/arm64-unpack.log" unpack_arm64_packages "$folder/archives" "$part/root" ||
        { rm -rf "$part" && die "unpack libraries for 64-bit ARM: failed"; }
    printf '%s\n' "$key" >"$part/root/.packages"
    rm -rf "$ARM64_ROOT"
    mv "$part/root" "$ARM64_ROOT"
    rm -rf "$part"
}

# record_arm64_package DEB ROOT: as if it were installed there, for dpkg-shlibdeps, which asks whose
# file a library is and what that package says of its versions. The paths recorded are those that
# files have once ROOT is in its place.
record_arm64_package() {
    local about=$2/var/lib/dpkg name file
    name=$(dpkg-deb --field "$1" Package)
    # Only packages of which several architectures can be installed have it in the names of files.
    [[ $(dpkg-deb --field "$1" Multi-Arch) != same ]] || name+=:arm64
    {
        dpkg-deb --field "$1"
        printf 'Status: install ok installed\n\n'
    } >>"$about/status"
    dpkg-deb --fsys-tarfile "$1" | tar --list |
        sed -nE "s,^\./((bin|lib|sbin)/),./usr/\1,; s,^\.(/.*[^/])\$,$ARM64_ROOT\1,p" \
            >"$about/info/$name.list"
    dpkg-deb --control "$1" "$2/control" || return
    for file in shlibs symbols; do
        [[ ! -f $2/control/$file ]] || mv "$2/control/$file" "$about/info/$name.$file"
    done
    rm -r "$2/control"
}

# unpack_arm64_packages ARCHIVES ROOT
unpack_arm64_packages() {
    local archives=$1 root=$2 package folder link target name
    mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" || return
    printf '1\n' >"$root/var/lib/dpkg/info/format"
    printf 'amd64\narm64\n' >"$root/var/lib/dpkg/arch"
    for package in "$archives"/*.deb; do
        dpkg-deb --extract "$package" "$root" || return
        record_arm64_package "$package" "$root" || return
    done
    # As in an installed system, where these are one folder each. Since Debian 13 packages have them
    # in usr alone, and programs still name their loader without it.
    for folder in bin lib sbin; do
        mkdir -p "$root/$folder" "$root/usr/$folder"
        cp --archive "$root/$folder/." "$root/usr/$folder" || return
        rm -rf "${root:?}/$folder" || return
        ln -s "usr/$folder" "$root/$folder" || return
    done
    # A linker would follow these on this machine.
    find "$root" -xtype l -lname '/*' -print0 | while IFS= read -r -d '' link; do
        target=$root$(readlink "$link")
        [[ -e $target ]] || continue
        ln -sfn "$(realpath --relative-to "$(dirname "$link")" "$target")" "$link"
    done
    # What scripts of these packages would choose among several.
    for name in blas lapack; do
        ln -s "$name/lib$name.so.3" "$root/usr/lib/aarch64-linux-gnu/lib$name.so.3" || return
    done
    mkdir "$root/linker" || return
    ln -s "$(command -v ld.lld)" "$root/linker/ld.lld"
}

# What packages are made of, for 64-bit ARM.
build_arm64_packaged() {
    install_packages "$ARM64_PACKAGE_LIST"
    install_arm64_root
    build arm64 terravox_packaged
}

in_arm64() { qemu-aarch64-static -L "$ARM64_ROOT" "$@"; }

# The demo's survey becomes the same voxels, and these the same picture, to the last bit.
compare_arm64_pictures() {
    local survey out=$ROOT/build/arm64/pictures made
    survey=$(demo_survey)
    rm -rf "$out"
    mkdir -p "$out"
    made=(--scene "$DEMO_SCENE" --size 320x180 "$survey")
    "$ROOT/build/release/bin/terravox-raytracer" render "${made[@]}" -o "$out/here.exr"
    in_arm64 "$ROOT/build/arm64/bin/terravox-raytracer" render "${made[@]}" -o "$out/arm64.exr"
    "$ROOT/build/release/bin/compare_pictures" --exact "$out/here.exr" "$out/arm64.exr"
}

# run_arm64 [TEST...]
run_arm64() {
    local tests=("$@") pattern failed=()
    ((${#tests[@]} > 0)) || tests=("${ARM64_TESTS[@]}")
    set_up
    install_packages "$ARM64_PACKAGE_LIST"
    install_arm64_root
    build arm64 "${tests[@]}" terravox-raytracer
    build release terravox-raytracer terravox-survey compare_pictures
    pattern=$(IFS='|' && echo "^(${tests[*]})\$")
    (cd "$ROOT" && ctest --preset arm64 --parallel "$(nproc)" --no-tests=error \
        --tests-regex "$pattern") || failed+=("tests")
    compare_arm64_pictures || failed+=("the demo's picture")
    ((${#failed[@]} == 0)) || die "test --arm64: failed: ${failed[*]}"
}
