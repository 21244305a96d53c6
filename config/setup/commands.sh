# The commands for users, of a checkout (./terravox) and of an installed package (bin/terravox)
# alike. Sourced by both after say.sh, with COMMANDS_FILE set. Each defines OWN_COMMANDS, those that
# the script answers itself, show_help, and start PROGRAM [ARGUMENT...], which runs one of the
# programs in place of the script.
# shellcheck shell=bash

# Prints NAME|PROGRAM|TEXT for each command.
command_rows() {
    sed -E '/^#/d; s/ *\| */|/g' "$COMMANDS_FILE"
}

# Lines of `help`: 77 columns of text behind 23 of names. Pipes, and not <(...): that needs /dev/fd,
# which bare roots lack.
list_commands() {
    local name text line
    command_rows | while IFS='|' read -r name _ text; do
        fold -s -w 77 <<<"$text" | while IFS= read -r line; do
            printf '  %-20s %s\n' "$name" "${line% }"
            name=
        done
    done
}

# Lines of `help` about the environment that the programs read.
list_environment() {
    cat <<'TEXT'
Environment: TERRAVOX_FARM_TOKEN: a coordinator's and its workers' token; TERRAVOX_SERVER_TOKEN: a
voxel server's, which clients send to TERRAVOX_SERVER_ORIGIN alone; TERRAVOX_CONFIG: a folder of
data files instead of those that ship.
TEXT
}

# program_of COMMAND: prints the program and its first words, nothing where there is no such
# command.
program_of() {
    local name program
    command_rows | while IFS='|' read -r name program _; do
        if [[ ${name%% *} == "$1" ]]; then
            printf '%s\n' "$program"
        fi
    done
}

# edit_distance WORD WORD: prints how many letters to insert, remove, replace, or swap with their
# neighbour turn one into the other, as common/util/text.hpp counts them.
edit_distance() {
    local a=$1 b=$2 before=() last=() row=() i j least
    for ((j = 0; j <= ${#b}; j++)); do last[j]=$j; done
    for ((i = 1; i <= ${#a}; i++)); do
        row=("$i")
        for ((j = 1; j <= ${#b}; j++)); do
            least=$((last[j - 1] + 1))
            [[ ${a:i-1:1} != "${b:j-1:1}" ]] || least=$((last[j - 1]))
            ((last[j] + 1 >= least)) || least=$((last[j] + 1))
            ((row[j - 1] + 1 >= least)) || least=$((row[j - 1] + 1))
            if ((i > 1 && j > 1)) && [[ ${a:i-2:2} == "${b:j-1:1}${b:j-2:1}" ]] &&
                ((before[j - 2] + 1 < least)); then
                least=$((before[j - 2] + 1))
            fi
            row[j]=$least
        done
        before=("${last[@]}")
        last=("${row[@]}")
    done
    printf '%s\n' "${last[${#b}]}"
}

# near_command WORD COMMAND...: prints the command that is nearest to a mistyped word, nothing where
# none is near, by the limits of common/util/text.hpp.
near_command() {
    local typed=${1,,} name edits longer fewest=4 near=
    ((${#typed} <= 20)) || return 0
    for name in "${@:2}"; do
        edits=$(edit_distance "$typed" "$name")
        longer=$((${#typed} > ${#name} ? ${#typed} : ${#name}))
        if ((edits < fewest && 5 * edits < 3 * longer)); then
            fewest=$edits
            near=$name
        fi
    done
    printf '%s\n' "$near"
}

# refuse_command WORD: ends with what was probably meant.
refuse_command() {
    local names near
    mapfile -t names <<<"$(command_rows | sed 's/[ |].*//')"
    near=$(near_command "$1" "${names[@]}" "${OWN_COMMANDS[@]}")
    if [[ -n $near ]]; then
        usage_error "unknown command '$1'; did you mean $near? terravox help lists all commands"
    fi
    usage_error "unknown command '$1'; terravox help lists all commands"
}

# run_command COMMAND [ARGUMENT...]: one of the programs, in place of this script.
run_command() {
    local words
    read -ra words <<<"$(program_of "$1")"
    ((${#words[@]} > 0)) || refuse_command "$1"
    start "${words[@]}" "${@:2}"
}

# run_help [COMMAND [ARGUMENT...]]: all commands, or what one of the programs says of itself.
run_help() {
    local own
    (($# > 0)) || set -- ''
    for own in '' "${OWN_COMMANDS[@]}"; do
        if [[ $1 == "$own" ]]; then
            show_help
            return
        fi
    done
    run_command "$@" --help
}

# show_start [LINE...]: what a newcomer does first. LINEs come before what all have.
show_start() {
    printf '%s\n\n' 'Terravox: real places as ray-traced voxel landscapes. To begin with:'
    (($# == 0)) || printf '%s\n' "$@"
    cat <<'TEXT'
  terravox render generated:7 -o try.png    draws a picture of a landscape from noise
  terravox render DATA -o place.png         the same of your data: a LAZ file or a folder of them,
                                            heights (GeoTIFF), a Minecraft world, ...
  terravox preview DATA                     flies around it in a window; view DATA: in a browser
  terravox grab sources                     lists open LiDAR data that it can fetch

terravox help lists all commands, terravox help render explains one.
TEXT
}
