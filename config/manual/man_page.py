"""Writes a man page: groff's macros man(7)."""

EXIT_STATUS = (
    ("0", "done"),
    ("1", "failed"),
    ("2", "wrong usage: a command, an option, a setting"),
    ("3", "done, but data were missing: the result has holes"),
)

ENVIRONMENT = (
    ("TERRAVOX_CONFIG", "a folder of data files instead of those that ship"),
    ("TERRAVOX_FARM_TOKEN", "the token of a coordinator and its workers"),
    ("TERRAVOX_SERVER_TOKEN", "a voxel server's token"),
    ("TERRAVOX_SERVER_ORIGIN", "the one server that clients send it to: http(s)://host[:port]"),
)


def escaped(text):
    """Text for roff: no letter of it is a request, and hyphens can be searched for and copied."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    text = text.replace("~", "\\(ti").replace("^", "\\(ha").replace("`", "\\(ga")
    return "\n".join("\\&" + line if line.startswith(".") else line for line in text.split("\n"))


def bold(text):
    return f"\\fB{escaped(text)}\\fR"


def italic(text):
    return f"\\fI{escaped(text)}\\fR"


def sentence(text):
    """The same as one: with a capital letter and a full stop."""
    text = text.strip()
    text = text[:1].upper() + text[1:]
    return text if text.endswith((".", "!", "?")) else text + "."


def value_of(option):
    """The name of a value in italics: without what the type says of its checks."""
    name = option.value.split(":")[0] or "VALUE"
    return italic("|".join(option.words) if 0 < len(option.words) <= 3 else name)


def label_of(option):
    if not option.names:
        return italic(option.positional) + (" ..." if option.repeats else "")
    label = ", ".join(bold(name) for name in option.names)
    return f"{label} {value_of(option)}" if option.value else label


def option_lines(option):
    text = escaped(option.text)
    if option.default:
        text += f" [{escaped(option.default)}]"
    if option.required:
        text += " (required)"
    return [".TP", label_of(option), text or "\\&"]


def synopsis(command):
    words = [bold(" ".join(("terravox", *command.words)))]
    if command.commands:
        words.append(italic("COMMAND"))
    if any(option.names for option in command.options):
        words.append(f"[{italic('OPTION')}]...")
    for option in command.options:
        if not option.names:
            name = italic(option.positional) + (" ..." if option.repeats else "")
            words.append(name if option.required else f"[{name}]")
    return [".SH SYNOPSIS", " ".join(words)]


def options_of(command):
    lines = []
    groups = dict.fromkeys(option.group for option in command.options if option.names)
    arguments = [option for option in command.options if not option.names]
    if arguments:
        lines.append(".SH ARGUMENTS")
        for option in arguments:
            lines += option_lines(option)
    if groups:
        lines.append(".SH OPTIONS")
    for group in groups:
        if group.lower() not in ("options", "option"):
            lines.append(f'.SS "{escaped(group)}"')
        for option in command.options:
            if option.names and option.group == group:
                lines += option_lines(option)
    return lines


def listed(heading, rows):
    lines = [f'.SH "{heading}"']
    for name, text in rows:
        lines += [".TP", bold(name), escaped(text)]
    return lines


def commands_of(command):
    rows = [(each.words[-1], each.summary) for each in command.commands]
    return listed("COMMANDS", rows) if rows else []


def notes_of(command):
    if not command.footer:
        return []
    lines = [".SH NOTES", ".nf"]
    lines += [escaped(line) if line.strip() else ".sp" for line in command.footer.split("\n")]
    return [*lines, ".fi"]


def see_also(command, parent):
    pages = [each.page for each in command.commands]
    if parent is not None:
        pages.insert(0, parent.page)
    return [".SH SEE ALSO", ",\n".join(f"{bold(page)}(1)" for page in pages)] if pages else []


def man_page(command, parent, version, date):
    """@param date YYYY-MM-DD @return the text of its page"""
    title = command.page.upper()
    lines = [
        f'.TH "{escaped(title)}" 1 "{date}" "Terravox {version}" "Terravox"',
        ".SH NAME",
        f"{escaped(command.page)} \\- {escaped(command.summary.split(chr(10))[0].rstrip('.'))}",
        *synopsis(command),
        ".SH DESCRIPTION",
        escaped(sentence(command.summary)),
        *commands_of(command),
        *options_of(command),
        *notes_of(command),
        *(listed("ENVIRONMENT", ENVIRONMENT) if not command.words else []),
        *listed("EXIT STATUS", EXIT_STATUS),
        *see_also(command, parent),
    ]
    return "\n".join(lines) + "\n"
