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

# The grabber's package.json names the oldest Node.js that it runs with; every later one will do.
start_grabber() {
    local oldest found first remedy
    oldest=$(sed -nE 's/^ *"node": ">=([0-9.]+)"$/\1/p' "$GRABBER/package.json")
    remedy="install $oldest or newer: the package nodejs of Debian 13 or newer, or one of"
    remedy+=" https://nodejs.org/en/download"
    command -v node >/dev/null || die "grab: Node.js is not installed; $remedy"
    found=$(node --version) || die "grab: $(command -v node) does not start; $remedy"
    first=$(printf '%s\n' "$oldest" "${found#v}" | sort --version-sort | head -n 1)
    [[ $first == "$oldest" ]] ||
        die "grab: $(command -v node) is Node.js ${found#v}, which is too old; $remedy"
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
