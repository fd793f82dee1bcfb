"""A Slurm of one node in a folder of its own, on the loopback device alone, without systemd. As root."""
import os
import pathlib
import shutil
import socket
import subprocess
import time

DAEMONS = ("munged", "slurmctld", "slurmd")
CONF = """ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort={port}
SlurmdPort={port1}
SrunPortRange={port2}-{port3}
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
MpiDefault=none
SwitchType=switch/none
SchedulerParameters=sched_interval=1,bf_interval=1,sched_min_interval=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MailProg=/bin/true
KillWait=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 NodeHostname={host} CPUs={cpus} State=UNKNOWN
PartitionName=main Nodes={host} Default=YES MaxTime=60 State=UP
"""


def missing():
    """Why it cannot be started here; empty if it can."""
    if os.geteuid() != 0:
        return "not root"
    absent = [name for name in (*DAEMONS, "sbatch") if not shutil.which(name)]
    return f"no {', '.join(absent)} (Debian: slurmctld slurmd slurm-client munge)" if absent else ""


def free_ports(count):
    """The first of so many ports in a row that nothing listens on."""
    for first in range(26817, 60000, count):
        try:
            for port in range(first, first + count):
                with socket.socket() as s:
                    s.bind(("127.0.0.1", port))
            return first
        except OSError:
            continue
    raise RuntimeError("no free ports")


class Slurm:
    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.env = dict(os.environ, SLURM_CONF=str(self.folder / "slurm.conf"))

    def __enter__(self):
        host, port = socket.gethostname().split(".")[0], free_ports(40)
        self.folder.mkdir(mode=0o755)
        for name, mode in (("state", 0o700), ("spool", 0o755)):
            (self.folder / name).mkdir(mode=mode)
        key = self.folder / "munge.key"
        key.touch(mode=0o600)
        key.write_bytes(os.urandom(128))
        (self.folder / "slurm.conf").write_text(CONF.format(host=host, port=port, port1=port + 1, port2=port + 2, port3=port + 39,
                                                            folder=self.folder, cpus=os.cpu_count()))
        f = self.folder
        self.run("munged", f"--key-file={key}", f"--socket={f}/munge.socket", f"--pid-file={f}/munged.pid", f"--seed-file={f}/seed",
                 f"--log-file={f}/munged.log", "--force")
        self.run("slurmctld", "-f", f / "slurm.conf")
        self.run("slurmd", "-f", f / "slurm.conf", "-N", host)
        self.wait("the node", lambda: self.run("sinfo", "-h", "-o", "%T", check=False).strip() == "idle", 30)
        return self

    def __exit__(self, *_):
        for name in reversed(DAEMONS):
            file = self.folder / f"{name}.pid"
            if not file.exists():
                continue
            pid = int(file.read_text())
            if pathlib.Path(f"/proc/{pid}/comm").read_text().strip() == name:
                os.kill(pid, 15)
                self.wait(f"the end of {name}", lambda: not pathlib.Path(f"/proc/{pid}").exists(), 30)

    def run(self, *words, check=True):
        done = subprocess.run([str(w) for w in words], env=self.env, capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"{words}: code {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def queue(self):
        """Of all jobs: name, task, state."""
        return [line.split() for line in self.run("squeue", "-h", "-r", "-o", "%j %K %T").splitlines()]

    @staticmethod
    def wait(what, true, limit_s):
        end = time.monotonic() + limit_s
        while not true():
            if time.monotonic() > end:
                raise RuntimeError(f"waited {limit_s} s for {what}")
            time.sleep(0.1)
