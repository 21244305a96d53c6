#!/usr/bin/env bash
# The commands of an installed Terravox: bin/terravox of the prefix. Programs and data are found
# relative to this file, so that a prefix can be moved.
set -euo pipefail
shopt -s inherit_errexit

PREFIX=$(cd -P "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
PROGRAMS=$PREFIX/lib/terravox
COMMANDS_FILE=$PREFIX/share/terravox/setup/commands.txt
GRABBER=$PROGRAMS/grabber
# shellcheck disable=SC2034
OWN_COMMANDS=(help)

# shellcheck source=config/setup/say.sh
. "$PREFIX/share/terravox/setup/say.sh"
# shellcheck source=config/setup/commands.sh
. "$PREFIX/share/terravox/setup/commands.sh"

show_help() {
    cat <<'TEXT'
Terravox: real places as ray-traced voxel landscapes.

Usage: terravox COMMAND [arguments]     (terravox help COMMAND explains one)

TEXT
    list_commands
    printf '  %s\n\n' 'help [COMMAND], --version'
    list_environment
}

# The grabber has a compiled part, which one ABI of Node.js loads.
start_grabber() {
    local wanted found
    wanted=$(<"$GRABBER/node-abi")
    command -v node >/dev/null ||
        die "grab: Node.js is missing; install one whose modules have version $wanted"
    found=$(node -p process.versions.modules)
    [[ $found == "$wanted" ]] ||
        die "grab: $(command -v node) has modules of version $found; this package wants $wanted" \
            "(20: 115, 22: 127, 24: 137)"
    exec node "$GRABBER/dist/main.js" "$@"
}

# start PROGRAM [ARGUMENT...]: in the user's current folder, in place of this script.
start() {
    if [[ $1 == grabber ]]; then
        start_grabber "${@:2}"
    fi
    [[ -x $PROGRAMS/$1 ]] ||
        die "run $1: it is not in $PROGRAMS; the window comes with the package terravox-preview" \
            "(component preview), all other programs with terravox (component programs)"
    exec "$PROGRAMS/$1" "${@:2}"
}

if (($# == 0)); then
    # shellcheck disable=SC2119 # no lines of its own
    show_start
    exit
fi
command=$1
shift
case $command in
    help) run_help "$@" ;;
    -h | --help) show_help ;;
    --version | version) start terravox-raytracer --version ;;
    *) run_command "$command" "$@" ;;
esac
