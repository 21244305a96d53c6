"""Reads the project's Markdown pages: blocks of code, links, headings, and named options.

A comment before a block controls what the documents test does with it. Readers do not see it:

    <!-- not run: REASON -->          leave it out
    <!-- file: NAME -->               it is the content of this file
    <!-- needs: PROGRAM -->           run it only where this program is installed
    <!-- background: TEXT -->         leave it running once it has printed a line with this text
    <!-- wait -->                     after it, the command in the background must end on its own
    <!-- exit code: N -->             what it must end with, instead of 0
"""

import dataclasses
import pathlib
import re

MARKS = ("not run", "file", "needs", "background", "wait", "exit code")
_COMMENT = re.compile(r"^<!-- ([a-z ]+?)(?:: (.+?))? -->$")
_FENCE = re.compile(r"^(```+|~~~+)")
_LINK = re.compile(r"\]\(([^()\s]+(?:\([^()\s]*\))?)(?: \"[^\"]*\")?\)")
_SPAN = re.compile(r"(`+)(.+?)\1")
_FLAG = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]*")


@dataclasses.dataclass
class Block:
    page: pathlib.Path
    line: int  # of its first line, from 1 on
    text: str
    marks: dict

    def __str__(self):
        return f"{self.page}:{self.line}"


def read(page):
    """@return the lines of prose, those of code left empty; and the blocks of code"""
    lines = page.read_text(encoding="utf-8").splitlines()
    prose, blocks, marks = [], [], {}
    at = 0
    while at < len(lines):
        begin = at
        if fence := _FENCE.match(lines[at]):
            at += 1
            while at < len(lines) and not lines[at].startswith(fence.group()):
                at += 1
            body = lines[begin + 1 : at]
            at += 1
        elif lines[at].startswith("    ") and (at == 0 or not lines[at - 1].strip()):
            while at < len(lines) and (lines[at].startswith("    ") or not lines[at].strip()):
                at += 1
            body = [line[4:] for line in lines[begin:at]]
        else:
            marks = _mark(page, at, lines[at], marks)
            prose.append(lines[at])
            at += 1
            continue
        blocks.append(Block(page, begin + 1, "\n".join(body).rstrip() + "\n", marks))
        prose += [""] * (at - begin)
        marks = {}
    return prose, blocks


def _mark(page, at, line, marks):
    """@return the marks that hold for a block that comes next"""
    comment = _COMMENT.match(line)
    if comment:
        if comment[1] not in MARKS:
            raise ValueError(f"{page}:{at + 1}: '{comment[1]}'; allowed: {', '.join(MARKS)}")
        return {**marks, comment[1]: comment[2] or ""}
    return {} if line.strip() else marks


def _without_code(prose):
    return [_SPAN.sub("", line) for line in prose]


def links(page):
    """@return (line, target) of each link and picture"""
    prose, _ = read(page)
    return [
        (number, target)
        for number, line in enumerate(_without_code(prose), 1)
        for target in _LINK.findall(line)
    ]


def anchors(page):
    """@return what can stand after the # of a link to this page"""
    prose, _ = read(page)
    found = set()
    for line in prose:
        if not (heading := re.match(r"#{1,6} +(.+?) *#*$", line)):
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading[1]).replace("`", "")
        slug = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
        count = 0
        while (name := slug if count == 0 else f"{slug}-{count}") in found:
            count += 1
        found.add(name)
    return found


def broken_links(page, root):
    """@return a line for each link that leads nowhere; addresses on the web are not visited"""
    out = []
    for number, target in links(page):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        there = (page.parent / name).resolve() if name else page.resolve()
        where = f"{page.relative_to(root)}:{number}: {target}"
        if not there.exists():
            out.append(f"{where}: no such file")
        elif not there.is_relative_to(root.resolve()):
            out.append(f"{where}: outside the repository")
        elif anchor and (there.suffix != ".md" or anchor not in anchors(there)):
            out.append(f"{where}: no such heading")
    return out


def spans(page):
    """@return (line, text) of all code within prose"""
    prose, _ = read(page)
    return [
        (number, span[1]) for number, line in enumerate(prose, 1) for span in _SPAN.findall(line)
    ]


def flags(text):
    return _FLAG.findall(text)


def commands(block):
    """@return the command lines of a block: without comments, with continued lines joined"""
    lines = re.sub(r"\\\n\s*", "", block.text).splitlines()
    return [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
