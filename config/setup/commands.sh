# The commands for users, of a checkout (./terravox) and of an installed package (bin/terravox)
# alike. Sourced by both after say.sh, with COMMANDS_FILE set. Each defines start PROGRAM
# [ARGUMENT...], which runs one of the programs in place of the script.
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

# run_command COMMAND [ARGUMENT...]: one of the programs, in place of this script.
run_command() {
    local words
    read -ra words <<<"$(program_of "$1")"
    ((${#words[@]} > 0)) || usage_error "unknown command '$1'; terravox help lists them"
    start "${words[@]}" "${@:2}"
}
