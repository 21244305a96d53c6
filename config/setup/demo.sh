# Data of the demo: a synthetic survey, published by a portal on this machine and fetched from there
# like any other. Sourced by ./terravox.
# shellcheck shell=bash

# Makes the synthetic survey once for each set of options; prints its folder. It is made next to its
# place and renamed: a folder of that name is always complete.
demo_survey() {
    local program=$ROOT/build/release/bin/terravox-survey key folder
    key=$( (printf '%s\n' "${DEMO_SURVEY[@]}" && cat "$program") | sha256sum | cut -c 1-12)
    folder=$ROOT/build/demo/survey-$key
    if [[ ! -d $folder ]]; then
        rm -rf "$ROOT/build/demo"
        mkdir -p "$ROOT/build/demo"
        "$program" "${DEMO_SURVEY[@]}" -o "$folder.part-$$" >&2
        mv "$folder.part-$$" "$folder"
    fi
    printf '%s\n' "$folder"
}

# The portal is one of the grabber's tests.
build_portal() {
    local built=$ROOT/grabber/dist-test/.built
    if [[ -f $built ]] && ! is_older "$built" "$ROOT/tests/grabber"; then return 0; fi
    quietly "$LOGS/npm-build-test.log" in_grabber npm run build:test ||
        die "build the demo's portal: npm run build:test failed"
    touch "$built"
}

# demo_grab CONFIG ARGUMENT...: the grabber, which was built before, in a process of its own.
demo_grab() {
    (TERRAVOX_NO_BUILD=1 grab --config "$@") >&2
}

# demo_store SURVEY: fetches all that the portal has and prints the folder of the store. A second
# call finds everything there.
demo_store() {
    local survey=$1 store=${1/survey-/store-} config=$ROOT/build/demo/config portal base failed=0
    exec 8< <(exec node "$ROOT/grabber/dist-test/tests/grabber/portal/main.js" --root "$survey")
    portal=$!
    read -r base <&8 || die "demo: the portal of the demo did not start"
    mkdir -p "$config/sources/ortho"
    demo_source "$base" >"$config/sources/demo.toml"
    demo_ortho_source "$base" >"$config/sources/ortho/demo.toml"
    cp "$ROOT"/config/*.toml "$config"
    demo_grab "$config" fetch --store "$store" --source demo --squares 462_101 || failed=1
    if ((failed == 0)); then
        demo_grab "$config" ortho --store "$store" --source demo --lossless --margin-m 0 || failed=1
    fi
    kill "$portal"
    exec 8<&-
    ((failed == 0)) || die "demo: the survey could not be fetched from $base"
    printf '%s\n' "$store"
}

demo_source() {
    cat <<TOML
id = "demo"
title = "A synthetic survey, published on this machine"
licence = "CC0 1.0"
attribution = "None: the survey is synthetic"
crs = "EPSG:3794"
square_m = 1000
extent_m = [370000, 25000, 630000, 200000]
class_table = "asprs"
max_concurrent = 4
missing_status = [404]
allow_private_addresses = true

[access]
kind = "template"
urls = ["$1/TM_{E}_{N}.laz"]
TOML
}

demo_ortho_source() {
    cat <<TOML
id = "demo"
title = "Orthophotos of a synthetic survey, published on this machine"
licence = "CC0 1.0"
attribution = "None: the survey is synthetic"
crs = "EPSG:3794"
resolution_m = 0.5
allow_private_addresses = true

[access]
kind = "template"
url = "$1/ortho/TM_{E}_{N}.tif"
place = "file"
TOML
}
