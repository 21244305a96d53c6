#!/usr/bin/env bash
# SQLite 3.46.1 (in the wheel of apsw 3.46.1.0): a connection that is opened read-only makes files
# next to a database in WAL mode, such as a GeoPackage or a map of Luanti, and leaves them there.
#
# A good guess: what is opened read-only leaves its folder as it was. What happens: the first query
# makes NAME-wal and NAME-shm, although the database was closed and has no log, and closing the
# connection does not remove them, since a reader may not. With `immutable=1` there are none, but a
# log that is there is then ignored, and with it the newest data.
#
# Output seen:
#   closed by its writer      map.sqlite
#   read, mode=ro             map.sqlite map.sqlite-shm map.sqlite-wal
#   closed by the reader      map.sqlite map.sqlite-shm map.sqlite-wal
#   read, immutable=1         map.sqlite
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip --quiet --disable-pip-version-check install apsw==3.46.1.0
venv/bin/python - >seen <<'PYTHON'
import os
import shutil

import apsw

assert apsw.sqlitelibversion() == "3.46.1", apsw.sqlitelibversion()


def report(what, folder):
    print(f"{what:25s} {' '.join(sorted(os.listdir(folder)))}")


def read(folder, query):
    flags = apsw.SQLITE_OPEN_READONLY | apsw.SQLITE_OPEN_URI
    connection = apsw.Connection(f"file:{folder}/map.sqlite?{query}", flags=flags)
    assert connection.execute("select count(*) from blocks").fetchall() == [(1,)]
    return connection


os.mkdir("world")
writer = apsw.Connection("world/map.sqlite")
writer.execute("pragma journal_mode = wal")
writer.execute("create table blocks (pos integer primary key, data blob)")
writer.execute("insert into blocks values (1, x'00')")
writer.close()
shutil.copytree("world", "other")
report("closed by its writer", "world")
reader = read("world", "mode=ro")
report("read, mode=ro", "world")
reader.close()
report("closed by the reader", "world")
reader = read("other", "immutable=1")
report("read, immutable=1", "other")
reader.close()
PYTHON
cat seen
diff - seen <<'SEEN'
closed by its writer      map.sqlite
read, mode=ro             map.sqlite map.sqlite-shm map.sqlite-wal
closed by the reader      map.sqlite map.sqlite-shm map.sqlite-wal
read, immutable=1         map.sqlite
SEEN
