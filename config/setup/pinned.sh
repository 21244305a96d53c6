# Packages of Python that are pinned by their hashes, each set in a folder of its own. Sourced by
# ./terravox.
# shellcheck shell=bash

NANOBIND_DIR=$ROOT/build/deps/nanobind
NANOBIND_REQUIREMENTS=$ROOT/config/setup/python/nanobind.txt

# install_pinned FOLDER REQUIREMENTS NAMES: installs what a file of requirements pins, unless that
# is there already.
install_pinned() {
    local folder=$1 requirements=$2 names=$3 pinned part
    pinned=$(sha256sum <"$requirements")
    [[ -f $folder/.pinned && $(<"$folder/.pinned") == "$pinned" ]] && return
    say "Fetching $names"
    mkdir -p "$ROOT/build/deps" "$LOGS"
    # Installed next to its place and renamed: a folder of that name is always complete.
    part=$(mktemp -d "$folder.XXXXXX")
    if ! quietly "$LOGS/pip-${folder##*/}.log" pip_install_pinned "$part" "$requirements"; then
        rm -rf "$part"
        die "install $names: pip failed"
    fi
    printf '%s\n' "$pinned" >"$part/.pinned"
    rm -rf "$folder"
    mv "$part" "$folder"
}

# pip_install_pinned FOLDER REQUIREMENTS
pip_install_pinned() {
    python3 -m pip install --require-hashes --no-deps --only-binary :all: \
        --disable-pip-version-check --target "$1" --requirement "$2"
}

# What connects the Python package with C++; its sources are compiled with it.
install_nanobind() {
    install_pinned "$NANOBIND_DIR" "$NANOBIND_REQUIREMENTS" nanobind
}
