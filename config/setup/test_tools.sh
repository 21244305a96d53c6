# What only the tests need. Sourced by ./terravox.
# shellcheck shell=bash

TEST_PACKAGE_LIST=$ROOT/config/setup/debian-test-packages.txt
SERVICE_PACKAGE_LIST=$ROOT/config/setup/debian-service-packages.txt
NGINX_DIR=$ROOT/build/deps/nginx
# Processor time of each entry of CTest in the last run, by tests/timed.py.
TIMES=$LOGS/test-times.txt
NGINX_PLACES=(nginx /usr/sbin/nginx "$NGINX_DIR/usr/sbin/nginx")

# nginx is unpacked, not installed: its package would start a web server on this machine. Without it
# its tests are skipped, with a message. Of Debian's packages the plain one has the program since
# Debian 12; nginx-light has documents alone.
fetch_nginx() {
    local program part
    for program in "${NGINX_PLACES[@]}"; do
        ! "$program" -v >/dev/null 2>&1 || return 0
    done
    [[ ${TERRAVOX_SKIP_PACKAGES:-0} == 1 ]] && return
    part=$(mktemp -d "$ROOT/build/deps/nginx.XXXXXX")
    say "Fetching nginx (for tests)"
    if (
        cd "$part" &&
            quietly "$LOGS/nginx.log" apt-get download nginx &&
            dpkg-deb --extract nginx_*.deb . &&
            quietly "$LOGS/nginx.log" usr/sbin/nginx -v
    ); then
        rm -rf "$NGINX_DIR"
        mv "$part" "$NGINX_DIR"
    else
        rm -rf "$part"
        say "nginx cannot be fetched: its tests are skipped"
    fi
}

set_up_tests() {
    install_packages "$TEST_PACKAGE_LIST"
    # Running the tests must not leave services on a machine.
    if [[ ! -d /run/systemd/system ]]; then
        install_packages "$SERVICE_PACKAGE_LIST"
    else
        say "Not installed, since they would start services here: the packages of" \
            "config/setup/debian-service-packages.txt; where one is missing its tests are skipped"
    fi
    fetch_nginx
    install_linters
    PATH=$PATH:/usr/sbin:$NGINX_DIR/usr/sbin
}

# tier_pattern default|all|changed [--base COMMIT]: a regular expression of entries of CTest
tier_pattern() {
    local names
    names=$("$ROOT/tests/tiers.py" names "$@") || return
    printf '^(%s)$\n' "$(paste --serial --delimiters='|' <<<"$names")"
}

# Tests write down what they leave out: lines of FILE TAB TEST TAB REASON, by tests/run_unittest.py,
# tests/catch_main.cpp and tests/skips.mjs.
count_skips() {
    export TERRAVOX_SKIPS=$LOGS/skipped.txt
    mkdir -p "$LOGS"
    rm -f "$TERRAVOX_SKIPS" "$TIMES"
    trap report_skips EXIT
}

# Reasons, each with its tests.
report_skips() {
    local reason='' file test why lines
    [[ -s $TERRAVOX_SKIPS ]] || return 0
    lines=$(LC_ALL=C sort --unique --field-separator=$'\t' --key=3 --key=1,2 "$TERRAVOX_SKIPS")
    say "Skipped tests: $(wc -l <<<"$lines")"
    while IFS=$'\t' read -r file test why; do
        [[ $why == "$reason" ]] || say "  $why"
        reason=$why
        say "    $file: $test"
    done <<<"$lines"
}
