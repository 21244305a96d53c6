# A release: packages with what belongs to them (docs/adr/0030-packages.md). Sourced by ./terravox.
# shellcheck shell=bash

RELEASE_TOOLS=$ROOT/config/release
RELEASE_PARTS=(deb wheel sdist image)

release_help() {
    cat <<'TEXT'
Makes what is published of a version.

Usage: terravox release -o FOLDER [--only PART,...] [--draft]
       terravox release --check

  --check          only looks whether this checkout can be released: one version everywhere, an
                   entry of the changelog with a date, everything committed
  -o FOLDER        where the files are written; made when missing, else empty
  --only PART,...  deb, wheel, sdist, image; all unless some are named
  --draft          goes on where the check finds something

With the packages come terravox-VERSION.spdx.json, which lists what is in them (SPDX 2.3),
licences-third-party.txt, and SHA256SUMS.
TEXT
}

# Prints what stands in the way, and fails then.
check_release() {
    local problems
    problems=$(python3 -B "$RELEASE_TOOLS/check_release.py" "$ROOT") ||
        die "release: the check itself failed"
    [[ -n $problems ]] || return 0
    say "$problems"
    return 1
}

# is_release_part WORD
is_release_part() {
    local part
    for part in "${RELEASE_PARTS[@]}"; do
        [[ $1 != "$part" ]] || return 0
    done
    return 1
}

# read_release_arguments ARGUMENT...: into FOLDER, PARTS, DRAFT
read_release_arguments() {
    local part
    local -A seen=()
    FOLDER='' DRAFT=0 PARTS=("${RELEASE_PARTS[@]}")
    while (($# > 0)); do
        case $1 in
            -o)
                FOLDER=${2:-}
                [[ -n $FOLDER ]] || usage_error "release: -o FOLDER is missing"
                shift
                ;;
            --only)
                IFS=, read -ra PARTS <<<"${2:-}"
                shift
                ;;
            --draft) DRAFT=1 ;;
            *) usage_error "release: unknown argument '$1'; terravox release --help" ;;
        esac
        shift || usage_error "release: --only PART,... is missing"
    done
    [[ -n $FOLDER ]] || usage_error "release: -o FOLDER is missing"
    ((${#PARTS[@]} > 0)) || usage_error "release: --only names no part"
    for part in "${PARTS[@]}"; do
        is_release_part "$part" ||
            usage_error "release: --only '$part'; allowed: ${RELEASE_PARTS[*]}"
        [[ -z ${seen[$part]:-} ]] || usage_error "release: --only names '$part' twice"
        seen[$part]=1
    done
}

# describe_release FOLDER: what belongs to the packages that are there
describe_release() {
    local files
    files=("$1"/*)
    python3 -B "$RELEASE_TOOLS/licences.py" "${files[@]}" \
        -o "$1/licences-third-party.txt" --third-party "$ROOT/THIRD_PARTY.md" \
        --deps "$ROOT/build/deps"
    python3 -B "$RELEASE_TOOLS/sbom.py" "${files[@]}" \
        -o "$1/terravox-$(version_number).spdx.json" --version "$(version_number)" \
        --time "$SOURCE_DATE_EPOCH" --third-party "$ROOT/THIRD_PARTY.md"
    files=("$1"/*)
    (cd "$1" && sha256sum -- "${files[@]##*/}" >SHA256SUMS)
}

# release ARGUMENT...
release() {
    local FOLDER DRAFT PARTS part
    case ${1:-} in
        -h | --help) release_help && return ;;
        --check)
            no_more_arguments "release --check" "${@:2}"
            check_release
            return
            ;;
    esac
    read_release_arguments "$@"
    if ! check_release && ((DRAFT == 0)); then
        die "release: this checkout cannot be released (above); --draft goes on"
    fi
    mkdir -p "$FOLDER"
    FOLDER=$(cd "$FOLDER" && pwd)
    [[ -z $(ls -A "$FOLDER") ]] || die "release: $FOLDER is not empty"
    for part in "${PARTS[@]}"; do
        package "$part" -o "$FOLDER"
    done
    describe_release "$FOLDER"
    printf '%s\n' "$FOLDER"/{SHA256SUMS,licences-third-party.txt,terravox-*.spdx.json}
}
