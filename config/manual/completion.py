"""Writes the completion of command lines for bash and fish."""

import shlex

BASH = r"""# Completion of terravox for bash. Made from the option tables of the programs.

_terravox_commands() {
    case $1 in
@COMMANDS@
    esac
}

_terravox_options() {
    case $1 in
@OPTIONS@
    esac
}

# The options of a command that take a value.
_terravox_with_value() {
    case $1 in
@WITH_VALUE@
    esac
}

# The values of an option, where they are few.
_terravox_values() {
    case "$1 $2" in
@VALUES@
    esac
}

# Sets path to the command that the words up to the current one name, such as "analyse sky".
_terravox_find_path() {
    local i word
    path=
    for ((i = 1; i < COMP_CWORD; i++)); do
        word=${COMP_WORDS[i]}
        if [[ $word == -* ]]; then
            [[ " $(_terravox_with_value "$path") " != *" $word "* ]] || ((i++))
        elif [[ " $(_terravox_commands "$path") " == *" $word "* ]]; then
            path=${path:+$path }$word
        fi
    done
}

_terravox() {
    local path current=${COMP_WORDS[COMP_CWORD]} option=${COMP_WORDS[COMP_CWORD - 1]} values
    _terravox_find_path
    # `=` is a word of its own: --option=value.
    if [[ $current == '=' ]]; then
        current=
    elif [[ $option == '=' ]]; then
        option=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    if [[ " $(_terravox_with_value "$path") " == *" $option "* ]]; then
        values=$(_terravox_values "$path" "$option")
    elif [[ $current == -* ]]; then
        values=$(_terravox_options "$path")
    else
        values=$(_terravox_commands "$path")
    fi
    # Nothing else: file names.
    if [[ -n $values ]]; then
        mapfile -t COMPREPLY < <(compgen -W "$values" -- "$current")
    else
        COMPREPLY=()
        compopt -o default 2>/dev/null
    fi
}

complete -F _terravox terravox
"""


def _cases(rows):
    return "\n".join(
        f"        {shlex.quote(key)}) echo {shlex.quote(text)} ;;" for key, text in rows
    )


def _path(command):
    return " ".join(command.words)


def _names(options):
    return " ".join(name for option in options for name in option.names)


def _top_words(command):
    return ["help", "--version"] if not command.words else []


def bash(root):
    """@param root the command terravox"""
    commands = list(root.everything())
    tables = {
        "COMMANDS": [
            (_path(c), " ".join([*(each.words[-1] for each in c.commands), *_top_words(c)]))
            for c in commands
            if c.commands
        ],
        "OPTIONS": [(_path(c), _names(c.options) or "--help --version") for c in commands],
        "WITH_VALUE": [
            (_path(c), _names(o for o in c.options if o.value)) for c in commands if c.options
        ],
        "VALUES": [
            (f"{_path(c)} {name}", " ".join(option.words))
            for c in commands
            for option in c.options
            if option.words
            for name in option.names
        ],
    }
    text = BASH
    for name, rows in tables.items():
        text = text.replace(f"@{name}@", _cases(rows))
    return text


FISH = r"""# Completion of terravox for fish. Made from the option tables of the programs.

# Whether these commands, in this order, are those of the command line.
function __terravox_at
    set --local words (commandline --tokens-expanded --cut-at-cursor 2>/dev/null
        or commandline --tokenize --cut-at-cursor)
    set --local found
    for word in $words[2..]
        contains -- $word @NAMES@; and set --append found $word
    end
    test "$found" = "$argv"
end

"""


def _fish_option(command, option):
    line = ["complete", "-c", "terravox", "-n", f"'__terravox_at {_path(command)}'"]
    for name in option.names:
        line += ["-l" if name.startswith("--") else "-s", shlex.quote(name.lstrip("-"))]
    line += ["-d", shlex.quote(option.text.split("\n")[0])]
    if option.words:
        line += ["-x", "-a", shlex.quote(" ".join(option.words))]
    elif option.value:
        line.append("-r")
    return " ".join(line)


def fish(root):
    """@param root the command terravox"""
    lines = []
    names = sorted({word for command in root.everything() for word in command.words})
    for command in root.everything():
        for inner in command.commands:
            text = shlex.quote(inner.summary.split("\n")[0])
            at = f"'__terravox_at {_path(command)}'"
            lines.append(f"complete -c terravox -f -n {at} -a {inner.words[-1]} -d {text}")
        lines += [_fish_option(command, option) for option in command.options if option.names]
    return FISH.replace("@NAMES@", " ".join(names)) + "\n".join(lines) + "\n"
