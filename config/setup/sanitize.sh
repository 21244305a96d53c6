# Tests with sanitizers (presets asan and tsan). Sourced by ./terravox.
# shellcheck shell=bash

# Readers of untrusted files, with the address and the undefined-behaviour sanitizer. Part of
# `./terravox test --all`, so chosen to be built from few libraries.
SANITIZED_PARSERS=(
    common_test
    imagery_test
    lidar_bad_files_test
    lidar_memory_test
    lidar_test
    luanti_test
    minecraft_test
    ply_test
    sqlite_test
)

# Caches, server, farm and preview: what has threads.
SANITIZED_THREADS=(
    boxes_test
    checkpoint_test
    common_test
    disk_cache_test
    farm_test
    net_test
    preview_test
    raytracer_test
    remote_world_test
    store_test
    tile_processors_test
    voxelserver_http_test
    worker_parts_test
)

# What ctest must leave out with sanitizers, as a pattern of names: it reads back that the programs
# are built as they are shipped.
# And entries that take minutes without sanitizers.
SANITIZED_LEFT_OUT='^e2e_hardening_test$|^e2e_wheel_test$|_all$'

# run_sanitized_tests PRESET TEST...
run_sanitized_tests() {
    local preset=$1 tests=("${@:2}") pattern
    build "$preset" "${tests[@]}" || return
    pattern=$(IFS='|' && echo "^(${tests[*]})(_all)?\$")
    (cd "$ROOT" && ctest --preset "$preset" --parallel "$(nproc)" --tests-regex "$pattern")
}

# All programs and all tests, e2e tests too, with addresses, undefined behaviour and leaks; then
# threads. Takes hours.
run_all_sanitized() {
    local failed=() only=(--exclude-regex "$SANITIZED_LEFT_OUT")
    set_up
    set_up_tests
    build asan
    (cd "$ROOT" && ctest --preset asan --parallel "$(nproc)" "${only[@]}") || failed+=(asan)
    run_sanitized_tests tsan "${SANITIZED_THREADS[@]}" || failed+=(tsan)
    ((${#failed[@]} == 0)) || die "test --sanitize all: failed: ${failed[*]}"
}

# run_sanitized asan|tsan|all [TEST...]
run_sanitized() {
    local preset=${1:-} tests=("${@:2}")
    case $preset in
        all)
            ((${#tests[@]} == 0)) ||
                usage_error "test --sanitize all: '${tests[0]}'; allowed: no names, it runs all"
            run_all_sanitized
            return
            ;;
        asan) ((${#tests[@]} > 0)) || tests=("${SANITIZED_PARSERS[@]}") ;;
        tsan) ((${#tests[@]} > 0)) || tests=("${SANITIZED_THREADS[@]}") ;;
        *)
            usage_error "test --sanitize: '$preset'; allowed:" \
                "asan (addresses, undefined behaviour, leaks), tsan (threads), all"
            ;;
    esac
    set_up
    run_sanitized_tests "$preset" "${tests[@]}"
}
