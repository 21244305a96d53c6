# Checks of the form of sources: layers, Python, shell, TypeScript, C++. Sourced by ./terravox.
# shellcheck shell=bash

LINT_REQUIREMENTS=$ROOT/config/setup/python/lint.txt
LINT_PACKAGE_LIST=$ROOT/config/setup/debian-lint-packages.txt
LINT_DIR=$ROOT/build/deps/lint
CLANG_FORMAT=$LINT_DIR/clang_format/data/bin/clang-format
LINE_COLUMNS=100
# What tests/measure_form.py may find, a little above what it finds today: so dense is the code of
# formulas and vector instructions, and none of it should become denser.
MAX_TOKENS_PER_LINE=10.5
MAX_BRANCHES_PER_10_LINES=3.1

# Installs clang-format, ruff and lizard, unless the pinned versions are there already.
# tests/measure_form.py imports lizard from this folder.
install_linters() {
    install_pinned "$LINT_DIR" "$LINT_REQUIREMENTS" "clang-format, ruff and lizard"
}

# lint_python: looks for mistakes and for what `ruff format` would change, but changes
# nothing. Returns 1 when something is to be done.
lint_python() {
    local files status=0 ruff=$LINT_DIR/bin/ruff
    install_linters
    mapfile -d '' files < <(sources '*.py')
    "$ruff" check --quiet --output-format concise --force-exclude "${files[@]}" >&2 || {
        say "lint: what can be corrected automatically: ${ruff#"$ROOT"/} check --fix"
        status=1
    }
    "$ruff" format --quiet --check --force-exclude "${files[@]}" >&2 || {
        say "lint: Python sources are not formatted; to format them: ./terravox format"
        status=1
    }
    return "$status"
}

# lint_cpp_form: what `terravox format` would change of C++ sources, and what it cannot break into
# lines that are short enough. Returns 1 when something is to be done.
lint_cpp_form() {
    local files status=0
    install_linters
    mapfile -d '' files < <(sources '*.cpp' '*.hpp')
    "$CLANG_FORMAT" --dry-run --Werror "${files[@]}" >&2 || {
        say "lint: C++ sources are not formatted; to format them: ./terravox format"
        status=1
    }
    too_long "${files[@]}" || status=1
    return "$status"
}

# lint_build_files: the build's files have no formatter; their lines are not too long either.
lint_build_files() {
    local files
    mapfile -d '' files < <(sources CMakeLists.txt '*/CMakeLists.txt' '*.cmake' config/layers.toml)
    too_long "${files[@]}"
}

# too_long FILE...: names lines of more than LINE_COLUMNS characters. Returns 1 when there are any.
too_long() {
    python3 -B - "$LINE_COLUMNS" "$@" >&2 <<'PYTHON' || {
import pathlib
import sys

columns = int(sys.argv[1])
found = False
for path in sys.argv[2:]:
    for number, line in enumerate(pathlib.Path(path).read_text().split("\n"), 1):
        if len(line) > columns:
            print(f"{path}:{number}: {len(line)} columns")
            found = True
sys.exit(found)
PYTHON
        say "lint: wrap these lines at $LINE_COLUMNS columns"
        return 1
    }
}

# lint_shell: ShellCheck with the settings of .shellcheckrc, and lines that are too long.
# Returns 1 when something is to be done.
lint_shell() {
    local files status=0
    command -v shellcheck >/dev/null ||
        die "lint: shellcheck is not installed (Debian package shellcheck)"
    mapfile -d '' files < <(sources '*.sh' terravox .ci/run)
    shellcheck "${files[@]}" >&2 || {
        say "lint: ShellCheck has findings; each SC number is explained in its documentation"
        status=1
    }
    too_long "${files[@]}" || status=1
    return "$status"
}

# lint_density: tokens and branches of production code by line. Returns 1 when they are too many.
lint_density() {
    install_linters
    python3 -B "$ROOT/tests/measure_form.py" --limit-tokens "$MAX_TOKENS_PER_LINE" \
        --limit-branches "$MAX_BRANCHES_PER_10_LINES" --limit-long-percent 0 >&2
}

# lint_layers: which folder includes which (config/layers.toml).
lint_layers() {
    python3 -B "$ROOT/tests/layers_test.py" >&2
}

# lint_typescript: eslint and prettier, for the grabber, the web page and their tests. Returns 1
# when something is to be done.
lint_typescript() {
    use_node || die "lint: Node.js $NODE_OLDEST or newer is missing; run terravox deps"
    in_grabber npm run --silent lint >&2 || {
        say "lint: to format TypeScript sources: ./terravox format"
        return 1
    }
}

# changed_sources PATTERN...: sources that differ from the branch main or from the last commit.
changed_sources() {
    {
        git -C "$ROOT" diff --name-only -z --diff-filter=d HEAD -- "$@"
        git -C "$ROOT" diff --name-only -z --diff-filter=d main...HEAD -- "$@" 2>/dev/null || true
    } | sort -zu | sed -z "s|^|$ROOT/|"
}

# tidy_database: writes the compile commands for clang-tidy to build/lint/compile_commands.json. It
# reads sources one by one, and not GCC's precompiled headers.
tidy_database() {
    quietly "$LOGS/lint-configure.log" configure release -B "$ROOT/build/lint" \
        -DTERRAVOX_PRECOMPILED_HEADERS=OFF -DTERRAVOX_UNITY_BUILD=OFF ||
        die "lint: CMake failed"
    # The generated headers are those of the release build.
    sed -i "s|$ROOT/build/lint/|$ROOT/build/release/|g" "$ROOT/build/lint/compile_commands.json"
}

# lint_cpp FILE...: clang-tidy, four sources at a time. Returns 1 when it has findings.
lint_cpp() {
    (($# > 0)) || return 0
    install_packages "$LINT_PACKAGE_LIST"
    command -v clang-tidy >/dev/null ||
        die "lint: clang-tidy is not installed (Debian package clang-tidy)"
    [[ -f $ROOT/build/release/compile_commands.json ]] || build release
    tidy_database
    printf '%s\0' "$@" | xargs -0 --max-args 4 --max-procs "$(nproc)" \
        clang-tidy --quiet -p "$ROOT/build/lint"
}

# format: C++, Python and TypeScript, each with the formatter that lint checks them with.
format() {
    local files
    no_more_arguments format "$@"
    set_up
    set_up_tests
    install_linters
    mapfile -d '' files < <(sources '*.cpp' '*.hpp')
    "$CLANG_FORMAT" -i "${files[@]}"
    mapfile -d '' files < <(sources '*.py')
    "$LINT_DIR/bin/ruff" format --quiet --force-exclude "${files[@]}"
    use_node || die "format: Node.js $NODE_OLDEST or newer is missing; run terravox deps"
    in_grabber npm run --silent format
}

# lint_form: what needs no compiler, apart from layers, which CTest checks; a part of every test
# run. Returns 1 when something is to be done.
lint_form() {
    local status=0
    lint_cpp_form || status=1
    lint_build_files || status=1
    lint_density || status=1
    lint_python || status=1
    lint_shell || status=1
    lint_typescript || status=1
    return "$status"
}

lint_help() {
    cat <<'TEXT'
Checks the form of the sources: which folder includes which (config/layers.toml), C++
(clang-format, clang-tidy), Python (ruff), shell (ShellCheck) and TypeScript (eslint, prettier).
Changes nothing; the exit code is 1 when something is to be done.

Usage: terravox lint [--all | FILE...]

  --all    clang-tidy for all C++ sources; without it for those that were changed
  FILE     clang-tidy for these
TEXT
}

# lint [--all | FILE...]
lint() {
    local files=() status=0
    case ${1:-} in
        -h | --help) lint_help && return ;;
        --all) mapfile -d '' files < <(sources '*.cpp') ;;
        -*) usage_error "lint: unknown option '$1'; allowed: --all, or names of sources" ;;
        '') mapfile -d '' files < <(changed_sources '*.cpp') ;;
        *) files=("$@") ;;
    esac
    set_up
    set_up_tests
    lint_layers || status=1
    lint_form || status=1
    lint_cpp "${files[@]}" || status=1
    return "$status"
}
