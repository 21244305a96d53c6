# Mutation tests: seeded faults (tests/mutants), and which tests find them. Sourced by ./terravox.
# shellcheck shell=bash

mutants_help() {
    cat <<'TEXT'
Seeds faults, one at a time (tests/mutants), and runs the tests that should find them, in a copy of
the checkout (build/mutants).

Usage: terravox mutants [--tier default|all] [--nearest] [NAME...]
       terravox mutants --list

  NAME                which; all when none is named
  --tier default|all  the entries that run: those of `terravox test`, or every one [default]
  --nearest           only the entries that a mutant names
  --in-place          in the checkout itself, which must have no changes, and its release build
  --limit-s N         an entry that takes longer hangs [3600]
  --list              lists the names with the faults

A mutant that no entry finds has survived: then a test is missing, and the exit code is 1. Outputs
are in build/mutants/logs.
TEXT
}

mutants() {
    local word
    for word in "$@"; do
        case $word in
            -h | --help) mutants_help && return ;;
            --list)
                python3 -B "$ROOT/tests/mutants/run.py" "$@"
                return
                ;;
        esac
    done
    set_up
    set_up_tests
    use_node || die "mutants: Node.js $NODE_OLDEST or newer is missing; run terravox deps"
    python3 -B "$ROOT/tests/mutants/run.py" "$@"
}
