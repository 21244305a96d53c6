"""nginx: config/nginx before a voxel server, and files as they are."""

import os
import re
import shutil
import subprocess
import time

from support import HANGS_S, ROOT, hold_port, temporary_folder
from wire import connect

# The last is where ./terravox test unpacks it.
FOLDERS = ("/usr/sbin", "/usr/local/sbin", f"{ROOT}/build/deps/nginx/usr/sbin")
NGINX = shutil.which("nginx", path=":".join([os.environ.get("PATH", ""), *FOLDERS]))
STATIC = """
pid nginx.pid; error_log error.log; worker_processes 1; worker_rlimit_nofile 4096;
events {{ worker_connections 2048; }}
http {{
    access_log off; sendfile on; tcp_nodelay on; keepalive_timeout 60s; keepalive_requests 1000000;
    types {{ application/vnd.terravox.archive tvx; }}
    client_body_temp_path body; proxy_temp_path proxy; fastcgi_temp_path fastcgi;
    uwsgi_temp_path uwsgi; scgi_temp_path scgi;
    server {{ listen 127.0.0.1:{port} backlog=4096; root {root}; }}
}}
"""


class Nginx:
    """A process in a folder of its own, which holds its configuration, nginx.conf."""

    def __init__(self):
        self.port = hold_port()
        self.folder = temporary_folder()
        self.folder.chmod(0o755)  # started by root, nginx works as another user
        self.command = [
            NGINX,
            "-p",
            self.folder,
            "-e",
            "error.log",
            "-c",
            self.folder / "nginx.conf",
        ]
        self.process = None

    def __enter__(self):
        self.process = subprocess.Popen(
            [*self.command, "-g", "daemon off;"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        until = time.monotonic() + HANGS_S
        while time.monotonic() < until:
            try:
                connect(self.port).close()
                return self
            except OSError:
                time.sleep(0.02)
        self.__exit__()
        raise AssertionError("nginx did not start: " + self.log())

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(HANGS_S)

    def log(self):
        file = self.folder / "error.log"
        return file.read_text() if file.exists() else ""


class Static(Nginx):
    """Gives the files of a folder."""

    def __init__(self, root):
        super().__init__()
        (self.folder / "nginx.conf").write_text(STATIC.format(port=self.port, root=root))


class Front(Nginx):
    """config/nginx, its ports replaced."""

    def __init__(self, server_port, instead=()):
        """@param instead pairs of what stands once in terravox.conf, and what stands there then"""
        super().__init__()
        for file in (ROOT / "config" / "nginx").glob("*.conf"):
            text = file.read_text()
            if file.name == "terravox.conf":
                text, listens = re.subn(
                    r"listen 127\.0\.0\.1:8080", f"listen 127.0.0.1:{self.port}", text
                )
                text, servers = re.subn(
                    r"server 127\.0\.0\.1:8888", f"server 127.0.0.1:{server_port}", text
                )
                assert (listens, servers) == (1, 1), (
                    "terravox.conf has other ports than this test replaces"
                )
                for words, others in instead:
                    assert text.count(words) == 1, (
                        f"terravox.conf has '{words}' {text.count(words)} times"
                    )
                    text = text.replace(words, others)
            (self.folder / file.name).write_text(text)
