"""Writes the completion of command lines for bash, fish and zsh."""

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


def _inner_words(commands):
    """@return path, the words that may follow it, of each command with others below it"""
    return [
        (_path(c), " ".join([*(each.words[-1] for each in c.commands), *_top_words(c)]))
        for c in commands
        if c.commands
    ]


def _options_with_value(commands):
    return [(_path(c), _names(o for o in c.options if o.value)) for c in commands if c.options]


def bash(root):
    """@param root the command terravox"""
    commands = list(root.everything())
    tables = {
        "COMMANDS": _inner_words(commands),
        "OPTIONS": [(_path(c), _names(c.options) or "--help --version") for c in commands],
        "WITH_VALUE": _options_with_value(commands),
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


ZSH = r"""#compdef terravox
# Completion of terravox for zsh. Made from the option tables of the programs.

# What the function _arguments reads of the options of a command.
_terravox_options() {
    case $1 in
@OPTIONS@
    esac
}

_terravox() {
    # at: the command that the words up to the current one name, such as "analyse sky"; its last
    # word is the start-th.
    local at= word start=1 i
    local -A inner=(
@COMMANDS@
    )
    local -A with_value=(
@WITH_VALUE@
    )
    local -a specs found
    for ((i = 2; i < CURRENT; i++)); do
        word=$words[i]
        if [[ $word == -* ]]; then
            [[ " $with_value[:$at] " != *" $word "* ]] || ((i++))
        elif [[ " $inner[:$at] " == *" $word "* ]]; then
            at=${at:+$at }$word
            start=$i
        fi
    done
    if [[ -n $inner[:$at] && $words[CURRENT] != -* ]]; then
        found=(${=inner[:$at]})
        compadd -- $found
        return
    fi
    _terravox_options $at
    # _arguments takes the first word for the command.
    words=("${(@)words[start,-1]}")
    ((CURRENT -= start - 1))
    _arguments : $specs '*:file:_files'
}

_terravox "$@"
"""


def _zsh_text(text):
    """Text in a row for _arguments, where brackets and colons have a meaning."""
    text = text.split("\n")[0].replace("\\", "\\\\")
    for mark in "[]:":
        text = text.replace(mark, "\\" + mark)
    return text


def _zsh_rows(option):
    what = ""
    if option.words:
        what = f":value:({' '.join(option.words)})"
    elif option.value:
        what = ":value:_files"
    for name in option.names:
        # Of a long option the value may follow a `=`.
        joint = "=" if what and name.startswith("--") else ""
        yield f"*{name}{joint}[{_zsh_text(option.text)}]{what}"


def _zsh_specs(command):
    rows = [row for option in command.options for row in _zsh_rows(option)]
    rows = rows or ["--help[prints what it can do]", "--version[prints its version]"]
    lines = [f"    {shlex.quote(row)}" for row in rows]
    case = [f"{shlex.quote(_path(command))})", "    specs=(", *lines, "    )", "    ;;"]
    return "\n".join(f"        {line}" for line in case)


def _zsh_table(rows):
    return "\n".join(f"        {shlex.quote(':' + key)} {shlex.quote(text)}" for key, text in rows)


def zsh(root):
    """@param root the command terravox"""
    commands = list(root.everything())
    text = ZSH.replace("@OPTIONS@", "\n".join(map(_zsh_specs, commands)))
    text = text.replace("@COMMANDS@", _zsh_table(_inner_words(commands)))
    return text.replace("@WITH_VALUE@", _zsh_table(_options_with_value(commands)))
