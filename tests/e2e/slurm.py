"""A Slurm of this machine alone: munged, slurmctld and some nodes, on ports and in a folder of its
own.

It does not interfere with another Slurm on this machine. Its programs are children that the kernel
ends with this process (PR_SET_PDEATHSIG); processes that a node has started are found by their
environment.
"""

import contextlib
import ctypes
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import time

from support import hold_port

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "scontrol"]


def why_not():
    """Why no cluster can be started here; empty: it can."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    missing = [p for p in PROGRAMS if not shutil.which(p, path=path)]
    if missing:
        return f"not installed: {', '.join(missing)} (packages slurm-wlm, munge)"
    return "" if os.geteuid() == 0 else "a cluster of its own can be started by root alone"


def _die_with_parent():
    ctypes.CDLL(None).prctl(1, signal.SIGKILL)


def _processes():
    """Of every process that can be looked at: its number, environment, and command line."""
    for entry in pathlib.Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                yield (
                    int(entry.name),
                    (entry / "environ").read_bytes(),
                    (entry / "cmdline").read_bytes(),
                )
            except OSError:
                continue


class Cluster:
    def __init__(self, folder, nodes=4, cpus=1):
        self.folder = pathlib.Path(folder)
        self.names = [f"n{i + 1}" for i in range(nodes)]
        self._daemons = {}
        ports = [hold_port() for _ in range(nodes + 1)]
        host = socket.gethostname().split(".")[0]
        self.folder.chmod(0o755)
        (self.folder / "munge.key").write_bytes(os.urandom(256))
        (self.folder / "munge.key").chmod(0o600)
        self._munge = self.folder / "munge.socket"
        lines = [
            f"ClusterName=terravox{ports[0]}",
            f"SlurmctldHost={host}(127.0.0.1)",
            f"SlurmctldPort={ports[0]}",
            "SlurmUser=root",
            "SlurmdUser=root",
            "AuthType=auth/munge",
            f"AuthInfo=socket={self._munge}",
            "CredType=cred/munge",
            f"StateSaveLocation={self.folder}/state",
            f"SlurmctldPidFile={self.folder}/ctld.pid",
            f"SlurmctldLogFile={self.folder}/ctld.log",
            f"SlurmdSpoolDir={self.folder}/spool.%n",
            f"SlurmdPidFile={self.folder}/slurmd.%n.pid",
            f"SlurmdLogFile={self.folder}/slurmd.%n.log",
            "ProctrackType=proctrack/linuxproc",
            "TaskPlugin=task/none",
            "JobAcctGatherType=jobacct_gather/none",
            "AccountingStorageType=accounting_storage/none",
            "MpiDefault=none",
            "SelectType=select/cons_tres",
            "SelectTypeParameters=CR_Core",
            "SchedulerType=sched/backfill",
            "SchedulerParameters=batch_sched_delay=1,sched_min_interval=200000,bf_interval=1",
            "ReturnToService=2",
            "SlurmdTimeout=5",
            "KillWait=5",
            "SlurmdParameters=config_overrides",
            "MinJobAge=300",
            *(
                f"NodeName={n} NodeHostname={host} NodeAddr=127.0.0.1 Port={p} "
                f"CPUs={cpus} RealMemory=2000"
                for n, p in zip(self.names, ports[1:])
            ),
            (
                f"PartitionName=main Nodes={','.join(self.names)} Default=YES "
                "MaxTime=INFINITE State=UP"
            ),
        ]
        self.conf = self.folder / "slurm.conf"
        self.conf.write_text("\n".join(lines) + "\n")
        self.environment = {"SLURM_CONF": str(self.conf)}

    def __enter__(self):
        try:
            files = {"key-file": "munge.key", "pid-file": "munge.pid", "log-file": "munge.log"}
            files |= {"socket": self._munge.name, "seed-file": "munge.seed"}
            flags = [f"--{flag}={self.folder}/{name}" for flag, name in files.items()]
            self._start("munged", "munged", "--foreground", "--force", *flags)
            self._until(self._munge.exists, "munged")
            self._start("slurmctld", "slurmctld", "-D", "-f", self.conf)
            for name in self.names:
                self.start_node(name)
            self._until(
                lambda: self.run("sinfo", "-h", "-o", "%T").split() == ["idle"], "all nodes"
            )
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def _start(self, name, *command):
        environment = {
            **os.environ,
            **self.environment,
            "PATH": os.environ.get("PATH", "") + ":/usr/sbin:/sbin",
        }
        with (self.folder / f"{name}.said").open("ab") as said:
            self._daemons[name] = subprocess.Popen(
                [str(c) for c in command],
                stdout=said,
                stderr=said,
                stdin=subprocess.DEVNULL,
                env=environment,
                preexec_fn=_die_with_parent,
            )

    def start_node(self, name):
        self._start(name, "slurmd", "-D", "-f", self.conf, "-N", name)

    def _until(self, done, what, timeout_s=40):
        deadline = time.monotonic() + timeout_s
        while not done():
            if time.monotonic() > deadline or any(
                d.poll() is not None for d in self._daemons.values()
            ):
                said = "\n".join(
                    f"--- {f.name}\n{f.read_text(errors='replace')[-2000:]}"
                    for f in sorted(self.folder.glob("*.said")) + sorted(self.folder.glob("*.log"))
                )
                raise AssertionError(f"start the cluster: {what} did not come up\n{said}")
            time.sleep(0.1)

    def run(self, *command, timeout_s=20):
        """A command of Slurm. @return its output; empty when it fails"""
        return subprocess.run(
            [str(c) for c in command],
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
            env={**os.environ, **self.environment},
        ).stdout

    def tasks(self):
        """What is in the queue: (job, number in its array, name, state, node)"""
        return [
            tuple(line.split("|"))
            for line in self.run(
                "squeue", "--noheader", "--array", "--format=%F|%K|%j|%T|%N"
            ).splitlines()
        ]

    def children_of_node(self, name):
        """Processes that a node started for tasks: the stepd, scripts, programs."""
        out = []
        for pid, environment, command in _processes():
            is_task = (
                b"SLURMD_NODENAME=" + name.encode() + b"\0" in environment
                and bytes(self.conf) in environment
            )
            is_stepd = command.startswith(b"slurmstepd")
            if is_task or (is_stepd and self._node_of_stepd(pid) == name):
                out.append(pid)
        return out

    def _node_of_stepd(self, pid):
        """slurmstepd does not show its node; its children have it in their environment."""
        try:
            children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
            for child in children:
                environment = pathlib.Path(f"/proc/{child}/environ").read_bytes()
                found = re.search(rb"SLURMD_NODENAME=([^\0]*)", environment)
                if found and bytes(self.conf) in environment:
                    return found[1].decode()
        except OSError:
            pass
        return None

    def kill_node(self, name):
        """As if its machine had lost power: the daemon and everything it started, at once."""
        victims = self.children_of_node(name)
        daemon = self._daemons.pop(name)
        for pid in [daemon.pid, *victims]:
            _kill(pid)
        daemon.wait()

    def stop(self):
        if "slurmctld" in self._daemons and self._daemons["slurmctld"].poll() is None:
            try:
                self.run("scancel", "--quiet", "--user=root")
                deadline = time.monotonic() + 10
                while self.tasks() and time.monotonic() < deadline:
                    time.sleep(0.2)
            except subprocess.TimeoutExpired:
                pass
        for name in reversed(list(self._daemons)):
            self._daemons[name].kill()
            self._daemons[name].wait()
        self._daemons.clear()
        for pid, environment, command in list(_processes()):
            if (
                pid != os.getpid()
                and bytes(self.conf) in environment
                and (b"SLURM_JOB_ID=" in environment or command.startswith(b"slurmstepd"))
            ):
                _kill(pid)


def _kill(pid):
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)
