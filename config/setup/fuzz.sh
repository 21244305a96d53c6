# Fuzz targets (tests/fuzz): builds them, makes their corpora, and runs each for some seconds.
# Sourced by ./terravox.
# shellcheck shell=bash

FUZZ_PACKAGE_LIST=$ROOT/config/setup/debian-fuzz-packages.txt
FUZZ_DIR=$ROOT/build/fuzz
FUZZ_DATA=$ROOT/../shared/data

# NAME LONGEST-INPUT-BYTES DICTIONARY: what tests/fuzz/NAME.cpp is run with. Dictionary -: none.
FUZZ_TARGETS=(
    "animation 4096 toml"
    "archive 16384 -"
    "batch 16384 -"
    "box 16384 -"
    "checkpoint 65536 -"
    "crs 8192 wkt"
    "frames 32768 -"
    "geojson 65536 geojson"
    "handshake 256 -"
    "http 2048 http"
    "jobs 4096 jobs"
    "las 65536 las"
    "lax 8192 las"
    "map_block 65536 -"
    "materials 16384 toml"
    "nbt 65536 nbt"
    "ply 16384 ply"
    "raster 65536 tiff"
    "region 65536 nbt"
    "scene 8192 toml"
    "settings 16384 toml"
    "tile 16384 -"
    "toml 8192 toml"
    "worker_config 4096 toml"
    "world_json 4096 -"
    "zip 65536 -"
)
# The grabber's own targets, in TypeScript.
FUZZ_GRABBER=grabber

# An input of a few KiB that makes a reader take this much memory at once, or in all, is a find, as
# is one that takes so long. The time is far from what any input needs: a busy machine is no find.
FUZZ_MALLOC_MB=320
FUZZ_RSS_MB=2048
FUZZ_TIMEOUT_S=120

# Of each target, in `./terravox test --all`.
# shellcheck disable=SC2034  # used by ./terravox
FUZZ_SHORT_S=20

# As in the test presets: what a sanitizer finds ends the run.
FUZZ_ASAN=detect_leaks=1:strict_string_checks=1
FUZZ_UBSAN=halt_on_error=1:print_stacktrace=1

fuzz_help() {
    cat <<'TEXT'
Runs the fuzz targets (tests/fuzz): readers of untrusted files and messages, on inputs that
libFuzzer generates.

Usage: terravox fuzz [--seconds N] [--jobs N] [-v] [NAME...]
       terravox fuzz --list

  NAME         which; all when none is named
  --seconds N  how long each runs, 1 to 999999 [60]
  --jobs N     how many run at a time, 1 to 64 [1]
  --list       lists the names with what they read

Corpora are kept in build/fuzz/corpus and grow from run to run. Finds, inputs with which something
is wrong, are left in build/fuzz/finds; then the exit code is 1. TERRAVOX_NO_BUILD=1 runs the
targets as they were built last.
TEXT
}

fuzz_names() { printf '%s\n' "${FUZZ_TARGETS[@]%% *}" "$FUZZ_GRABBER"; }

# The first line of a target's source: "// What it reads."
fuzz_list() {
    local name
    for name in "${FUZZ_TARGETS[@]%% *}"; do
        printf '%-14s %s\n' "$name" "$(sed -n '1s,^// ,,p' "$ROOT/tests/fuzz/$name.cpp")"
    done
    printf '%-14s %s\n' "$FUZZ_GRABBER" "The grabber's readers (TypeScript)."
}

# fuzz_data NAME LONGEST-INPUT-BYTES: real files for a target from next to the checkout, one a line;
# none where there are none.
fuzz_data() {
    local patterns=()
    case $1 in
        crs) patterns=(-iname '*.wkt' -o -iname '*.prj') ;;
        geojson) patterns=(-iname '*.geojson') ;;
        las) patterns=(-iname '*.las' -o -iname '*.laz') ;;
        lax) patterns=(-iname '*.lax') ;;
        ply) patterns=(-iname '*.ply') ;;
        nbt) patterns=(-iname '*.dat' -o -iname '*.nbt' -o -iname '*.chunk') ;;
        region) patterns=(-iname '*.mca' -o -iname '*.mcr') ;;
        *) return ;;
    esac
    [[ -d $FUZZ_DATA ]] || return 0
    find "$FUZZ_DATA" -type f -size -"$2"c \( "${patterns[@]}" \) -print
}

# fuzz_makers NAME...: the programs that make what the corpora of these targets begin with.
fuzz_makers() {
    local name
    printf 'fuzz-file-corpora\n'
    for name in "$@"; do
        if in_list "$name" checkpoint frames scene tile; then
            printf 'fuzz-picture-corpora\n'
            return
        fi
    done
}

# fuzz_seeds MAKER...: the inputs that the corpora begin with: written anew by the project's own
# writers, and real files, each under its hash.
fuzz_seeds() {
    local maker entry name longest dictionary file
    rm -rf "$FUZZ_DIR/seeds"
    for maker in "$@"; do
        quietly "$LOGS/fuzz-seeds.log" "$FUZZ_DIR/targets/$maker" "$FUZZ_DIR/seeds" ||
            die "fuzz: the corpora could not be made"
    done
    for entry in "${FUZZ_TARGETS[@]}"; do
        read -r name longest dictionary <<<"$entry"
        mkdir -p "$FUZZ_DIR/seeds/$name"
        while read -r file; do
            cp "$file" "$FUZZ_DIR/seeds/$name/$(sha256sum "$file" | cut -c 1-16)"
        done < <(fuzz_data "$name" "$longest")
    done
}

# fuzz_field LOG WORD: the last number behind a word of libFuzzer's log; 0 where there is none.
fuzz_field() {
    { grep -aoE "$2: *[0-9]+" "$1" || echo 0; } | tail -n 1 | grep -oE '[0-9]+$'
}

# fuzz_run NAME SECONDS: prints its line of the table; returns 1 when something was found.
fuzz_run() {
    local name=$1 seconds=$2 entry longest dictionary options=() status=0
    local finds executions scratch said repeat
    local program=$FUZZ_DIR/targets/fuzz-$1 seeds=$FUZZ_DIR/seeds/$1 log=$LOGS/fuzz-$1.log
    local corpus=$FUZZ_DIR/corpus/$1 found=$FUZZ_DIR/finds/$1
    for entry in "${FUZZ_TARGETS[@]}"; do
        [[ $entry != "$name "* ]] || read -r _ longest dictionary <<<"$entry"
    done
    [[ $dictionary == - ]] || options=("-dict=$ROOT/tests/fuzz/dictionaries/$dictionary.dict")
    [[ -x $program ]] || die "fuzz: $program was never built"
    mkdir -p "$corpus" "$found" "$LOGS"
    options+=(-max_total_time="$seconds" -max_len="$longest" -timeout="$FUZZ_TIMEOUT_S")
    options+=(-malloc_limit_mb="$FUZZ_MALLOC_MB" -rss_limit_mb="$FUZZ_RSS_MB")
    options+=(-print_final_stats=1 -artifact_prefix="$found/")
    # What a target that was ended leaves in its temporary folder goes with it.
    scratch=$(mktemp -d)
    TMPDIR=$scratch ASAN_OPTIONS=$FUZZ_ASAN UBSAN_OPTIONS=$FUZZ_UBSAN \
        "$program" "${options[@]}" "$corpus" "$seeds" >"$log" 2>&1 </dev/null || status=$?
    rm -rf "$scratch"
    finds=$((status == 0 ? 0 : 1))  # libFuzzer ends with the first
    executions=$(fuzz_field "$log" stat::number_of_executed_units)
    printf '%-14s %14s %10s %8s %6s\n' "$name" "$executions" "$(fuzz_field "$log" cov)" \
        "$(find "$corpus" -type f | wc -l)" "$finds"
    ((status == 0)) && return
    repeat=$(sed -nE 's/.*Test unit written to (.*)/\1/p' "$log" | tail -n 1)
    said=$(grep -am 1 -E 'ERROR: |runtime error|not true: ' "$log" || echo "exit code $status")
    say "fuzz $name: $said"
    say "fuzz $name: the whole report is in $log; again with:"
    say "  ASAN_OPTIONS=$FUZZ_ASAN UBSAN_OPTIONS=$FUZZ_UBSAN $program $repeat"
    return 1
}

# fuzz_targets SECONDS JOBS NAME...: returns 1 when something was found.
fuzz_targets() {
    local seconds=$1 jobs=$2 name failed=0 running=0 grabber=0 names=() makers
    shift 2
    for name in "$@"; do
        if [[ $name == "$FUZZ_GRABBER" ]]; then grabber=1; else names+=("$name"); fi
    done
    if ((${#names[@]} > 0)); then
        mapfile -t makers < <(fuzz_makers "${names[@]}")
        if [[ ${TERRAVOX_NO_BUILD:-0} != 1 ]]; then
            set_up
            install_packages "$FUZZ_PACKAGE_LIST"
            build fuzz "${names[@]/#/fuzz-}" "${makers[@]}" || return
        fi
        fuzz_seeds "${makers[@]}"
        printf '%-14s %14s %10s %8s %6s\n' target executions edges corpus finds
        for name in "${names[@]}"; do
            if ((running == jobs)); then
                wait -n || failed=1
                running=$((running - 1))
            fi
            fuzz_run "$name" "$seconds" &
            running=$((running + 1))
        done
        for (( ; running > 0; --running)); do wait -n || failed=1; done
    fi
    if ((grabber == 1)); then
        use_node || die "fuzz: Node.js $NODE_OLDEST or newer is missing; run terravox deps"
        in_grabber npm run fuzz -- --seconds "$seconds" --jobs "$jobs" || failed=1
    fi
    return "$failed"
}

fuzz() {
    local seconds=60 jobs=1 names=() known
    mapfile -t known < <(fuzz_names)
    # shellcheck disable=SC2034  # VERBOSE is for say.sh
    while (($# > 0)); do
        case $1 in
            -h | --help) fuzz_help && return ;;
            --list) fuzz_list && return ;;
            -v | --verbose) VERBOSE=1 ;;
            --seconds)
                (($# > 1)) || usage_error "fuzz: --seconds lacks its value"
                seconds=$2
                shift
                ;;
            --jobs)
                (($# > 1)) || usage_error "fuzz: --jobs lacks its value"
                jobs=$2
                shift
                ;;
            -*) usage_error "fuzz: unknown option '$1'; terravox fuzz --help lists them" ;;
            *)
                in_list "$1" "${known[@]}" ||
                    usage_error "fuzz: no target is called '$1'; allowed: ${known[*]}"
                names+=("$1")
                ;;
        esac
        shift
    done
    [[ $seconds =~ ^[1-9][0-9]{0,5}$ ]] ||
        usage_error "fuzz: --seconds '$seconds'; allowed: 1 to 999999"
    if [[ ! $jobs =~ ^[1-9][0-9]?$ ]] || ((jobs > 64)); then
        usage_error "fuzz: --jobs '$jobs'; allowed: 1 to 64"
    fi
    ((${#names[@]} > 0)) || names=("${known[@]}")
    fuzz_targets "$seconds" "$jobs" "${names[@]}"
}
