"""Certificates for tests of TLS."""

import shutil
import subprocess
import unittest

from support import temporary_folder


def self_signed():
    """A certificate of its own authority for localhost and 127.0.0.1, valid for a day.

    @return a folder with key.pem, certificate.pem, and both.pem, which holds both
    @throws unittest.SkipTest
    """
    openssl = shutil.which("openssl")
    if openssl is None:
        raise unittest.SkipTest("openssl is not installed")
    folder = temporary_folder()
    key, certificate, both = (folder / f"{name}.pem" for name in ("key", "certificate", "both"))
    names = "subjectAltName=IP:127.0.0.1,DNS:localhost"
    what = ["-x509", "-days", "1", "-subj", "/CN=localhost", "-addext", names]
    kind = ["-newkey", "rsa:2048", "-nodes"]
    subprocess.run(
        [openssl, "req", *what, *kind, "-keyout", key, "-out", certificate],
        check=True,
        capture_output=True,
    )
    both.write_text(certificate.read_text() + key.read_text())
    return folder
