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

# How often a command that takes long says how far it is, seconds: on a terminal in one line.
PROGRESS_S=30
[[ ! -t 2 ]] || PROGRESS_S=1

# duration SECONDS
duration() {
    if (($1 < 100)); then
        printf '%d s\n' "$1"
    else
        printf '%d min\n' "$((($1 + 30) / 60))"
    fi
}

# progress LOG SECONDS: how far a command is. Ninja counts its steps, [12/345]; of others there is
# what they have said last.
progress() {
    local tail step done_steps all
    # What is written over a line by a carriage return, as apt does while it waits, is the last one.
    tail=$(tail -n 20 "$1" | tr '\r' '\n' | tr -d '\000-\010\013-\037\177')
    step=$(grep -oE '^\[[0-9]+/[0-9]+\]' <<<"$tail" | tail -n 1 || true)
    if [[ $step =~ ([0-9]+)/([0-9]+) ]]; then
        done_steps=$((10#${BASH_REMATCH[1]})) all=$((10#${BASH_REMATCH[2]}))
        if ((done_steps > 0 && all > done_steps)); then
            printf '%d of %d steps, %s, about %s left\n' "$done_steps" "$all" "$(duration "$2")" \
                "$(duration "$(($2 * (all - done_steps) / done_steps))")"
        else
            printf '%d of %d steps, %s\n' "$done_steps" "$all" "$(duration "$2")"
        fi
    else
        tail=$(grep -v '^[[:space:]]*$' <<<"$tail" | tail -n 1 || true)
        printf '%s%s\n' "$(duration "$2")" "${tail:+: $tail}"
    fi
}

# follow LOG: says how far a command is until standard input ends.
follow() {
    local begun=$SECONDS line columns=80
    [[ ! -t 2 ]] || columns=$(tput cols 2>/dev/null || echo 80)
    while read -r -t "$PROGRESS_S" || (($? > 128)); do
        line="  $(progress "$1" "$((SECONDS - begun))")"
        if [[ -t 2 ]]; then
            printf '\r%.*s\033[K' "$((columns - 1))" "$line" >&2
        else
            say "$line"
        fi
    done
    [[ ! -t 2 ]] || printf '\r\033[K' >&2
}

# watched LOG COMMAND...: its output goes to a file; while it runs it is said how far it is.
watched() {
    local log=$1 status=0 watch pid
    shift
    mkdir -p "$(dirname "$log")"
    : >"$log"
    exec {watch}> >(follow "$log")
    pid=$!
    "$@" >"$log" 2>&1 </dev/null {watch}>&- || status=$?
    exec {watch}>&-
    wait "$pid" || true
    return "$status"
}

# quietly LOG COMMAND...: as watched, and the output is shown when the command fails (with VERBOSE=1
# as it comes).
quietly() {
    local log=$1 status=0
    shift
    if [[ ${VERBOSE:-0} == 1 ]]; then
        "$@" >&2
        return
    fi
    watched "$log" "$@" || status=$?
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
