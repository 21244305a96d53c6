"""Which options the programs have, by their --help all."""

import functools
import re

import markdown
from support import ROOT, Run, binary

# In the order of how often the pages name them: a program is started only when it is needed.
RAYTRACER = ["render", "convert", "map", "publish", "view", "worker", "animate", "preview"]
ANALYSES = ("terrain", "sky", "sun", "energy", "sight", "clearance")
RAYTRACER += [f"analyse {kind}" for kind in ANALYSES]
RAYTRACER += ["world info", "merge"]
RAYTRACER += [f"farm {name}" for name in ("certs", "status", "pause", "resume")]
RAYTRACER += [f"cluster {name}" for name in ("slurm", "openjd", "kubernetes", "bake")]
RAYTRACER += [f"country {name}" for name in ("plan", "run", "resume", "status")]
PROGRAMS = {name: ("RAYTRACER", *name.split()) for name in RAYTRACER}
PROGRAMS |= {"serve": ("VOXELSERVER",), "survey": ("SURVEY",)}
PROGRAMS |= {f"laz {name}": ("LAZ", name) for name in ("info", "check", "index", "compress")}
PROGRAMS |= {
    f"archive {name}": ("ARCHIVE", name)
    for name in ("info", "verify", "merge", "patch", "split", "stac")
}
# Not started: these read no arguments of their own, or Node.js may be missing.
TEXTS = {
    "terravox": [ROOT / "terravox", *sorted(ROOT.glob("config/setup/*.sh"))],
    "grab": sorted(ROOT.glob("grabber/src/**/*.ts")),
}
COMMANDS = (*TEXTS, *PROGRAMS)


@functools.cache
def options_of(command):
    """@return a text that names each option of a command"""
    if command in TEXTS:
        return "".join(file.read_text(encoding="utf-8") for file in TEXTS[command])
    variable, *words = PROGRAMS[command]
    run = Run([binary(variable), *words, "--help", "all"]).done()
    # Further arguments of the cluster's commands are those of these.
    if command.startswith("cluster "):
        others = ("render", "animate", "analyse sun")
        return run.out + "".join(options_of(other) for other in others)
    return run.out


def has(text, flag):
    """@param flag one that ends in a hyphen stands for all that begin so"""
    end = "" if flag.endswith("-") else r"(?![\w-])"
    return re.search(rf"(?<![\w-]){re.escape(flag)}{end}", text) is not None


def command_of(words):
    """@param words a command line after ./terravox @return its name in COMMANDS"""
    for name in (" ".join(words[:2]), words[0]):
        if name in COMMANDS:
            return name
    return "terravox"


def unknown_in_command(line):
    """@return the options in this line that the program does not have"""
    found = re.search(r"\./terravox ([^|;&#]+)", line)
    flags = [flag for flag in markdown.flags(found[1]) if flag != "--help"] if found else []
    if not flags:
        return []
    text = options_of(command_of(found[1].split()))
    return [flag for flag in flags if not has(text, flag)]


def unknown(flags):
    """@return those that no program has"""
    return [flag for flag in flags if not any(has(options_of(name), flag) for name in COMMANDS)]
