#!/usr/bin/env python3
"""The programs are built as config/cmake/CompilerSettings.cmake promises, read from the ELF files.

Control-flow protection is looked for in the code itself. The property that a linker sets when all
of a program is protected does not help: the start files of Debian are not protected, so its linker
never sets it.
"""

import pathlib
import re
import subprocess
import unittest

from support import Case, binary

LEAST_PROGRAMS = 5  # without the window and the benchmarks
ENDBR64 = bytes.fromhex("f30f1efa")


def read_elf(path, *flags):
    return subprocess.run(
        ["readelf", "--wide", *flags, path], capture_output=True, text=True, check=True
    ).stdout


def function_start(path, name):
    """The first four bytes of a function of that name; None where the file has none."""
    symbol = re.search(
        rf"^ *\d+: ([0-9a-f]+) +\d+ FUNC .* {name}$", read_elf(path, "--symbols"), re.MULTILINE
    )
    if not symbol:
        return None
    address = int(symbol[1], 16)
    for start, offset, size in re.findall(
        r"PROGBITS +([0-9a-f]+) ([0-9a-f]+) ([0-9a-f]+)", read_elf(path, "--sections")
    ):
        if int(start, 16) <= address < int(start, 16) + int(size, 16):
            with pathlib.Path(path).open("rb") as file:
                file.seek(int(offset, 16) + address - int(start, 16))
                return file.read(len(ENDBR64))
    return None


def is_x86_64(path):
    return "X86-64" in read_elf(path, "--file-header")


class Hardening(Case):
    @classmethod
    def setUpClass(cls):
        folder = pathlib.Path(binary("RAYTRACER")).parent
        cls.programs = sorted(path for path in folder.glob("terravox-*") if not path.suffix)
        assert len(cls.programs) >= LEAST_PROGRAMS, cls.programs
        cls.worlds = folder / "terravox-worlds.so"
        cls.library = folder.parent / "lib" / "libterravox.so"
        # Empty where the build leaves the Python package out.
        cls.package = sorted(folder.parent.glob("python/terravox/_core*.so"))
        # Those with code that reads strangers' data; terravox-libssl.so only calls OpenSSL.
        cls.readers = [cls.worlds, cls.library, *cls.package]
        cls.modules = sorted({*folder.glob("*.so"), *cls.readers})
        imports = read_elf(cls.programs[0], "--dyn-syms")
        if "__asan_init" in imports or "__tsan_init" in imports:
            raise unittest.SkipTest("a build with sanitizers is not hardened")

    def test_programs_lie_at_random_addresses(self):
        for path in self.programs:
            with self.subTest(path.name):
                self.assertRegex(read_elf(path, "--file-header"), r"Type: +DYN")
                self.assertRegex(read_elf(path, "--dynamic"), r"FLAGS_1.*\bPIE\b")

    def test_the_tables_of_functions_elsewhere_are_filled_at_the_start_and_read_only_from_then_on(
        self,
    ):
        for path in self.programs + self.modules:
            with self.subTest(path.name):
                self.assertRegex(read_elf(path, "--segments"), r"GNU_RELRO")
                self.assertRegex(read_elf(path, "--dynamic"), r"BIND_NOW|FLAGS_1.*\bNOW\b")

    def test_no_stack_holds_code_and_no_segment_is_both_written_and_run(self):
        for path in self.programs + self.modules:
            with self.subTest(path.name):
                segments = read_elf(path, "--segments")
                self.assertRegex(segments, r"GNU_STACK +(0x[0-9a-f]+ +){5}RW +0")
                self.assertNotRegex(segments, r"\bRWE\b")

    def test_no_folder_of_the_build_is_searched_for_libraries(self):
        for path in self.programs + self.modules:
            with self.subTest(path.name):
                for folder in re.findall(
                    r"(?:RPATH|RUNPATH).*\[(.*)\]", read_elf(path, "--dynamic")
                ):
                    self.assertRegex(folder, r"^(\$ORIGIN[^:]*)?$")

    def test_stacks_buffers_and_containers_are_checked(self):
        for path in self.programs + self.readers:
            with self.subTest(path.name):
                imports = read_elf(path, "--dyn-syms")
                self.assertIn("__stack_chk_fail", imports)
                self.assertRegex(imports, r"__\w+_chk@")
                self.assertIn("glibcxx_assert_fail", imports)

    def test_large_frames_touch_each_page_of_the_stack(self):
        for path in self.programs + self.readers:
            with self.subTest(path.name):
                if not is_x86_64(path):
                    self.skipTest("known for x86-64 alone")
                code = subprocess.run(
                    ["objdump", "--disassemble", "--no-show-raw-insn", path],
                    capture_output=True,
                    text=True,
                    check=True,
                ).stdout
                self.assertRegex(
                    code, r"sub +\$0x1000,%rsp\n[^\n]*or[lq] +\$0x0,(0x[0-9a-f]+)?\(%rsp\)"
                )

    def test_functions_of_ours_and_of_laszip_begin_with_a_mark_for_indirect_calls(self):
        if not is_x86_64(self.programs[0]):
            self.skipTest("known for x86-64 alone")
        for path in self.programs:
            with self.subTest(path.name):
                self.assertEqual(function_start(path, "main"), ENDBR64)
        for path in self.package:
            with self.subTest(path.name):
                self.assertEqual(function_start(path, "PyInit__core"), ENDBR64)
        for path in [pathlib.Path(binary("RAYTRACER")), self.worlds, self.library]:
            with self.subTest(path.name):
                self.assertEqual(function_start(path, "laszip_get_version"), ENDBR64)


if __name__ == "__main__":
    unittest.main()
