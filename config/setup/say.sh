# Messages and quiet commands, for ./terravox and the other scripts here. Sourced, never run.
# Everything goes to standard error: standard output belongs to the program that is run in the end.
# shellcheck shell=bash

say() { printf '%s\n' "$*" >&2; }

die() {
    say "terravox: $*"
    exit 1
}

usage_error() {
    say "terravox: $*"
    exit 2
}

# quietly LOG COMMAND...: its output goes to a file, and is shown only when the command fails (or
# with VERBOSE=1).
quietly() {
    local log=$1 status=0
    shift
    if [[ ${VERBOSE:-0} == 1 ]]; then
        "$@" >&2
        return
    fi
    mkdir -p "$(dirname "$log")"
    "$@" >"$log" 2>&1 </dev/null || status=$?
    ((status == 0)) && return
    tail -n 60 "$log" >&2
    say "terravox: failed with exit code $status: $*"
    say "terravox: the whole output is in $log"
    return "$status"
}

# check_sha256 FILE SUM: true when the file exists and is complete.
check_sha256() { [[ -f $1 ]] && printf '%s  %s\n' "$2" "$1" | sha256sum --check --status -; }

# fetch_from_pypi FILE SUM [pip options] NAME==VERSION: downloads FILE into the cache folder, unless
# it is there already; prints its path. pip gets name and version of a source archive from its build
# backend, and would fetch and run the newest version of that backend with all that it requires.
# config/setup/python/no_build replaces it with one that only reads them.
fetch_from_pypi() {
    local cache=${XDG_CACHE_HOME:-$HOME/.cache}/terravox file sum=$2 part wanted=${*: -1}
    file=$cache/$1
    if ! check_sha256 "$file" "$sum"; then
        python3 -m pip --version >/dev/null 2>&1 ||
            die "download $wanted: Python's pip is missing; install python3-pip"
        mkdir -p "$cache"
        part=$(mktemp -d "$cache/download.XXXXXX")
        printf '%s --hash=sha256:%s\n' "$wanted" "$sum" >"$part/requirements.txt"
        if ! PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$ROOT/config/setup/python/no_build \
            quietly "$LOGS/pip.log" \
            python3 -m pip download --require-hashes --no-deps --no-build-isolation \
            --disable-pip-version-check --dest "$part" \
            "${@:3:$#-3}" --requirement "$part/requirements.txt"; then
            rm -rf "$part"
            die "download $wanted: pip failed"
        fi
        if ! check_sha256 "$part/${file##*/}" "$sum"; then
            rm -rf "$part"
            die "download $wanted: ${file##*/} is missing or has another SHA-256 than $sum"
        fi
        mv -f "$part/${file##*/}" "$file"
        rm -rf "$part"
    fi
    printf '%s\n' "$file"
}
