"""A PostgreSQL server for as long as somebody listens: run as a program, it prints its address.

Prints one line of JSON: ``{"address": "postgresql://…"}``, or ``{"why": "…", "fault": true}`` where
there is none; a fault is one that a machine of continuous integration must not have. The server
ends when the standard input does, so it ends with whoever started it, however that one ended.
"""

import glob
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

KEPT = "/usr/lib/postgresql/*/bin"
OWNER = "markermend"
SETTINGS = {
    # Nothing of it outlives the tests: no waiting for the disk.
    "fsync": "off",
    "synchronous_commit": "off",
    "full_page_writes": "off",
    "shared_buffers": "16MB",
    "max_connections": "150",
    "listen_addresses": "127.0.0.1",
    "unix_socket_directories": "",
    "autovacuum": "off",
}
HOW = ("-A", "trust", "-E", "UTF8", "--locale=C", "--no-sync")
DOORS = """
host all guarded 127.0.0.1/32 scram-sha-256
host all all 127.0.0.1/32 trust
"""


class Absent(Exception):
    """There is no server here, and why; ``fault`` where there should be one."""

    def __init__(self, why: str, *, fault: bool) -> None:
        super().__init__(why)
        self.fault = fault


def programs() -> Path:
    """Give the folder of initdb and postgres; as root, install them where they are missing."""
    for _ in range(2):
        named = shutil.which("initdb")
        for folder in [Path(named).resolve().parent] if named else []:
            if (folder / "postgres").exists():
                return folder
        for found in sorted(glob.glob(KEPT), reverse=True):  # noqa: PTH207  of the whole disk
            if (Path(found) / "initdb").exists():
                return Path(found)
        install()
    raise Absent("PostgreSQL was installed and cannot be found", fault=True)


def install() -> None:
    if shutil.which("apt-get") is None:
        raise Absent("PostgreSQL is not installed, and there is no apt-get", fault=False)
    if os.geteuid() != 0:
        raise Absent("PostgreSQL is not installed: apt-get install postgresql", fault=True)
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    wanted = ["apt-get", "install", "-y", "--no-install-recommends", "postgresql"]
    for command in (wanted, ["apt-get", "update"], wanted):
        done = subprocess.run(command, env=quiet, capture_output=True, text=True, timeout=240)
        if done.returncode == 0 and command is wanted:
            return
    raise Absent(f"apt-get install postgresql failed: {done.stderr.strip()[-200:]}", fault=True)


def as_nobody() -> dict[str, object]:
    """Give the arguments that start a program as somebody without rights: initdb refuses root."""
    if not hasattr(os, "geteuid") or os.geteuid() != 0:
        return {}
    import pwd  # only where there are such users

    for name in ("postgres", "nobody"):
        try:
            known = pwd.getpwnam(name)
        except KeyError:
            continue
        return {"user": known.pw_uid, "group": known.pw_gid, "extra_groups": []}
    raise Absent("there is nobody without rights to run PostgreSQL as", fault=True)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def start(folder: Path, settings: dict[str, str]) -> tuple[subprocess.Popen[bytes], str]:
    """Make a cluster in a folder and start its server; give it with its address."""
    where, who = programs(), as_nobody()
    if who:
        os.chown(folder, int(str(who["user"])), int(str(who["group"])))
    data = folder / "data"
    made = subprocess.run(
        [where / "initdb", "-D", data, "-U", OWNER, *HOW],
        cwd=folder,
        capture_output=True,
        text=True,
        **who,  # type: ignore[call-overload]
    )
    if made.returncode:
        raise Absent(f"initdb failed: {made.stderr.strip()[-300:]}", fault=True)
    (data / "pg_hba.conf").write_text(DOORS)
    for _ in range(3):  # somebody else may take the port in between
        port = free_port()
        options = [part for n, v in settings.items() for part in ("-c", f"{n}={v}")]
        with (folder / "log").open("wb") as log:
            server = subprocess.Popen(
                [where / "postgres", "-D", data, "-p", str(port), *options],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                **who,  # type: ignore[call-overload]
            )
        if ready(server, port, data):
            return server, f"postgresql://{OWNER}@127.0.0.1:{port}/postgres"
    raise Absent(f"postgres did not start: {(folder / 'log').read_text()[-300:]}", fault=True)


def ready(server: subprocess.Popen[bytes], port: int, data: Path) -> bool:
    until = time.monotonic() + 60
    while server.poll() is None and time.monotonic() < until:
        try:
            said = (data / "postmaster.pid").read_text().splitlines()
        except OSError:
            said = []
        if len(said) > 7 and said[3] == str(port) and said[7].strip() == "ready":
            return True
        time.sleep(0.02)
    server.kill()
    server.wait()
    return False


def main() -> None:
    settings = SETTINGS | dict(one.split("=", 1) for one in sys.argv[1:])
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for the tests, which then end us
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    with tempfile.TemporaryDirectory(prefix="markermend-pg-", ignore_cleanup_errors=True) as made:
        try:
            server, address = start(Path(made), settings)
        except (Absent, OSError, subprocess.TimeoutExpired) as absent:
            fault = getattr(absent, "fault", True)
            print(json.dumps({"why": str(absent), "fault": fault}), flush=True)
            return
        print(json.dumps({"address": address, "pid": server.pid}), flush=True)
        sys.stdin.buffer.read()
        server.send_signal(signal.SIGINT)  # a fast shutdown
        try:
            server.wait(timeout=10)
        except subprocess.TimeoutExpired:
            server.send_signal(signal.SIGQUIT)
            server.wait()


if __name__ == "__main__":
    main()
