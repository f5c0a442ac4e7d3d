"""A Slurm of one node of its own: munged, slurmctld and slurmd in a folder, on free ports of this machine, without touching
what the system has. For tests; `with PrivateSlurm(folder) as environment` gives what sbatch and scontrol need."""
import os
import pathlib
import pwd
import shutil
import socket
import subprocess
import time

PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "scontrol", "scancel", "squeue"]
PATH = os.environ.get("PATH", "") + os.pathsep + "/usr/sbin"


def missing_programs():
    return [program for program in PROGRAMS if not shutil.which(program, path=PATH)]


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


class PrivateSlurm:
    def __init__(self, folder, cpus=2):
        self.folder, self.cpus, self.daemons = pathlib.Path(folder), cpus, []

    def start(self, *command):
        log = open(self.folder / f"{pathlib.Path(command[0]).name}.out", "w")
        self.daemons.append(subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, env=self.environment))

    def __enter__(self):
        self.folder.mkdir(parents=True)
        self.folder.chmod(0o755)
        host, user = socket.gethostname().split(".")[0], pwd.getpwuid(os.getuid()).pw_name
        key, munge = self.folder / "munge.key", self.folder / "munge.socket"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        for name in "spool", "state":
            (self.folder / name).mkdir()
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20
        (self.folder / "slurm.conf").write_text(f"""
ClusterName=livermark
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
AuthType=auth/munge
AuthInfo=socket={munge}
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
StateSaveLocation={self.folder}/state
SlurmdSpoolDir={self.folder}/spool
SlurmctldPidFile={self.folder}/slurmctld.pid
SlurmdPidFile={self.folder}/slurmd.pid
SlurmctldLogFile={self.folder}/slurmctld.log
SlurmdLogFile={self.folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs={self.cpus} RealMemory={memory // 2} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self.environment = os.environ | {"PATH": PATH, "SLURM_CONF": str(self.folder / "slurm.conf")}
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={munge}",
                   f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munged.seed",
                   f"--log-file={self.folder}/munged.log")
        wait_for(munge.exists, "munged makes no socket")
        self.start("slurmctld", "-D", "-i")
        self.start("slurmd", "-D", "-N", host)
        wait_for(lambda: "idle" in self.output("sinfo", "--noheader", "--format=%T"), "the node does not become idle")
        return self.environment

    def __exit__(self, *_):
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()

    def output(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True).stdout


def wait_for(is_so, message, seconds=60):
    end = time.monotonic() + seconds
    while not is_so():
        if time.monotonic() > end:
            raise RuntimeError(message)
        time.sleep(0.2)
