# Packages of the web page of the voxel server. Sourced by ./terravox after node.sh. CMake bundles
# the page itself.
# shellcheck shell=bash

PAGE_DIR=$ROOT/voxelserver/serve/page

in_page() { (cd "$PAGE_DIR" && "$@"); }

# Installs them when the lock file has changed since the last time. npm runs no scripts of packages
# (.npmrc): that of esbuild only checks what npm has installed.
install_page_packages() {
    [[ -f $PAGE_DIR/package.json ]] || return 0
    local lock stamp=$PAGE_DIR/node_modules/.terravox-lock
    lock=$(sha256sum <"$PAGE_DIR/package-lock.json")
    [[ -f $stamp && $(<"$stamp") == "$lock" ]] && return
    use_node ||
        die "install the web page's packages: Node.js $NODE_OLDEST or newer is missing;" \
            "run terravox deps"
    say "Installing the web page's packages"
    quietly "$LOGS/npm-ci-page.log" in_page npm ci --no-audit --no-fund ||
        die "install the web page's packages: npm ci failed"
    printf '%s\n' "$lock" >"$stamp"
}
