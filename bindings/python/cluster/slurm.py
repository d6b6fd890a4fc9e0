#!/usr/bin/env python3
"""A sweep on a real Slurm of one node: a job is cancelled in the middle, the run goes on, and the table stays that of one process.

    PYTHON bindings/python/cluster/slurm.py

Starts munged, slurmctld and slurmd in a folder of their own, and ends them. Needs root, pennate[cluster], and Debian's packages
slurm-wlm and munge. Ends with status 1 where the table is not that of one process, byte for byte.
"""

from __future__ import annotations

import contextlib
import logging
import os
import pathlib
import re
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator

import distributed
from dask_jobqueue import SLURMCluster
from workers import FEWER, STAGES

import pennate

# One node of two cores. Nothing of it asks for cgroups, which containers do not let others have.
CONFIGURATION = """\
ClusterName=check
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CryptoType=crypto/munge
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SchedulerParameters=sched_interval=1,batch_sched_delay=0
KillWait=2
ReturnToService=2
NodeName=check NodeHostname={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=check Nodes=check Default=YES MaxTime=60 State=UP
"""


def main() -> int:
    """The run, and the exit status."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    # Who ends this ends the daemons with it.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    missing = [program for program in ("munged", "slurmctld", "slurmd", "sbatch") if shutil.which(program) is None]
    if missing or os.geteuid():
        print("this check needs root, and slurm-wlm and munge: no", ", ".join(missing) or "root", file=sys.stderr)
        return 2
    network = pennate.scene("stage")
    with tempfile.TemporaryDirectory() as one, tempfile.TemporaryDirectory(prefix="slurm-") as folder:
        pennate.sweep(network, FEWER, output=one, threads=1)
        table = pathlib.Path(one, "sweep.csv").read_bytes()
        begin = time.perf_counter()
        with slurm(pathlib.Path(folder)):
            print(
                f"Slurm is there after {time.perf_counter() - begin:.1f} s: {told('sinfo', '-h', '-o', '%N %C %T')}", flush=True
            )
            found = cancelled(network, pathlib.Path(folder))
            times(network, pathlib.Path(folder))
    same = found == table
    print(f"{len(table.splitlines()) - 1} rows {'the same bytes as those of one process' if same else 'MISSED: another table'}")
    return int(not same)


def cluster(folder: pathlib.Path) -> SLURMCluster:
    """Jobs of one core with one worker each, as anyone would ask for them."""
    return SLURMCluster(
        queue="check",
        cores=1,
        processes=1,
        memory="1GB",
        walltime="00:30:00",
        job_directives_skip=["--mem"],
        interface="lo",
        local_directory=str(folder),
        log_directory=str(folder),
        python=sys.executable,
        job_script_prologue=["export DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False"],
        scheduler_options={"dashboard_address": ":0"},
        worker_extra_args=["--no-dashboard"],
    )


def cancelled(network: pennate.Network, folder: pathlib.Path) -> bytes:
    """A run of two jobs, one of which is cancelled when a third of the designs is known; the table."""
    ended: list[str] = []

    def heard(known: int, count: int) -> None:
        if known >= count / 3 and not ended:
            ended.extend(jobs()[:1])
            subprocess.run(["scancel", ended[0]], check=True)

    with cluster(folder) as asked, distributed.Client(asked) as client:
        # Two jobs, whatever happens to them.
        asked.adapt(minimum=2, maximum=2)
        client.wait_for_workers(2, timeout=120)
        before = jobs()
        begin = time.perf_counter()
        out = folder / "out"
        table = pennate.sweep(network, FEWER, executor=client.get_executor(), output=out, chunk=40, progress=heard)
        took = time.perf_counter() - begin
        client.wait_for_workers(2, timeout=60)
        print(f"jobs {' '.join(before)}, of which {ended[0]} was cancelled; {took:.1f} s; then jobs {' '.join(jobs())}")
        print(f"lost: {', '.join(table.attrs['losses']) or 'nothing that dask did not send again by itself'}", flush=True)
        return (out / "sweep.csv").read_bytes()


def times(network: pennate.Network, folder: pathlib.Path) -> None:
    """10,000 stages by one job and by two."""
    took = {}
    with cluster(folder) as asked, distributed.Client(asked) as client:
        for count in (1, 2):
            asked.scale(jobs=count)
            client.wait_for_workers(count, timeout=120)
            executor = client.get_executor()
            pennate.sweep(network, FEWER, executor=executor)
            begin = time.perf_counter()
            pennate.sweep(network, STAGES, executor=executor)
            took[count] = time.perf_counter() - begin
    print(f"10,000 stages: {took[1]:.1f} s by one job, {took[2]:.1f} s by two, {took[1] / took[2]:.2f} times as fast", flush=True)


def told(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def jobs() -> list[str]:
    """Those that run or wait."""
    return told("squeue", "-h", "-o", "%i").split()


@contextlib.contextmanager
def slurm(folder: pathlib.Path) -> Iterator[None]:
    """The daemons, until the end of the block."""
    host = socket.gethostname().partition(".")[0]
    for name in ("munge", "state", "spool"):
        (folder / name).mkdir(mode=0o755)
    key = folder / "munge" / "key"
    key.write_bytes(secrets.token_bytes(1024))
    key.chmod(0o400)
    folder.chmod(0o755)
    configuration = folder / "slurm.conf"
    configuration.write_text(CONFIGURATION.format(host=host, folder=folder, ports=ports(2)), encoding="ascii")
    os.environ["SLURM_CONF"] = str(configuration)
    munge = folder / "munge"
    files = [f"--{what}-file={munge}/{what}" for what in ("key", "pid", "log", "seed")]
    with contextlib.ExitStack() as running:
        running.enter_context(daemon(folder, "munged", "--foreground", "--force", f"--socket={munge}/socket", *files))
        wait(lambda: (munge / "socket").exists(), folder, "munged")
        running.enter_context(daemon(folder, "slurmctld", "-D", "-f", str(configuration)))
        running.enter_context(daemon(folder, "slurmd", "-D", "-N", "check", "-f", str(configuration)))
        running.callback(end_jobs)
        wait(is_idle, folder, "slurmctld and slurmd")
        yield


@contextlib.contextmanager
def daemon(folder: pathlib.Path, *command: str) -> Iterator[None]:
    """A program in the background, until the end of the block."""
    with (folder / f"{command[0]}.out").open("w") as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, start_new_session=True)
        try:
            yield
        finally:
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def is_idle() -> bool:
    """Whether the node takes work."""
    found = subprocess.run(["sinfo", "-h", "-o", "%T"], check=False, capture_output=True, text=True).stdout
    return re.fullmatch(r"idle\s*", found) is not None


def end_jobs() -> None:
    """Cancels what is left, and waits until it is gone."""
    subprocess.run(["scancel", "--user=root"], check=False)
    end = time.monotonic() + 30
    while jobs() and time.monotonic() < end:
        time.sleep(0.5)


def wait(holds: Callable[[], bool], folder: pathlib.Path, what: str, most: float = 60.0) -> None:
    """Waits until something holds, or shows what the daemons wrote."""
    end = time.monotonic() + most
    while not holds():
        if time.monotonic() > end:
            for log in (*sorted(folder.glob("*.log")), *sorted(folder.glob("*.out")), folder / "munge" / "log"):
                print(f"{log.name}:", *log.read_text(errors="replace").splitlines()[-20:], sep="\n    ", file=sys.stderr)
            raise TimeoutError(f"{what} did not come up within {most:g} s")
        time.sleep(0.2)


def ports(count: int) -> list[int]:
    """Some that are free."""
    with contextlib.ExitStack() as held:
        sockets = [held.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


if __name__ == "__main__":
    sys.exit(main())
