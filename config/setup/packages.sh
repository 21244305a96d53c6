# System packages (config/setup/debian-packages.txt). Sourced by ./terravox.
# shellcheck shell=bash

PACKAGE_LIST=$ROOT/config/setup/debian-packages.txt

# offered_packages NAME...: those that an archive has; what is merely installed does not count
offered_packages() { apt-cache madison "$@" 2>/dev/null | awk '!seen[$1]++ { print $1 }'; }

# wanted_packages LIST: what it names. A name with a question mark is of a package that only some
# releases or architectures have: it is wanted where apt offers it.
wanted_packages() {
    local names offered
    mapfile -t names < <(grep -Ev '^[[:space:]]*(#|$)' "$1")
    mapfile -t offered < <(printf '%s\n' "${names[@]}" | sed -n 's/?$//p')
    printf '%s\n' "${names[@]}" | sed '/?$/d'
    ((${#offered[@]} == 0)) || offered_packages "${offered[@]}"
}

# missing_packages LIST
missing_packages() {
    local wanted
    mapfile -t wanted < <(wanted_packages "$1")
    {
        dpkg-query --show --showformat '${db:Status-Status} ${Package}\n' "${wanted[@]}" \
            2>/dev/null || true
    } | awk -v wanted="${wanted[*]}" '
        $1 == "installed" { have[$2] = 1 }
        END {
            n = split(wanted, names, " ")
            for (i = 1; i <= n; i++) {
                if (!(names[i] in have)) print names[i]
            }
        }'
}

as_root() { if ((EUID == 0)); then "$@"; else sudo "$@"; fi; }

apt_install() {
    as_root env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
        --yes --quiet --no-install-recommends install "$@"
}

# install_packages [LIST]: those to build with unless another list is given.
install_packages() {
    local list=${1:-$PACKAGE_LIST}
    [[ ${TERRAVOX_SKIP_PACKAGES:-0} == 1 ]] && return
    if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
        say "This system has no apt. Install what these Debian packages hold," \
            "then call again with TERRAVOX_SKIP_PACKAGES=1:"
        say
        cat "$list" >&2
        exit 1
    fi
    local missing
    mapfile -t missing < <(missing_packages "$list")
    ((${#missing[@]} == 0)) && return
    if ((EUID != 0)) && ! command -v sudo >/dev/null; then
        die "install packages: neither root nor sudo." \
            "Ask an administrator for: apt-get install ${missing[*]}"
    fi
    say "Installing packages: ${missing[*]}"
    # The prompt for the password is here, where it can be seen, and not in the middle of quiet
    # output. A command, as --validate asks for one as soon as any rule for the user does.
    if ((EUID != 0)); then
        sudo true ||
            die "install packages: sudo refused. Needed: apt-get install ${missing[*]}"
    fi
    # The package lists may be absent or old. They are refreshed only then, since that takes a
    # while.
    if ! apt_install --simulate "${missing[@]}" >/dev/null 2>&1 ||
        ! watched "$LOGS/apt-install.log" apt_install "${missing[@]}"; then
        quietly "$LOGS/apt-update.log" as_root apt-get --quiet update ||
            die "install packages: apt-get update failed"
        # Now apt may offer more.
        mapfile -t missing < <(missing_packages "$list")
        quietly "$LOGS/apt-install.log" apt_install "${missing[@]}" ||
            die "install packages: apt-get failed. Needed: ${missing[*]}"
    fi
    # `build` compares its time.
    touch "$LOGS/apt-install.log"
}
